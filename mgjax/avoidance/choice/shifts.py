"""Candidates that come a little earlier or later than eq. 3 has them, by how deep they are touched.

Eq. 3 brings the middle of an avoidance part to the middle of the attack; a body is not lowest, or
farthest aside, just then.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.checks.bounds import MORE_LANES
from mgjax.avoidance.choice.search import DEPTH, STATUS, search_input, search_shifted
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.choice.verify import Bounded, bounded, bounds_of
from mgjax.avoidance.energy.score import ROWS
from mgjax.avoidance.timing.time_scale import OK

SHIFTS_S = (0.0, -0.05, 0.05, -0.1, 0.1, -0.15, 0.15, -0.2, 0.2)
"""How much later than eq. 3 has it an avoidance part is tried."""
APART_S = 0.099
"""Timings of one part that are nearer than so are tried once."""
OF_A_PART = 3
"""Timings of one part that are tried at most."""
FAR_OFF = 0.1
"""Depth that a shift of a second counts as, m: of two that are touched alike the one on time."""


class Miss(NamedTuple):
    """A candidate at one timing.

    Attributes:
        lane: the walk, and how near the attack comes to it as captured.
        part: its avoidance part.
        shift: how much later than eq. 3 has it the part comes, s.
        path: what tells it from all others of its query.
        values: measures and scores by name, as ``ROWS`` has them.
    """

    lane: Bounded
    part: int
    shift: float
    path: bytes
    values: dict[str, float]

    @property
    def worth(self) -> float:
        """How near to being clear it is, m."""
        return self.lane.clearance - FAR_OFF * abs(self.shift)


def misses(query: Query, candidates: Candidates, deepest: float) -> list[Miss]:
    """Candidates at several timings that are touched at most so deep as captured, m, those nearest
    to being clear first."""
    padded = search_input(query, candidates)
    found: list[Miss] = []
    for shift in SHIFTS_S:
        result = search_shifted(query, padded, shift)
        table, scales = np.asarray(result.table), np.asarray(result.scales)
        depth = table[DEPTH, : len(candidates.length)]
        order = np.argsort(-depth, kind="stable")
        order = order[(table[STATUS, order] == OK) & (depth[order] >= -deepest)][:MORE_LANES]
        for rows, bounds in bounds_of(query, order, padded, scales):
            for lane in bounded(rows, bounds, padded):
                number = lane.number
                if lane.clearance < -deepest:
                    continue
                found.append(
                    Miss(
                        lane=lane,
                        part=int(candidates.part[number]),
                        shift=shift,
                        path=candidates.edges[number, : candidates.length[number]].tobytes(),
                        values=dict(zip(ROWS, table[:STATUS, number].tolist(), strict=True)),
                    )
                )
    return sorted(found, key=lambda miss: -miss.worth)


def apart(found: Sequence[Miss]) -> list[Miss]:
    """Those of some misses that differ: in their part, or by ``APART_S`` in when it comes."""
    kept: dict[int, list[Miss]] = {}
    chosen: list[Miss] = []
    for miss in found:
        same = kept.setdefault(miss.part, [])
        if len(same) < OF_A_PART and all(abs(x.shift - miss.shift) >= APART_S for x in same):
            same.append(miss)
            chosen.append(miss)
    return chosen
