"""What comes of an attack: the walk that was chosen, why, and how near the attack comes."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.energy.score import Energy
from mgjax.avoidance.parry.parry import Parry
from mgjax.avoidance.refinement.refinement import Refinement
from mgjax.graph.walk import Walk


class Status(StrEnum):
    """What came of an attack; compares equal to its text, and has a number for use in arrays.

    ``avoided``: the motion is clear of the attack throughout, by the exact check. ``hit``: there
    were candidates and every one of them is touched. ``no_candidate``: no avoidance part comes at
    the right time. ``parried``: nothing avoids it, and a forearm or a hand is the first and the
    only thing that it touches, by the same check.
    """

    AVOIDED = "avoided"
    HIT = "hit"
    NO_CANDIDATE = "no_candidate"
    PARRIED = "parried"

    @property
    def code(self) -> int:
        """Its number in arrays: 0 … 3."""
        return _CODES[self]


_CODES = {status: code for code, status in enumerate(Status)}


@dataclass(frozen=True, kw_only=True)
class Dropped:
    """Why candidates were dropped.

    Attributes:
        culled: by slices, before they were judged.
        not_adjustable: no edge may change its speed as needed.
        time_scale: the time scale is not positive, or out of range.
        hit: touched, by the exact check or its bounds, or deeper in the sampled volumes than
            these can be wrong (:data:`mgjax.avoidance.choice.search.HOPELESS_M`).
        overflow: not judged, or not checked exactly, for lack of room.
    """

    culled: int = 0
    not_adjustable: int = 0
    time_scale: int = 0
    hit: int = 0
    overflow: int = 0

    def __add__(self, other: Dropped) -> Dropped:
        """The counts of two sets of candidates."""
        return Dropped(
            culled=self.culled + other.culled,
            not_adjustable=self.not_adjustable + other.not_adjustable,
            time_scale=self.time_scale + other.time_scale,
            hit=self.hit + other.hit,
            overflow=self.overflow + other.overflow,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Choice:
    """A walk for an attack, before its motion is made.

    Attributes:
        status: see :class:`Status`. Of a ``hit`` the walk is the one touched least of those
            checked.
        node: where the walk begins.
        walk: the path, and what follows it until the attack is over.
        path_length: edges that belong to the path; the last one holds the avoidance part.
        part: the avoidance part, or None.
        time_scale: s_time, or None.
        candidates: how many satisfy eq. 1; of those that the index holds, if one of them avoids.
        dropped: why how many of them were dropped.
        energy: of the chosen candidate, or None.
        clearance_m: signed distance of attack and body over the walk, or None without candidate;
            of body spheres that move straight from frame to frame of the graph, which is within
            millimetres of the written motion. That the latter is clear, too, has been made sure.
        clear_until: seconds until which the motion is clear where nothing clear could follow the
            path; None otherwise.
        crop: the part of the attack that counted for energies and timing, or None.
        refinement: how the motion of the walk is changed to be clear, or None where it is played as
            it is. Clearances are those of the changed motion, energies those of the walk.
        parry: how an arm meets the attack, or None. The clearance is then that of the rest of the
            body, with the sphere that is met ending at the contact.
    """

    status: Status
    node: int
    walk: Walk
    path_length: int = 0
    part: int | None = None
    time_scale: float | None = None
    candidates: int = 0
    dropped: Dropped = Dropped()
    energy: Energy | None = None
    clearance_m: float | None = None
    clear_until: float | None = None
    crop: Crop | None = None
    refinement: Refinement | None = None
    parry: Parry | None = None
