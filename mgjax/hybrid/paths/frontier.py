"""Partial walks, and how they are extended and remembered."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from mgjax.core import planar
from mgjax.hybrid.paths.kernel import Request, bound, extend, in_buckets
from mgjax.hybrid.paths.macro_edges import NO_PIECE, Strides

NO_RECORD = -1
UNBOUNDED = 1 << 30
"""Frames of a horizon that is never reached."""


class Front(NamedTuple):
    """Partial walks that stand at a stop.

    Attributes:
        stop: where. [B]
        state: heading, x, z, arc length of the walk, cost. [B, 5]
        frames: since the beginning. [B]
        record: in the search's memory. [B]
    """

    stop: Int[np.ndarray, " B"]
    state: Float[np.ndarray, "B 5"]
    frames: Int[np.ndarray, " B"]
    record: Int[np.ndarray, " B"]

    def pick(self, rows: np.ndarray | slice) -> Front:
        """Some of them, by their numbers or a mask."""
        return Front(*(x[rows] for x in self))


def join(fronts: list[Front]) -> Front:
    """All of several."""
    return Front(*(np.concatenate(x) for x in zip(*fronts, strict=True)))


class Leaf(NamedTuple):
    """The end of a walk: where it was found, its cost and its frames."""

    cost: float
    record: int
    stride: int
    frames: int
    complete: bool


@dataclass(kw_only=True)
class Search:
    """One request on one graph: tables, what was found so far, and counts.

    Attributes:
        strides, request: graph and path.
        expanded: partial walks that were extended.
        pruned: extensions and partial walks that were given up: too far off, or too costly.
    """

    strides: Strides
    request: Request
    expanded: int = 0
    pruned: int = 0
    _parents: list[np.ndarray] = field(default_factory=list)
    _strides: list[np.ndarray] = field(default_factory=list)
    _count: int = 0
    _prefixes: dict[int, list[int]] = field(default_factory=dict)

    def remember(self, parents: np.ndarray, strides: np.ndarray) -> np.ndarray:
        """Records of walks: the record they continue and the stride they add."""
        records = np.arange(self._count, self._count + len(parents))
        self._parents.append(parents)
        self._strides.append(strides)
        self._count += len(parents)
        return records

    def recorded(self) -> tuple[Int[np.ndarray, " R"], Int[np.ndarray, " R"]]:
        """Of every walk that was remembered: the record it continues and the stride it adds."""
        return np.concatenate(self._parents), np.concatenate(self._strides)

    def begin(self, state: Float[np.ndarray, "B 5"], stop: np.ndarray, frames: int = 0) -> Front:
        """Walks that begin here, each with a record of its own."""
        nothing = np.full(len(stop), NO_RECORD)
        records = self.remember(nothing, nothing)
        return Front(stop, state, np.full(len(stop), frames), records)

    def begin_with(self, state: np.ndarray, stop: int, pieces: list[int]) -> Front:
        """A walk that has played pieces already."""
        frames = int(self.strides.pieces.frames[pieces].sum())
        front = self.begin(state[None], np.array([stop]), frames)
        self._prefixes[int(front.record[0])] = pieces
        return front

    def chain(self, record: int, stride: int = NO_RECORD) -> tuple[int, list[int]]:
        """The record a walk began with, and the pieces it is made of."""
        parents, strides = self.recorded()
        taken = [stride] if stride != NO_RECORD else []
        while parents[record] != NO_RECORD:
            taken.append(int(strides[record]))
            record = int(parents[record])
        pieces = list(self._prefixes.get(record, []))
        for one in reversed(taken):
            pieces += [int(p) for p in self.strides.members[one] if p != NO_PIECE]
        return record, pieces

    def expand(
        self, front: Front, horizon: int, limit: float, most: int | None = None
    ) -> tuple[Front, Leaf | None, Leaf | None]:
        """All walks by one stride longer that cost less than ``limit``.

        Args:
            front: walks.
            horizon: frames at which a walk is over.
            limit: of the cost.
            most: only so many of the cheapest go on.

        Returns:
            Those that go on, the best that is complete, and the best that reached the horizon.
        """
        first, count = self.strides.first[front.stop], np.diff(self.strides.first)[front.stop]
        row = np.repeat(np.arange(len(count)), count)
        begin = np.cumsum(count) - count
        stride = np.arange(len(row)) + (first - begin)[row]
        lasts = self.strides.frames[stride]
        before = front.frames[row]
        frames = np.stack([lasts, horizon - before], axis=1).astype(np.int32)
        costs = self._costs(front.state[row], stride, frames)
        self.expanded += len(count)
        after = before + lasts
        goes_on = (costs[0] < limit) & (after < horizon)
        complete = _best(costs[1], before + costs[2].astype(np.int64), front, row, stride, True)
        at_horizon = np.where(after >= horizon, costs[0], np.inf)
        reached = _best(at_horizon, np.minimum(after, horizon), front, row, stride, False)
        chosen = np.flatnonzero(goes_on)
        if most is not None and len(chosen) > most:
            chosen = chosen[np.argpartition(costs[0, chosen], most)[:most]]
        self.pruned += len(row) - len(chosen)
        children = self._children(front, row[chosen], stride[chosen], costs[0, chosen])
        return children, complete, reached

    def _costs(self, state: np.ndarray, stride: np.ndarray, frames: np.ndarray) -> np.ndarray:
        parts = [
            np.asarray(
                extend(
                    self.strides.track,
                    self.strides.manner,
                    self.request,
                    _padded(state[a:b], size),
                    _padded(stride[a:b].astype(np.int32), size),
                    _padded(frames[a:b], size),
                )
            )[:, : b - a]
            for a, b, size in in_buckets(len(stride))
        ]
        return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)

    def _children(
        self, front: Front, row: np.ndarray, stride: np.ndarray, cost: np.ndarray
    ) -> Front:
        tables = self.strides
        state = np.empty((len(row), 5), dtype=np.float32)
        old = front.state[row]
        state[:, :3] = planar.compose(old[:, :3], tables.end[stride].astype(np.float32))
        state[:, 3] = old[:, 3] + tables.arc[stride]
        state[:, 4] = cost
        return Front(
            tables.target[stride],
            state,
            front.frames[row] + tables.frames[stride],
            self.remember(front.record[row], stride),
        )

    def bounds(self, front: Front, horizon: int) -> Float[np.ndarray, " B"]:
        """Cost of each walk with what every continuation adds at least."""
        frames = (horizon - front.frames).astype(np.int32)
        parts = [
            np.asarray(
                bound(
                    self.strides.ahead,
                    self.request,
                    _padded(front.state[a:b], size),
                    _padded(front.stop[a:b].astype(np.int32), size),
                    _padded(frames[a:b], size),
                )
            )[: b - a]
            for a, b, size in in_buckets(len(frames))
        ]
        return front.state[:, 4] + np.concatenate(parts)


def _best(
    costs: np.ndarray,
    frames: np.ndarray,
    front: Front,
    row: np.ndarray,
    stride: np.ndarray,
    complete: bool,
) -> Leaf | None:
    if not len(costs):
        return None
    i = int(np.argmin(costs))
    if not np.isfinite(costs[i]):
        return None
    return Leaf(
        float(costs[i]), int(front.record[row[i]]), int(stride[i]), int(frames[i]), complete
    )


def _padded(array: np.ndarray, size: int) -> np.ndarray:
    """Zeros after the last row; quicker than numpy.pad, which counts here."""
    out = np.zeros((size, *array.shape[1:]), dtype=array.dtype)
    out[: len(array)] = array
    return out
