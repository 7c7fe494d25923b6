"""From ranked candidates to the choice among them, with a count of why others were dropped."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mgjax.avoidance.choice.results import Choice, Dropped, Status
from mgjax.avoidance.choice.search import (
    DEPTH,
    HOPELESS_M,
    STATUS,
    Query,
    SearchInput,
    SearchResult,
)
from mgjax.avoidance.choice.verify import in_order, pick_first_clear
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.energy.score import ROWS, Energy
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.timing.time_scale import NOT_ADJUSTABLE, OK, OUT_OF_RANGE, PADDING


@dataclass(frozen=True, kw_only=True, eq=False)
class Decision:
    """What was found among a set of candidates; ``choice`` is None if none of them can be timed."""

    choice: Choice | None
    dropped: Dropped


def decide(
    prepared: Prepared,
    query: Query,
    padded: SearchInput,
    result: SearchResult,
    config: AvoidanceConfig,
    *,
    culled: int = 0,
) -> Decision:
    """Goes through candidates in the order of their energy; the first that stays clear wins.

    Args:
        prepared: of the graph.
        query: the attack and its candidates.
        padded, result: the query as compiled code read it, and what it answered.
        config: settings.
        culled: candidates that slices dropped before.
    """
    table = np.asarray(result.table)
    candidates = query.candidates
    fit = table[STATUS] == OK
    counts = np.bincount(table[STATUS].astype(np.int64), minlength=PADDING + 1).tolist()
    dropped = Dropped(
        culled=culled,
        not_adjustable=counts[NOT_ADJUSTABLE],
        time_scale=counts[OUT_OF_RANGE],
        overflow=candidates.overflow,
    )
    usable = counts[OK]
    if not usable:
        return Decision(choice=None, dropped=dropped)
    # Without hope for any the one that is touched least stands for all.
    hopeful = max(int(np.count_nonzero(fit & (table[DEPTH] >= -HOPELESS_M))), 1)
    order = np.asarray(result.order)[: min(hopeful, config.checks)]
    ranked = in_order(prepared, order, padded, result)
    number, verdict, touched = pick_first_clear(prepared, query.attack, ranked, config)
    if not verdict.clear:
        touched += usable - hopeful
        dropped = replace(dropped, overflow=dropped.overflow + hopeful - len(order))
    dropped = replace(dropped, hit=touched)
    values = dict(zip(ROWS, table[:STATUS, number].tolist(), strict=True))
    played = verdict.played
    choice = Choice(
        status=Status.AVOIDED if verdict.clear else Status.HIT,
        node=query.node,
        walk=played.walk,
        path_length=int(padded.walks.length[number]),
        part=int(padded.walks.part[number]),
        time_scale=values.pop("s_time"),
        candidates=len(candidates.length) + candidates.overflow + culled,
        dropped=dropped,
        energy=Energy(**values),
        clearance_m=played.clearance,
        clear_until=None if verdict.clear else played.clear_until,
        crop=query.crop,
    )
    return Decision(choice=choice, dropped=dropped)


def better_of(one: Decision, other: Decision) -> Decision:
    """The choice among the candidates of two sets: what avoids, or what is touched least."""
    choices = [x.choice for x in (one, other) if x.choice is not None]
    best = max(choices, key=_worth, default=None)
    return Decision(choice=best, dropped=one.dropped + other.dropped)


def _worth(choice: Choice) -> tuple[bool, float]:
    return choice.status == Status.AVOIDED, choice.clearance_m or 0.0
