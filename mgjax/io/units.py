"""The unit of a file that does not state one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mgjax.core.errors import ConfigError

BODY_HEIGHT_M = 1.6


@dataclass(frozen=True, kw_only=True)
class Unit:
    """A unit of length and how many metres it has."""

    name: str
    metres: float


UNITS = {
    "m": Unit(name="metre", metres=1.0),
    "cm": Unit(name="centimetre", metres=0.01),
    "cmu": Unit(name="CMU unit (0.0254/0.45 m)", metres=0.0254 / 0.45),
}


def find_unit(offsets: np.ndarray, parents: tuple[int, ...], units: str | None = None) -> Unit:
    """The unit in which the rest pose is nearest to 1.6 m tall (by ratio), or the one named.

    Args:
        offsets: [J,3], in the unknown unit.
        parents: parent of each joint, −1 for the root.
        units: ``"m"``, ``"cm"``, ``"cmu"`` or None.
    """
    if units is not None:
        if units not in UNITS:
            raise ConfigError(f"units {units!r}, expected one of {', '.join(UNITS)}")
        return UNITS[units]
    places = np.zeros_like(offsets)
    for joint, parent in enumerate(parents):
        if parent >= 0:
            places[joint] = places[parent] + offsets[joint]
    extent = np.ptp(places, axis=0)
    height = float(extent[1]) if extent[1] > 1e-6 else float(extent.max())
    if not height > 1e-9:
        return UNITS["m"]
    return min(UNITS.values(), key=lambda u: abs(math.log(height * u.metres / BODY_HEIGHT_M)))
