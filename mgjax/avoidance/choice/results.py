"""What comes of an attack: the walk that was chosen, why, and how near the attack comes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from mgjax.avoidance.attacks.crop import Crop
from mgjax.graph.walk import Walk


@dataclass(frozen=True, kw_only=True)
class Energy:
    """What the chosen walk was worth; the fields are those of eqs 4–10."""

    total: float
    avoidance: float
    body: float
    timescale: float
    penetration: float
    d: float
    d0: float


@dataclass(frozen=True, kw_only=True)
class Dropped:
    """Why candidates were dropped.

    Attributes:
        culled: by slices, before they were judged.
        not_adjustable: no edge may change its speed as needed.
        time_scale: the time scale is not positive, or out of range.
        hit: touched, by the exact check or its bounds, or deeper in the sampled volumes than
            these can be wrong (``HOPELESS_M`` of :mod:`mgjax.avoidance.choice.search`).
        overflow: not judged, or not checked exactly, for lack of room.
    """

    culled: int = 0
    not_adjustable: int = 0
    time_scale: int = 0
    hit: int = 0
    overflow: int = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class Choice:
    """A walk for an attack, before its motion is made.

    Attributes:
        status: ``avoided``: the walk is clear of the attack throughout, by the exact check.
            ``hit``: there were candidates and every one is touched; the walk is the one touched
            least of those checked. ``no_candidate``: no avoidance part comes at the right time.
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
    """

    status: Literal["avoided", "hit", "no_candidate"]
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
