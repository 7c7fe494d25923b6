"""Near misses: candidates touched a little, and what a small change makes of them."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Int

from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.choice.results import Choice, Dropped, Status
from mgjax.avoidance.choice.search import DEPTH, STATUS, search_candidates
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.choice.verify import Bounded, bounded, bounds_of, walk_of
from mgjax.avoidance.energy.score import ROWS, Energy
from mgjax.avoidance.rates import CLEAR_M
from mgjax.avoidance.refinement.refine import refine_walks
from mgjax.avoidance.timing.time_scale import OK

TOGETHER = 4
"""Near misses of which that with the least change is taken."""
MOST = 3 * TOGETHER
"""Near misses that are tried at most."""
NEAR = 1.2
"""Candidates touched deeper than so many times the largest change are left alone."""


def refined_miss(query: Query, tried: set[bytes]) -> Choice | None:
    """The near miss that is clear after the least change, and as it is written; None where none is.

    Those touched least come first, and of those that end with the same part only the first; of
    each few that follow one another the one that is changed least is taken. A walk whose
    continuation is touched counts as the whole does.

    Args:
        query: the attack.
        tried: paths that were tried before, which are left out; those that are tried now are added.
    """
    candidates = query.in_time
    if not len(candidates.length):
        return None
    padded, result = search_candidates(query, candidates)
    table = np.asarray(result.table)
    walks_of = [_path(candidates, number) for number in range(len(candidates.length))]
    fresh = np.array([path not in tried for path in walks_of])
    deepest = NEAR * query.config.refine_max_m
    numbers = _nearest(table, candidates.part, fresh, deepest)[:MOST]
    for first in range(0, len(numbers), TOGETHER):
        some = numbers[first : first + TOGETHER]
        tried.update(walks_of[number] for number in some.tolist())
        lanes: list[Bounded] = []
        for rows, bounds in bounds_of(query, some, padded, np.asarray(result.scales)):
            lanes += bounded(rows, bounds, padded)
        walks = [walk_of(query, lane) for lane in lanes]
        found = refine_walks(query.prepared, walks, query.attack, query.config, begin=query.begin)
        changes = [(x.effort(query.config), k) for k, x in enumerate(found) if x is not None]
        for _, k in sorted(changes):
            number, change = lanes[k].number, found[k]
            assert change is not None
            values = dict(zip(ROWS, table[:STATUS, number].tolist(), strict=True))
            choice = Choice(
                status=Status.AVOIDED,
                node=query.node,
                walk=walks[k],
                path_length=lanes[k].length,
                part=int(candidates.part[number]),
                time_scale=values.pop("s_time"),
                candidates=len(candidates.length),
                dropped=Dropped(),
                energy=Energy(**values),
                clearance_m=change.clearance_m,
                crop=query.crop,
                refinement=change,
            )
            if query.as_written is None or query.as_written(choice) >= CLEAR_M:
                return choice
    return None


def _path(candidates: Candidates, number: int) -> bytes:
    """What tells a candidate from all others of its query."""
    return candidates.edges[number, : candidates.length[number]].tobytes()


def _nearest(
    table: np.ndarray,
    parts: Int[np.ndarray, " C"],
    fresh: Bool[np.ndarray, " C"],
    deepest: float,
) -> Int[np.ndarray, " K"]:
    """Fresh candidates by how deep they are touched in the sampled volumes, one for each part."""
    count = len(parts)
    depth = table[DEPTH, :count]
    order = np.argsort(-depth, kind="stable")
    order = order[(table[STATUS, order] == OK) & (depth[order] >= -deepest) & fresh[order]]
    _, first = np.unique(parts[order], return_index=True)
    return order[np.sort(first)]
