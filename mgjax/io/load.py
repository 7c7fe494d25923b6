"""Loading a motion from any file that is understood."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from mgjax.core.errors import FileFormatError
from mgjax.core.motion import Motion
from mgjax.core.shown import made_of
from mgjax.core.skeleton import Skeleton
from mgjax.io.acclaim.amc import find_asf, read_amc
from mgjax.io.acclaim.asf import read_asf
from mgjax.io.amass.read import is_amass, read_amass
from mgjax.io.bvh.read import read_bvh
from mgjax.io.gltf.read import read_glb
from mgjax.io.npz.read import read_npz
from mgjax.io.reading.capture import Capture
from mgjax.io.reading.interpret import interpret
from mgjax.io.reading.raw import settled
from mgjax.io.reading.read_as import ReadAs, validate_read_as

SUFFIXES = (".bvh", ".amc", ".glb", ".vrma", ".npz")


def load_motion(
    path: str | Path,
    *,
    frame_rate: float | None = None,
    units: str | None = None,
    read_as: ReadAs | None = None,
) -> tuple[Skeleton, Motion]:
    """Loads a ``.bvh``, ``.glb``, ``.vrma`` or ``.npz`` file, or an ``.amc`` with its ``.asf``.

    No frame is dropped, repaired or refused. Arrays are NumPy float32, in metres and radians, Y up,
    with the floor at 0 where feet show where it is, and the hips as the root.

    Args:
        path: the file.
        frame_rate: frames per second at which the file was captured, instead of what it states
            (BVH, NPZ) or of 120 (AMC states none). Frames stay as they are; see ``resample`` in
            :mod:`mgjax.core.motion` for another rate. GLB has times, not frames: it is sampled at
            this rate.
        units: ``"m"``, ``"cm"``, ``"mm"``, ``"dm"``, ``"in"``, ``"ft"`` or ``"cmu"``; by default
            the unit in which the limbs are those of a body.
        read_as: whatever else is known of the file.

    Raises:
        FileFormatError: with file, line, what was got and what was expected.
        ConfigError: an argument means nothing.
    """
    read_as = read_as or ReadAs()
    read_as = replace(
        read_as,
        units=read_as.units if units is None else units,
        frame_rate=read_as.frame_rate if frame_rate is None else frame_rate,
    )
    capture = read_capture(path, read_as)
    return capture.skeleton, made_of(capture.motion, capture.skeleton)


def read_capture(path: str | Path, read_as: ReadAs | None = None) -> Capture:
    """Like :func:`load_motion`, with what was found about unit, axes, floor and root."""
    read_as = read_as or ReadAs()
    validate_read_as(read_as)
    suffix = Path(path).suffix.lower()
    if suffix == ".bvh":
        raw = read_bvh(path)
    elif suffix == ".amc":
        raw = read_amc(path, read_asf(read_as.asf or find_asf(path), read_as.units))
    elif suffix in (".glb", ".vrma"):
        raw = read_glb(path, frame_rate=read_as.frame_rate)
    elif suffix == ".npz" and is_amass(path):
        rate, model = read_as.frame_rate, read_as.body_model
        raw = settled(path, *read_amass(path, body_model=model, frame_rate=rate))
    elif suffix == ".npz":
        raw = settled(path, *read_npz(path))
    else:
        expected = f"one of {', '.join(SUFFIXES)}"
        raise FileFormatError(path, None, f"a file of type {suffix!r}", expected)
    if read_as.frame_rate is not None:
        raw = replace(raw, frame_rate=float(read_as.frame_rate))
    return interpret(raw, read_as)
