"""Loading a motion from any file that is understood."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mgjax.core.errors import ConfigError, FileFormatError
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.acclaim.amc import find_asf, read_amc
from mgjax.io.acclaim.asf import read_asf
from mgjax.io.bvh.read import read_bvh
from mgjax.io.units import Unit

SUFFIXES = (".bvh", ".amc")


@dataclass(frozen=True, kw_only=True)
class Capture:
    """A file's skeleton and motion, and the unit it was found to be in."""

    skeleton: Skeleton
    motion: Motion
    unit: Unit


def load_motion(
    path: str | Path, *, frame_rate: float | None = None, units: str | None = None
) -> tuple[Skeleton, Motion]:
    """Loads a ``.bvh`` file, or an ``.amc`` file with its ``.asf`` beside it.

    No frame is dropped, repaired or refused. Arrays are NumPy float32, in metres and radians.

    Args:
        path: the file.
        frame_rate: frames per second at which the file was captured, instead of what it states
            (BVH) or of 120 (AMC states none). Frames stay as they are; see ``resample`` in
            :mod:`mgjax.core.motion` for another rate.
        units: ``"m"``, ``"cm"`` or ``"cmu"`` for a BVH file; by default the one in which the rest
            pose is nearest to 1.6 m tall.

    Raises:
        FileFormatError: with file, line, what was got and what was expected.
    """
    capture = read_capture(path, frame_rate=frame_rate, units=units)
    return capture.skeleton, capture.motion


def read_capture(
    path: str | Path, *, frame_rate: float | None = None, units: str | None = None
) -> Capture:
    """Like :func:`load_motion`, with the unit that was found."""
    if frame_rate is not None and not 0 < frame_rate <= 10000:
        raise ConfigError(f"frame rate is {frame_rate}, expected more than 0 and at most 10000")
    suffix = Path(path).suffix.lower()
    if suffix == ".bvh":
        skeleton, motion, unit = read_bvh(path, frame_rate=frame_rate, units=units)
    elif suffix == ".amc":
        asf = read_asf(find_asf(path))
        skeleton, unit = asf.skeleton, asf.unit
        motion = read_amc(path, asf, frame_rate=frame_rate)
    else:
        raise FileFormatError(path, None, f"a file of type {suffix!r}", "one of .bvh, .amc")
    return Capture(skeleton=skeleton, motion=motion, unit=unit)
