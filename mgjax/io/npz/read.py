"""Reading a motion from named arrays; see :mod:`mgjax.io.npz` for the keys."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mgjax.core.errors import FileFormatError, MotionError, SkeletonError
from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, validate_skeleton
from mgjax.io.npz import KEYS, VERSION
from mgjax.io.npz.arrays import array_names, numbers, read_arrays
from mgjax.io.text import check_size, quoted, unfit

_KIND = "motion as .npz"


def holds_no_motion(path: str | Path) -> bool:
    """Whether an ``.npz`` file can be read and has neither our arrays nor those of AMASS."""
    try:
        names = array_names(path, _KIND)
    except FileFormatError:
        return False
    return not ({"quaternions", "root"} <= names or {"poses", "trans"} <= names)


def read_npz(path: str | Path, *, frame_rate: float | None = None) -> tuple[Skeleton, Motion]:
    """Reads a motion that :func:`mgjax.io.npz.write.save_npz` wrote.

    Args:
        path: the file.
        frame_rate: frames per second, instead of what the file states.

    Raises:
        FileFormatError: names the file, the key, what stands there and what was expected.
    """
    present = array_names(path, _KIND)
    if not present >= set(KEYS):
        got = "arrays " + ", ".join(sorted(quoted(name) for name in present)[:12])
        expected = f"{', '.join(KEYS)}, or poses and trans of AMASS"
        raise FileFormatError(path, None, got if present else "no arrays", expected)
    arrays = read_arrays(path, (*KEYS, "joint_offsets"), _KIND)
    version = float(numbers(path, arrays, "version", ()))
    if version != VERSION:
        raise FileFormatError(path, None, f"version {version:g}", f"version {VERSION}")
    skeleton = _skeleton(path, arrays)
    joints = skeleton.num_joints
    rotations = _rotations(path, arrays, joints)
    frames, moving = len(rotations), None
    if "joint_offsets" in arrays:
        moving = numbers(path, arrays, "joint_offsets", (frames, joints, 3)).astype(np.float32)
    rate = frame_rate if frame_rate is not None else float(numbers(path, arrays, "fps", ()))
    motion = Motion(
        root_translation=numbers(path, arrays, "root", (frames, 3)).astype(np.float32),
        local_rotations=rotations.astype(np.float32),
        frame_rate=float(rate),
        joint_offsets=moving,
    )
    try:
        validate_skeleton(skeleton)
        validate_motion(skeleton, motion)
    except (SkeletonError, MotionError) as error:
        raise unfit(path, error) from None
    return skeleton, motion


def _skeleton(path: str | Path, arrays: dict[str, np.ndarray]) -> Skeleton:
    names = arrays["names"]
    if names.ndim != 1 or names.dtype.kind != "U":
        got = f"'names' of shape {list(names.shape)} and type {names.dtype}"
        raise FileFormatError(path, None, got, "texts of shape [J]")
    joints = len(names)
    return Skeleton(
        names=tuple(str(name) for name in names),
        parents=_indices(path, arrays, "parents", joints, -1, joints),
        offsets=numbers(path, arrays, "offsets", (joints, 3)).astype(np.float32),
        end_joints=_indices(path, arrays, "end_joints", "K", 0, joints),
    )


def _rotations(path: str | Path, arrays: dict[str, np.ndarray], joints: int) -> np.ndarray:
    rotations = numbers(path, arrays, "quaternions", ("F", joints, 4))
    check_size(path, len(rotations), joints)
    lengths = np.linalg.norm(rotations, axis=-1)
    if rotations.size and not (np.abs(lengths - 1) < 1e-3).all():
        worst = float(lengths.flat[int(np.argmax(np.abs(lengths - 1)))])
        raise FileFormatError(path, None, f"a quaternion of length {worst:g}", "unit quaternions")
    # Those that are unit up to float32 stay just as they are.
    return np.where(
        np.abs(lengths - 1)[..., None] <= 5e-6, rotations, rotations / lengths[..., None]
    )


def _indices(
    path: str | Path,
    arrays: dict[str, np.ndarray],
    name: str,
    size: int | str,
    least: int,
    stop: int,
) -> tuple[int, ...]:
    values = numbers(path, arrays, name, (size,))
    bad = values[(values != np.round(values)) | (values < least) | (values >= stop)]
    if bad.size:
        got = f"{quoted(f'{bad[0]:g}')} in {name!r}"
        raise FileFormatError(path, None, got, f"whole numbers, {least} … {stop - 1}")
    return tuple(int(value) for value in values)
