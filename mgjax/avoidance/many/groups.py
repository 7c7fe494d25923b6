"""Many attacks put into groups, each of which one compiled call answers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.attacks.batch import AttackBatch
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_nodes, natural_times
from mgjax.avoidance.choice.choosing import paths_in_time
from mgjax.avoidance.choice.search import attack_batch_for
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared

TOGETHER = 2048
"""Candidates of one call, of as many attacks as have room."""


MOST = 64
"""Attacks of one call."""


NODES = 32
"""Nodes whose walks grow together. The device waits for the first of them."""


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
    """The attacks that have candidates: those that the index finds touched, or else all in time.

    Those of one node are enumerated together, and ``NODES`` nodes at once.
    """
    of_node: dict[int, list[tuple[int, Query]]] = {}
    for i, query in enumerate(queries):
        if query is None:
            continue
        answers["t_attack"][i] = query.crop.middle
        found = looked_up(query)
        if found is None:
            of_node.setdefault(query.node, []).append((i, query))
        else:
            yield from _asked(i, query, found, answers)
    nodes = sorted(of_node)
    for begin in range(0, len(nodes), NODES):
        some = nodes[begin : begin + NODES]
        for node, wide, times in zip(some, *_in_time(prepared, of_node, some, config), strict=True):
            for i, query in of_node[node]:
                subset = _within(wide, times, query.crop.middle, config)
                yield from _asked(i, query, subset, answers)


def looked_up(query: Query) -> Candidates | None:
    """What the index of a query finds touched; None without one, or where it cannot say."""
    index = query.prepared.index
    paths = paths_in_time(query)
    if index is None or paths is None:
        return None
    touched = index.touched(paths, query.attack, query.crop)
    return index.walks(paths if touched is None else paths[touched])


def _asked(
    number: int, query: Query, candidates: Candidates, answers: dict[str, np.ndarray]
) -> Iterator[Asked]:
    answers["candidates"][number] = len(candidates.length) + candidates.overflow
    if len(candidates.length):
        batch = attack_batch_for(query, candidates)
        yield Asked(number=number, query=query, candidates=candidates, attack_batch=batch)


def _in_time(
    prepared: Prepared,
    of_node: dict[int, list[tuple[int, Query]]],
    nodes: list[int],
    config: AvoidanceConfig,
) -> tuple[list[Candidates], list[Float[np.ndarray, " C"]]]:
    """Of each node the candidates of all its attacks, and when they avoid at natural speed."""
    middles = [[query.crop.middle for _, query in of_node[node]] for node in nodes]
    low = np.array([min(own) for own in middles]) - config.T_window / 2
    high = np.array([max(own) for own in middles]) + config.T_window / 2
    found = enumerate_nodes(prepared.graph, prepared.tables, np.array(nodes), low, high)
    return found, [natural_times(prepared.tables, own) for own in found]


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
