"""What several commands take."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Output:
    """How results are printed."""

    json: bool = False
    """Print one JSON object on stdout."""


@dataclass(frozen=True, kw_only=True)
class Reading(Output):
    """What is known of the clips; otherwise it is found in their motion, or in a clips.toml."""

    units: str | None = None
    """Unit of their numbers: m, cm, mm, dm, in, ft or cmu."""
    up: str | None = None
    """Axis that points up: x, -x, y, -y, z or -z."""
    front: str | None = None
    """Axis along which the body looks in the first frame; it is turned to z."""
    fps: float | None = None
    """Frames per second at which they were captured."""
    floor: str | None = None
    """Height of their floor, m, or keep."""
    asf: Path | None = None
    """Skeleton of AMC files."""


@dataclass(frozen=True, kw_only=True)
class KnownReading(Reading):
    """What is known of the clips and of the body in them."""

    roles: Path | None = None
    """TOML file of roles and joint names, where those found are wrong."""
