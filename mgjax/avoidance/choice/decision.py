"""The best of a set of candidates: culled, searched and verified, with why others were dropped."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.choice.results import Choice, Dropped, Status
from mgjax.avoidance.choice.search import (
    DEPTH,
    HOPELESS_M,
    STATUS,
    SearchInput,
    SearchResult,
    search_candidates,
)
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.choice.verify import Verdict, pick_first_clear
from mgjax.avoidance.culling.cull import without_culled
from mgjax.avoidance.energy.score import ROWS, Energy
from mgjax.avoidance.timing.time_scale import NOT_ADJUSTABLE, OK, OUT_OF_RANGE, PADDING


@dataclass(frozen=True, kw_only=True, eq=False)
class Decision:
    """What was found among a set of candidates.

    Attributes:
        choice: None if none of them can be timed.
        candidates: how many there were.
        dropped: why how many of them were dropped.
    """

    choice: Choice | None
    candidates: int
    dropped: Dropped


def best_of(query: Query, candidates: Candidates) -> Decision:
    """The best of some candidates that stays clear."""
    prepared, config = query.prepared, query.config
    kept, culled = candidates, 0
    if config.culling != "none" and prepared.slices is not None:
        kept, culled = without_culled(
            prepared.slices,
            prepared.device,
            candidates,
            query.attack,
            query.crop,
            config,
            frame_rate=prepared.graph.frame_rate,
        )
    dropped = Dropped(culled=culled, overflow=kept.overflow)
    if not len(kept.length):
        return Decision(choice=None, candidates=culled + kept.overflow, dropped=dropped)
    padded, result = search_candidates(query, kept)
    return decide(query, padded, result, len(kept.length), dropped)


def decide(
    query: Query, padded: SearchInput, result: SearchResult, count: int, dropped: Dropped
) -> Decision:
    """Goes through candidates in the order of their energy; the first that stays clear wins.

    Args:
        query: the attack.
        padded, result: the candidates as compiled code read them, and what it answered.
        count: of the candidates.
        dropped: others, which were not searched.
    """
    total = count + dropped.culled + dropped.overflow
    table = np.asarray(result.table)
    fit = table[STATUS] == OK
    counts = np.bincount(table[STATUS].astype(np.int64), minlength=PADDING + 1).tolist()
    dropped = replace(
        dropped, not_adjustable=counts[NOT_ADJUSTABLE], time_scale=counts[OUT_OF_RANGE]
    )
    usable = counts[OK]
    if not usable:
        return Decision(choice=None, candidates=total, dropped=dropped)
    # Without hope for any the one that is touched least stands for all.
    hopeful = max(int(np.count_nonzero(fit & (table[DEPTH] >= -HOPELESS_M))), 1)
    order = np.asarray(result.order)[: min(hopeful, query.config.checks)]

    def choice_of(number: int, verdict: Verdict) -> Choice:
        values = dict(zip(ROWS, table[:STATUS, number].tolist(), strict=True))
        played = verdict.played
        return Choice(
            status=Status.AVOIDED if verdict.clear else Status.HIT,
            node=query.node,
            walk=played.walk,
            path_length=int(padded.walks.length[number]),
            part=int(padded.walks.part[number]),
            time_scale=values.pop("s_time"),
            candidates=total,
            energy=Energy(**values),
            clearance_m=played.clearance,
            clear_until=None if verdict.clear else played.clear_until,
            crop=query.crop,
        )

    written = query.as_written
    number, verdict, touched = pick_first_clear(
        query,
        order,
        padded,
        result,
        None if written is None else lambda n, found: written(choice_of(n, found)),
    )
    if not verdict.clear:
        touched += usable - hopeful
        dropped = replace(dropped, overflow=dropped.overflow + hopeful - len(order))
    dropped = replace(dropped, hit=touched)
    choice = replace(choice_of(number, verdict), dropped=dropped)
    return Decision(choice=choice, candidates=total, dropped=dropped)


def better_of(one: Decision, other: Decision) -> Decision:
    """The choice among the candidates of two sets: what avoids, or what is touched least."""
    choices = [x.choice for x in (one, other) if x.choice is not None]
    best = max(choices, key=_worth, default=None)
    return Decision(
        choice=best,
        candidates=one.candidates + other.candidates,
        dropped=one.dropped + other.dropped,
    )


def _worth(choice: Choice) -> tuple[bool, float]:
    return choice.status == Status.AVOIDED, choice.clearance_m or 0.0
