"""Near misses: candidates touched a little, and what a small change makes of them."""

from __future__ import annotations

from dataclasses import replace

from mgjax.avoidance.choice.results import Choice, Dropped, Status
from mgjax.avoidance.choice.shifts import FAR_OFF, Miss, apart, misses
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.choice.verify import walk_of
from mgjax.avoidance.energy.score import Energy
from mgjax.avoidance.rates import CLEAR_M
from mgjax.avoidance.refinement.refine import attempts, refine_attempt
from mgjax.avoidance.refinement.refinement import Refinement
from mgjax.graph.walk import Walk

TOGETHER = 4
"""Near misses of which that with the least change is taken."""
MOST = 3 * TOGETHER
"""Near misses that are tried at most."""
NEAR = 1.2
"""Candidates touched deeper than so many times the largest change are left alone."""

_Found = tuple[float, Miss, Walk, Refinement]
"""What a change takes, and what it changes."""


def refined_miss(query: Query, tried: set[bytes]) -> Choice | None:
    """The near miss that is clear after the least change, and as it is written; None where none is.

    Candidates are tried at several timings (:mod:`mgjax.avoidance.choice.shifts`); those touched
    least come first, and of each few that follow one another the one that is changed least is
    taken. A walk whose continuation is touched counts as the whole does.

    Args:
        query: the attack.
        tried: paths that were tried before, which are left out; those that are tried now are added.
    """
    candidates = query.in_time
    if not len(candidates.length):
        return None
    near = misses(query, candidates, NEAR * query.config.refine_max_m)
    near = apart([miss for miss in near if miss.path not in tried])[:MOST]
    for first in range(0, len(near), TOGETHER):
        some = near[first : first + TOGETHER]
        tried.update(miss.path for miss in some)
        for _, miss, walk, change in sorted(_changed(query, some), key=lambda x: x[0]):
            values = dict(miss.values)
            choice = Choice(
                status=Status.AVOIDED,
                node=query.node,
                walk=walk,
                path_length=miss.lane.length,
                part=miss.part,
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


def _changed(query: Query, some: list[Miss]) -> list[_Found]:
    """The changes that clear some near misses; one that must be larger than another is left out."""
    config, attack = query.config, query.attack
    walks = [walk_of(query, miss.lane) for miss in some]
    rows = zip(
        some, walks, attempts(query.prepared, walks, attack, config, query.begin), strict=True
    )
    found: list[_Found] = []
    for miss, walk, attempt in sorted(rows, key=lambda row: -row[2].clearance):
        if query.wanted is not None and not query.wanted():
            break
        late = FAR_OFF * abs(miss.shift)
        least = min((effort for effort, *_ in found), default=float("inf"))
        if (late - attempt.clearance) / max(config.refine_max_m, 1e-9) >= least:
            continue
        change = refine_attempt(query.prepared, attempt, attack, config)
        if change is not None:
            effort = change.effort(config) + late / max(config.refine_max_m, 1e-9)
            found.append((effort, miss, walk, replace(change, shift_s=miss.shift)))
    return found
