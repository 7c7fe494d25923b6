"""How a user says a file is to be read, where what is found in it is not to count."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mgjax.core.body.roles import ROLES
from mgjax.core.errors import ConfigError
from mgjax.io.reading.units import UNITS

AXES = ("x", "-x", "y", "-y", "z", "-z")


@dataclass(frozen=True, kw_only=True)
class ReadAs:
    """What is known of a file; None where it is to be found.

    Attributes:
        units: ``"m"``, ``"cm"``, ``"mm"``, ``"dm"``, ``"in"``, ``"ft"`` or ``"cmu"``.
        up: axis that points up in the file, such as ``"z"``.
        front: axis along which the body looks in frame 0; it is turned to +Z.
        frame_rate: frames per second at which the file was captured.
        floor: height of the floor in the file, m; ``"keep"`` leaves the heights as they are.
        asf: the ASF skeleton of an AMC file.
        body_model: the body whose motion an AMASS file has, see :mod:`mgjax.io.amass.model`.
        roles: (role, joint name) pairs that count more than what is found.
    """

    units: str | None = None
    up: str | None = None
    front: str | None = None
    frame_rate: float | None = None
    floor: float | str | None = None
    asf: Path | None = None
    body_model: Path | None = None
    roles: tuple[tuple[str, str], ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """What was said, ready for JSON; empty where nothing was."""
        said = {k: v for k, v in vars(self).items() if v is not None and v != ()}
        for name in {"asf", "body_model"} & said.keys():
            said[name] = str(said[name])
        if "roles" in said:
            said["roles"] = dict(self.roles)
        return said


def validate_read_as(read_as: ReadAs) -> None:
    """Raises :class:`ConfigError` for a value that means nothing."""
    rate, floor = read_as.frame_rate, read_as.floor
    if read_as.units is not None and read_as.units not in UNITS:
        raise ConfigError(f"units {read_as.units!r}, expected one of {', '.join(UNITS)}")
    for name in ("up", "front"):
        axis = getattr(read_as, name)
        if axis is not None and axis not in AXES:
            raise ConfigError(f"{name} {axis!r}, expected one of {', '.join(AXES)}")
    if rate is not None and not 0 < rate <= 10000:
        raise ConfigError(f"frame rate is {rate}, expected more than 0 and at most 10000")
    if isinstance(floor, str) and floor != "keep":
        raise ConfigError(f"floor {floor!r}, expected a height in metres or 'keep'")
    if isinstance(floor, (int, float)) and not (math.isfinite(floor) and abs(floor) <= 1000):
        raise ConfigError(f"floor {floor}, expected a height of at most 1000 m")
    for role, _ in read_as.roles:
        if role not in ROLES:
            raise ConfigError(f"role {role!r}, expected one of {', '.join(ROLES)}")
