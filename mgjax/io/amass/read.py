"""Reading ``.npz`` files of AMASS (Mahmood et al., AMASS, 2019): poses of the SMPL body."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mgjax.core import quaternion
from mgjax.core.errors import FileFormatError, MotionError, SkeletonError
from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, validate_skeleton
from mgjax.io.amass.hierarchy import JOINTS_OF_WIDTH, NAMES, OFFSETS, PARENTS
from mgjax.io.amass.model import model_joints
from mgjax.io.npz.arrays import array_names, numbers, read_arrays
from mgjax.io.text import MAX_PLACE_M, check_size, unfit

_KIND = "motion of AMASS"
_RATES = ("mocap_framerate", "mocap_frame_rate")
_Y_UP = np.array([np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0])
"""A quarter turn about x, which turns z up into y up."""


def is_amass(path: str | Path) -> bool:
    """Whether an ``.npz`` file has the keys of AMASS; False if it cannot be read."""
    try:
        return {"poses", "trans"} <= array_names(path, _KIND)
    except FileFormatError:
        return False


def read_amass(
    path: str | Path,
    *,
    body_model: str | Path | None = None,
    frame_rate: float | None = None,
) -> tuple[Skeleton, Motion]:
    """Reads body poses: 22 joints, or 24 where the file is of plain SMPL.

    ``poses`` [F,66 | 72 | 156 | 165] are axis-angle vectors, ``trans`` [F,3] the model's place,
    ``mocap_framerate`` or ``mocap_frame_rate`` the rate. AMASS has z up; the motion is turned to y
    up. The pelvis lies at ``trans`` plus its place in the model, which the pose does not turn.
    Fingers, jaw, eyes, soft tissue and markers are not read.

    Args:
        path: the file.
        body_model: ``.npz`` file of the SMPL body that the motion was made with, see
            :func:`mgjax.io.amass.model.model_joints`; only with it do bones have the lengths of
            the person (``betas``). Without it they are those of a rough adult of 1.7 m: joint
            angles are exact, places are not, and feet may slide.
        frame_rate: frames per second, instead of what the file states.

    Raises:
        FileFormatError: names the file, the key, what stands there and what was expected.
    """
    arrays = read_arrays(path, ("poses", "trans", "betas", *_RATES), _KIND)
    poses, joints = _poses(path, arrays)
    trans = numbers(path, arrays, "trans", (len(poses), 3))
    if trans.size and np.abs(trans).max() > MAX_PLACE_M:
        raise FileFormatError(path, None, "'trans' too far away", f"at most {MAX_PLACE_M:g} m")
    offsets = OFFSETS[:joints]
    if body_model is not None:
        betas = numbers(path, arrays, "betas", ("B",)) if "betas" in arrays else None
        places = model_joints(body_model, joints, betas)
        offsets = np.concatenate([places[:1], places[1:] - places[list(PARENTS[1:joints])]])
    rate = frame_rate if frame_rate is not None else _stated_rate(path, arrays)
    rotations = _quaternions(poses.reshape(-1, joints, 3))
    rotations[:, 0] = quaternion.multiply(_Y_UP, rotations[:, 0])
    skeleton = Skeleton(
        names=NAMES[:joints], parents=PARENTS[:joints], offsets=offsets.astype(np.float32)
    )
    motion = Motion(
        root_translation=quaternion.rotate(_Y_UP, offsets[0] + trans).astype(np.float32),
        local_rotations=rotations.astype(np.float32),
        frame_rate=float(rate),
    )
    try:
        validate_skeleton(skeleton)
        validate_motion(skeleton, motion)
    except (SkeletonError, MotionError) as error:
        raise unfit(path, error) from None
    return skeleton, motion


def _poses(path: str | Path, arrays: dict[str, np.ndarray]) -> tuple[np.ndarray, int]:
    """The columns of the joints that are read, and how many joints these are."""
    widths = ", ".join(map(str, JOINTS_OF_WIDTH))
    poses = numbers(path, arrays, "poses", ("F", widths))
    if poses.shape[1] not in JOINTS_OF_WIDTH:
        raise FileFormatError(path, None, f"'poses' of width {poses.shape[1]}", f"one of {widths}")
    joints = JOINTS_OF_WIDTH[poses.shape[1]]
    check_size(path, len(poses), joints)
    return poses[:, : 3 * joints], joints


def _stated_rate(path: str | Path, arrays: dict[str, np.ndarray]) -> float:
    key = next((key for key in _RATES if key in arrays), _RATES[0])
    return float(numbers(path, arrays, key, ()))


def _quaternions(vectors: np.ndarray) -> np.ndarray:
    """Rotations from axis-angle vectors [...,3], rad."""
    angles = np.linalg.norm(vectors, axis=-1)
    axes = vectors / np.where(angles > 1e-12, angles, 1.0)[..., None]
    return np.asarray(quaternion.from_axis_angle(axes, angles))
