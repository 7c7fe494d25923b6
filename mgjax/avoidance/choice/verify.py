"""Whether a candidate really stays clear, and the first one in a ranking that does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.checks.bounds import MORE_LANES, Bounds
from mgjax.avoidance.checks.fast import clearance_between
from mgjax.avoidance.choice.continuation import Continuation, continue_clear
from mgjax.avoidance.choice.search import SearchInput, SearchResult, bound
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.rates import CLEAR_M
from mgjax.graph.types import NO_EDGE
from mgjax.graph.walk import Walk, extend, make_walk

ROUNDING_M = 1e-5
"""What the jitted check may differ from that of the written motion."""


class Bounded(NamedTuple):
    """A candidate with what follows it, and what is certain of it; see :class:`Bounds`.

    Attributes:
        number: of the candidate.
        length: edges of its path.
        edges, scales: the path and what follows it, padded. [M]
        clearance, lower_bound: m.
        contact_from, path_end: s.
    """

    number: int
    length: int
    edges: Int[np.ndarray, " M"]
    scales: Float[np.ndarray, " M"]
    clearance: float
    lower_bound: float
    contact_from: float
    path_end: float

    @property
    def surely_touched(self) -> bool:
        """Whether contact within the path is certain."""
        return self.contact_from < self.path_end


@dataclass(frozen=True, kw_only=True, eq=False)
class Verdict:
    """What is known of a candidate in the end.

    Attributes:
        clear: whether the motion as it is written stays clear.
        played: what would be played, and how near the attack comes.
    """

    clear: bool
    played: Continuation


def verify(query: Query, candidate: Bounded) -> Verdict:
    """Whether a candidate stays clear, and what would be played.

    Its bounds decide on most. Where they leave a doubt, or the path is clear and the longest edges
    after it are not, the poses of the written motion are looked at, and other edges are tried after
    the path.
    """
    attack, posed = query.attack, query.prepared.posed
    walk = walk_of(query, candidate)
    default = Continuation(walk=walk, clearance=candidate.clearance, clear_until=None)
    if candidate.lower_bound >= CLEAR_M:
        return Verdict(clear=True, played=default)
    if candidate.surely_touched:
        return Verdict(clear=False, played=default)
    total = clearance_between(posed, attack, walk, 0.0, attack.end)
    if total >= CLEAR_M + ROUNDING_M:
        played = Continuation(walk=walk, clearance=total, clear_until=None)
        return Verdict(clear=True, played=played)
    path = make_walk(
        posed.graph, candidate.edges[: candidate.length], candidate.scales[: candidate.length]
    )
    played = continue_clear(posed, attack, path, query.config)
    if played.clearance < CLEAR_M or played.clear_until is not None:
        return Verdict(clear=False, played=played)
    # Pieces were checked one by one; what counts is the motion in one piece.
    total = clearance_between(posed, attack, played.walk, 0.0, attack.end)
    played = Continuation(walk=played.walk, clearance=total, clear_until=None)
    return Verdict(clear=total >= CLEAR_M + ROUNDING_M, played=played)


def pick_first_clear(
    query: Query,
    order: Int[np.ndarray, " K"],
    padded: SearchInput,
    result: SearchResult,
    as_written: Callable[[int, Verdict], float] | None = None,
) -> tuple[int, Verdict, int]:
    """Goes through candidates in their order; the first that stays clear wins.

    Args:
        query: the attack.
        order: numbers of the candidates.
        padded, result: the candidates as compiled code read them, and what it answered.

    Returns:
        The number of the candidate, the verdict on it, and how many were touched. Where all are,
        it is the one that is touched least.
    """
    touched = 0
    best: tuple[int, Verdict] | None = None
    for candidate in _in_order(query, order, padded, result):
        least = -np.inf if best is None else best[1].played.clearance
        if candidate.surely_touched and candidate.clearance <= least:
            touched += 1
            continue
        verdict = verify(query, candidate)
        if verdict.clear and as_written is not None:
            written = as_written(candidate.number, verdict)
            if written < CLEAR_M:
                touching = replace(verdict.played, clearance=written)
                verdict = Verdict(clear=False, played=touching)
        if verdict.clear:
            return candidate.number, verdict, touched
        touched += 1
        if verdict.played.clearance > least:
            best = (candidate.number, verdict)
    assert best is not None, "there is at least one candidate"
    return *best, touched


def _in_order(
    query: Query, order: Int[np.ndarray, " K"], padded: SearchInput, result: SearchResult
) -> Iterator[Bounded]:
    """Candidates in their order, each with its bounds; those of later ones are found on demand."""
    ready = result.bounds.figures.shape[0]
    yield from bounded(order[:ready], result.bounds, padded)
    later = order[ready:]
    for numbers, bounds in bounds_of(query, later, padded, np.asarray(result.scales)):
        yield from bounded(numbers, bounds, padded)


def bounds_of(
    query: Query,
    numbers: Int[np.ndarray, " K"],
    padded: SearchInput,
    scales: Float[np.ndarray, "L C"],
) -> Iterator[tuple[Int[np.ndarray, " K"], Bounds]]:
    """Bounds of some candidates, ``MORE_LANES`` of them at a time."""
    for first in range(0, len(numbers), MORE_LANES):
        subset = numbers[first : first + MORE_LANES]
        rows = np.resize(subset, MORE_LANES)  # repeats fill the lanes
        bounds = bound(
            query.prepared.device,
            padded.walks.rows(rows),
            scales[:, rows],
            padded.attack_batch,
            frame_rate=query.prepared.graph.frame_rate,
        )
        count = len(subset)
        yield subset, jax.tree.map(lambda x, count=count: np.asarray(x)[:count], bounds)


def bounded(
    numbers: Int[np.ndarray, " K"], bounds: Bounds, padded: SearchInput
) -> Iterator[Bounded]:
    """Candidates with their bounds, one by one."""
    edges, scales = np.asarray(bounds.edges), np.asarray(bounds.scales)
    figures = np.asarray(bounds.figures).tolist()
    for lane, number in enumerate(numbers.tolist()):
        length = int(padded.walks.length[number])
        yield Bounded(number, length, edges[lane], scales[lane], *figures[lane])


def walk_of(query: Query, candidate: Bounded) -> Walk:
    """A candidate with what follows it, cut or extended to end when it need no longer be clear."""
    graph, until = query.prepared.graph, query.until
    edges = candidate.edges[candidate.edges != NO_EDGE].astype(np.int64)
    scales = candidate.scales[: len(edges)].astype(np.float64)
    ends = np.cumsum(graph.edge_frames[edges] * scales)
    last = max(candidate.path_end - 1e-4, until) * graph.frame_rate
    needed = int(ends.searchsorted(last)) + 1
    walk = Walk(edges=edges[:needed], scales=scales[:needed])
    return walk if needed <= len(edges) else extend(graph, walk, until)
