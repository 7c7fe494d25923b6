"""Many attacks put into groups, each of which one compiled call answers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.attacks.batch import AttackBatch
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates, natural_times
from mgjax.avoidance.choice.search import attack_batch_for
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared

TOGETHER = 2048
"""Candidates of one call, of as many attacks as have room."""


MOST = 64
"""Attacks of one call."""


_LIMIT = 1_000_000


@dataclass(frozen=True, kw_only=True, eq=False)
class Asked:
    """One of many attacks, number ``number`` of them, that has candidates."""

    number: int
    query: Query
    candidates: Candidates
    attack_batch: AttackBatch


def all_asked(
    prepared: Prepared,
    queries: Sequence[Query | None],
    answers: dict[str, np.ndarray],
    config: AvoidanceConfig,
) -> Iterator[Asked]:
    """The attacks that have candidates; those of one node are enumerated together."""
    graph, tables = prepared.graph, prepared.tables
    of_node: dict[int, list[tuple[int, Query]]] = {}
    for i, query in enumerate(queries):
        if query is not None:
            of_node.setdefault(query.node, []).append((i, query))
            answers["t_attack"][i] = query.crop.middle
    for node in sorted(of_node):
        middles = [query.crop.middle for _, query in of_node[node]]
        low, high = min(middles), max(middles)
        wide = enumerate_candidates(
            graph,
            tables,
            node,
            0.5 * (low + high),
            window=config.T_window + high - low,
            capacity=_LIMIT,
        )
        times = natural_times(tables, wide)
        for i, query in of_node[node]:
            subset = _within(wide, times, query.crop.middle, config)
            answers["candidates"][i] = len(subset.length) + subset.overflow
            if len(subset.length):
                batch = attack_batch_for(query, subset)
                yield Asked(number=i, query=query, candidates=subset, attack_batch=batch)


def groups(all_asked: Iterator[Asked]) -> Iterator[list[Asked]]:
    """Attacks that are answered in one call: of equal shapes, as many as have room."""
    waiting: dict[tuple, tuple[list[Asked], int]] = {}
    for asked in all_asked:
        count = len(asked.candidates.length)
        shape = asked.attack_batch.frames.shape
        group, together = waiting.get(shape, ([], 0))
        if group and (len(group) == MOST or together + count > TOGETHER):
            yield group
            group, together = [], 0
        waiting[shape] = [*group, asked], together + count
    yield from (group for group, _ in waiting.values())


def _within(
    wide: Candidates, times: Float[np.ndarray, " C"], middle: float, config: AvoidanceConfig
) -> Candidates:
    """Those of some candidates that satisfy eq. 1 for an attack at ``middle``."""
    off = np.abs(times - middle)
    fits = np.flatnonzero(off < config.T_window / 2)
    beyond = max(len(fits) - config.capacity, 0)
    if beyond:
        fits = np.sort(fits[np.argsort(off[fits], kind="stable")[: config.capacity]])
    length = wide.length[fits]
    return Candidates(
        edges=wide.edges[fits, : int(length.max(initial=1))],
        length=length,
        part=wide.part[fits],
        overflow=wide.overflow + beyond,
    )


def firsts_of(group: list[Asked]) -> Int[np.ndarray, " A1"]:
    """Where the candidates of each attack begin and, last, where they end."""
    counts = [len(asked.candidates.length) for asked in group]
    return np.concatenate([[0], np.cumsum(counts)])
