"""Many attacks put into groups, each of which one compiled call answers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby

import jax
import numpy as np
from jaxtyping import Int

from mgjax.avoidance.attacks.batch import AttackBatch
from mgjax.avoidance.candidates.batch import EDGE_BUCKET, CandidateBatch, empty_candidate_batch
from mgjax.avoidance.candidates.enumerate import Candidates, NodeCandidates, enumerate_nodes
from mgjax.avoidance.choice.choosing import paths_in_time
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.many.questions import Questions
from mgjax.core.csr import expand_rows, row_starts
from mgjax.core.xla.padding import bucket_size

TOGETHER = 8192
"""Candidates of one call, of as many attacks as have room."""


MOST = 64
"""Attacks of one call."""


NODES = 32
"""Nodes whose walks grow together. The device waits for the first of them."""


LOT = 1024
"""Attacks that are laid out together: their frames are in memory."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Asked:
    """One of many attacks, number ``number`` of them, that has candidates.

    Attributes:
        number: of the attack.
        found: candidates of its node and others.
        rows: those that are in time for it. [K]
        overflow: how many were left out for lack of room.
        attack_batch: the attack as compiled code reads it.
    """

    number: int
    found: NodeCandidates
    rows: Int[np.ndarray, " K"]
    overflow: int
    attack_batch: AttackBatch

    @property
    def candidates(self) -> Candidates:
        """Those that are in time."""
        return self.found.some(self.rows, self.overflow)


def all_asked(questions: Questions, answers: dict[str, np.ndarray]) -> Iterator[Asked]:
    """The attacks that have candidates: those that the index finds touched, or else all in time.

    Those of one node are enumerated together, and ``NODES`` nodes at once.
    """
    near = np.flatnonzero(np.isfinite(questions.middle))
    answers["t_attack"][near] = questions.middle[near]
    if questions.prepared.index is not None:
        yield from _all_looked_up(questions, near, answers)
        near = near[answers["candidates"][near] < 0]
    near = near[np.argsort(questions.nodes[near], kind="stable")]
    nodes, begin = np.unique(questions.nodes[near], return_index=True)
    ends = np.append(begin, len(near))
    for k in range(0, len(nodes), NODES):
        own = near[ends[k] : ends[min(k + NODES, len(nodes))]]
        found = _in_time(questions, nodes[k : k + NODES], own)
        for lot in np.split(own, range(LOT, len(own), LOT)):
            at = np.searchsorted(nodes[k : k + NODES], questions.nodes[lot])
            yield from _lot(questions, found, lot, at, answers)


def _all_looked_up(
    questions: Questions, near: Int[np.ndarray, " A"], answers: dict[str, np.ndarray]
) -> Iterator[Asked]:
    """Those of which the index can say what is touched; of the others ``candidates`` is −1."""
    for number in near.tolist():
        found = looked_up(questions.query(number))
        answers["candidates"][number] = -1
        if found is None:
            continue
        count = len(found.length)
        own = NodeCandidates(
            edges=found.edges,
            length=found.length,
            part=found.part,
            t_avoid=np.full(count, np.nan),
            first=np.array([0, count]),
            overflow=np.array([found.overflow]),
        )
        yield from _asked(questions, own, np.array([number]), [np.arange(count)], [0], answers)


def looked_up(query: Query) -> Candidates | None:
    """What the index of a query finds touched; None without one, or where it cannot say."""
    index = query.prepared.index
    paths = paths_in_time(query)
    if index is None or paths is None:
        return None
    touched = index.touched(paths, query.attack, query.crop)
    return index.walks(paths if touched is None else paths[touched])


def _in_time(
    questions: Questions, nodes: Int[np.ndarray, " N"], numbers: Int[np.ndarray, " A"]
) -> NodeCandidates:
    """Of each node the candidates of all its attacks, which are in the order of their nodes."""
    middles, half = questions.middle[numbers], questions.config.T_window / 2
    begin = np.searchsorted(questions.nodes[numbers], nodes)
    low = np.minimum.reduceat(middles, begin) - half
    high = np.maximum.reduceat(middles, begin) + half
    prepared = questions.prepared
    return enumerate_nodes(prepared.graph, prepared.tables, nodes, low, high)


def _lot(
    questions: Questions,
    found: NodeCandidates,
    numbers: Int[np.ndarray, " A"],
    at: Int[np.ndarray, " A"],
    answers: dict[str, np.ndarray],
) -> Iterator[Asked]:
    """The attacks of a lot that have candidates which satisfy eq. 1; ``at`` is each one's node."""
    config, middles = questions.config, questions.middle[numbers]
    attack, row = expand_rows(found.first, at)
    half = config.T_window / 2
    t_avoid, middle = found.t_avoid[row], middles[attack]
    fits = (t_avoid > middle - half) & (t_avoid < middle + half)
    attack, row = attack[fits], row[fits]
    first = row_starts(np.bincount(attack, minlength=len(numbers)))
    rows = [row[a:b] for a, b in zip(first[:-1].tolist(), first[1:].tolist(), strict=True)]
    overflow = found.overflow[at].tolist()
    for i in np.flatnonzero(np.diff(first) > config.capacity).tolist():
        overflow[i] += len(rows[i]) - config.capacity
        off = np.abs(found.t_avoid[rows[i]] - middles[i])
        rows[i] = rows[i][np.sort(np.argsort(off, kind="stable")[: config.capacity])]
    yield from _asked(questions, found, numbers, rows, overflow, answers)


def _asked(
    questions: Questions,
    found: NodeCandidates,
    numbers: Int[np.ndarray, " A"],
    rows: list[Int[np.ndarray, " _"]],
    overflow: list[int],
    answers: dict[str, np.ndarray],
) -> Iterator[Asked]:
    counts = np.array([len(own) for own in rows])
    answers["candidates"][numbers] = counts + overflow
    some = np.flatnonzero(counts)
    batches = questions.batches(numbers[some])
    for i, number, batch in zip(some.tolist(), numbers[some].tolist(), batches, strict=True):
        own = rows[i]
        long = found.edges.shape[1] > EDGE_BUCKET and found.length[own].max() > EDGE_BUCKET
        yield Asked(
            number=number,
            found=found,
            rows=own,
            overflow=overflow[i],
            attack_batch=batch.as_long() if long else batch,
        )


def groups(all_asked: Iterable[Asked]) -> Iterator[list[Asked]]:
    """Attacks that are answered in one call: of equal shapes, as many as have room."""
    waiting: dict[tuple, tuple[list[Asked], int]] = {}
    for asked in all_asked:
        count, shape = len(asked.rows), asked.attack_batch.frames.shape
        group, together = waiting.get(shape, ([], 0))
        if group and (len(group) == MOST or together + count > TOGETHER):
            yield group
            group, together = [], 0
        group.append(asked)
        waiting[shape] = group, together + count
    yield from (group for group, _ in waiting.values())


def firsts_of(group: list[Asked]) -> Int[np.ndarray, " A1"]:
    """Where the candidates of each attack begin and, last, where they end."""
    return row_starts(np.array([len(asked.rows) for asked in group]))


def group_batch(
    group: list[Asked], first: Int[np.ndarray, " A1"]
) -> tuple[CandidateBatch, AttackBatch]:
    """The candidates and the attacks of a group, padded; ``first`` is of :func:`firsts_of`."""
    runs = [
        (found, np.concatenate([asked.rows for asked in own]))
        for found, own in (
            (run[0].found, run) for _, each in groupby(group, _found_of) for run in [list(each)]
        )
    ]
    longest = max(int(found.length[rows].max()) for found, rows in runs)
    longest = max(longest, EDGE_BUCKET + 1 if group[-1].attack_batch.is_long else 0)
    size = bucket_size(int(first[-1]), TOGETHER, 4)
    walks = empty_candidate_batch(bucket_size(longest, EDGE_BUCKET, 4), size, shared=False)
    table, begin = walks.table, 0
    for found, rows in runs:
        columns, used = slice(begin, begin + len(rows)), min(found.edges.shape[1], longest)
        table[:used, columns] = found.edges.T[:used, rows]
        table[-3, columns], table[-2, columns] = found.length[rows], found.part[rows]
        begin += len(rows)
    table[-1] = MOST - 1
    table[-1, :begin] = np.repeat(np.arange(len(group)), np.diff(first))
    batches = [asked.attack_batch for asked in group]
    batches += [batches[-1]] * (MOST - len(batches))
    return walks, jax.tree.map(lambda *x: np.concatenate(x), *batches)


def _found_of(asked: Asked) -> int:
    return id(asked.found)


def starts_of(first: Int[np.ndarray, " A1"], count: int) -> Int[np.ndarray, " M"]:
    """The first candidate of each of ``MOST`` attacks; of those that pad a group the last one."""
    starts = np.full(MOST, count - 1, np.int32)
    starts[: len(first) - 1] = first[:-1]
    return starts
