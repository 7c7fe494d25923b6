"""What reading a file gives: skeleton, motion, and what was found about its numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.reading.raw import Note
from mgjax.io.reading.roots import FloorRoot
from mgjax.io.reading.units import Unit


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What a file was found to mean.

    Attributes:
        unit: of its numbers.
        unit_sure: probability of that unit; 1 where it is stated, 0 where there is no body.
        up: axis of the file that points up.
        up_sure: mean cosine between body and axis; 0 where there is no body.
        floor_m: height of the floor in the file that was taken off, m; 0 where none was.
        front: axis along which the body looks in the first frame, as loaded, or "".
        height_m: of the standing body, or None where there is none.
        notes: what else there is to say, a line each.
    """

    unit: Unit
    unit_sure: float
    up: str = "y"
    up_sure: float = 0.0
    floor_m: float = 0.0
    front: str = ""
    height_m: float | None = None
    notes: tuple[Note, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """What was found, ready for JSON."""
        return {
            "unit": self.unit.name,
            "metres_per_unit": self.unit.metres,
            "unit_sure": round(self.unit_sure, 4),
            "up": self.up,
            "up_sure": round(self.up_sure, 4),
            "floor_m": round(self.floor_m, 4),
            "front": self.front,
            "height_m": None if self.height_m is None else round(self.height_m, 4),
        }


@dataclass(frozen=True, kw_only=True)
class Capture:
    """A file's skeleton and motion, and how they were read.

    Attributes:
        skeleton, motion: metres, Y up.
        reading: what was found.
        floor_root: the joint above the hips that was folded into them, or None.
    """

    skeleton: Skeleton
    motion: Motion
    reading: Reading
    floor_root: FloorRoot | None = None

    @property
    def unit(self) -> Unit:
        """The unit of the file."""
        return self.reading.unit
