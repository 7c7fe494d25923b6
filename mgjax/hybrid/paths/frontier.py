"""Partial walks, and how they are extended and remembered."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from mgjax.core import csr, planar
from mgjax.hybrid.macro.macro_edges import MacroEdges
from mgjax.hybrid.macro.pieces import NO_PIECE
from mgjax.hybrid.paths.kernel import Request, extension_costs, in_buckets, lower_bounds

NO_RECORD = -1
UNBOUNDED = 1 << 30
"""Frames of a horizon that is never reached."""


class Frontier(NamedTuple):
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

    @property
    def place(self) -> Float[np.ndarray, "B 3"]:
        """Where the body stands: heading, x and z."""
        return self.state[:, :3]

    @property
    def arc(self) -> Float[np.ndarray, " B"]:
        """Arc length of the walk, m."""
        return self.state[:, 3]

    @property
    def cost(self) -> Float[np.ndarray, " B"]:
        """Of the walk so far."""
        return self.state[:, 4]

    def pick(self, rows: np.ndarray | slice) -> Frontier:
        """The walks of some rows, chosen by number or mask."""
        return Frontier(*(x[rows] for x in self))


def concatenate(frontiers: list[Frontier]) -> Frontier:
    """The walks of several frontiers as one."""
    return Frontier(*(np.concatenate(x) for x in zip(*frontiers, strict=True)))


class Terminal(NamedTuple):
    """The end of a walk: where it was found, its cost and its frames."""

    cost: float
    record: int
    macro_edge: int
    frames: int
    complete: bool


@dataclass(kw_only=True)
class Search:
    """One request on one graph: tables, what was found so far, and counts.

    Attributes:
        macro_edges, request: graph and path.
        expanded: partial walks that were extended.
        pruned: extensions and partial walks that were given up: too far off, or too costly.
    """

    macro_edges: MacroEdges
    request: Request
    expanded: int = 0
    pruned: int = 0
    _parents: list[np.ndarray] = field(default_factory=list)
    _macro_edges: list[np.ndarray] = field(default_factory=list)
    _count: int = 0
    _prefixes: dict[int, list[int]] = field(default_factory=dict)

    def remember(self, parents: np.ndarray, macro_edges: np.ndarray) -> np.ndarray:
        """Records of walks: the record they continue and the macro edge they add."""
        records = np.arange(self._count, self._count + len(parents))
        self._parents.append(parents)
        self._macro_edges.append(macro_edges)
        self._count += len(parents)
        return records

    def recorded(self) -> tuple[Int[np.ndarray, " R"], Int[np.ndarray, " R"]]:
        """The record that each remembered walk continues, and the macro edge that it adds."""
        return np.concatenate(self._parents), np.concatenate(self._macro_edges)

    def begin(self, state: Float[np.ndarray, "B 5"], stop: np.ndarray, frames: int = 0) -> Frontier:
        """Walks that begin here, each with a record of its own."""
        nothing = np.full(len(stop), NO_RECORD)
        records = self.remember(nothing, nothing)
        return Frontier(stop, state, np.full(len(stop), frames), records)

    def begin_with(self, state: np.ndarray, stop: int, pieces: list[int]) -> Frontier:
        """A walk that has played pieces already."""
        frames = int(self.macro_edges.pieces.frames[pieces].sum())
        frontier = self.begin(state[None], np.array([stop]), frames)
        self._prefixes[int(frontier.record[0])] = pieces
        return frontier

    def chain(self, record: int, macro_edge: int = NO_RECORD) -> tuple[int, list[int]]:
        """The record a walk began with, and the pieces it is made of."""
        parents, macro_edges = self.recorded()
        taken = [macro_edge] if macro_edge != NO_RECORD else []
        while parents[record] != NO_RECORD:
            taken.append(int(macro_edges[record]))
            record = int(parents[record])
        pieces = list(self._prefixes.get(record, []))
        for one in reversed(taken):
            pieces += [int(p) for p in self.macro_edges.members[one] if p != NO_PIECE]
        return record, pieces

    def expand(
        self, frontier: Frontier, horizon: int, limit: float, most: int | None = None
    ) -> tuple[Frontier, Terminal | None, Terminal | None]:
        """All walks by one macro edge longer that cost less than ``limit``.

        Args:
            front: walks.
            horizon: frames at which a walk is over.
            limit: of the cost.
            most: only so many of the cheapest go on.

        Returns:
            Those that go on, the best that is complete, and the best that reached the horizon.
        """
        row, macro_edge = csr.expand_rows(self.macro_edges.first, frontier.stop)
        durations = self.macro_edges.frames[macro_edge]
        before = frontier.frames[row]
        frames = np.stack([durations, horizon - before], axis=1).astype(np.int32)
        costs = self._costs(frontier.state[row], macro_edge, frames)
        self.expanded += len(frontier.stop)
        after = before + durations
        goes_on = (costs[0] < limit) & (after < horizon)
        complete = _best(
            costs[1], before + costs[2].astype(np.int64), frontier, row, macro_edge, True
        )
        at_horizon = np.where(after >= horizon, costs[0], np.inf)
        reached = _best(at_horizon, np.minimum(after, horizon), frontier, row, macro_edge, False)
        chosen = np.flatnonzero(goes_on)
        if most is not None and len(chosen) > most:
            chosen = chosen[np.argpartition(costs[0, chosen], most)[:most]]
        self.pruned += len(row) - len(chosen)
        children = self._children(frontier, row[chosen], macro_edge[chosen], costs[0, chosen])
        return children, complete, reached

    def _costs(self, state: np.ndarray, macro_edge: np.ndarray, frames: np.ndarray) -> np.ndarray:
        parts = [
            np.asarray(
                extension_costs(
                    self.macro_edges.track,
                    self.macro_edges.speed_heading,
                    self.request,
                    _padded(state[a:b], size),
                    _padded(macro_edge[a:b].astype(np.int32), size),
                    _padded(frames[a:b], size),
                )
            )[:, : b - a]
            for a, b, size in in_buckets(len(macro_edge))
        ]
        return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)

    def _children(
        self, frontier: Frontier, row: np.ndarray, macro_edge: np.ndarray, cost: np.ndarray
    ) -> Frontier:
        tables = self.macro_edges
        state = np.empty((len(row), 5), dtype=np.float32)
        end = tables.end[macro_edge].astype(np.float32)
        state[:, :3] = planar.compose(frontier.place[row], end)
        state[:, 3] = frontier.arc[row] + tables.arc[macro_edge]
        state[:, 4] = cost
        return Frontier(
            tables.target[macro_edge],
            state,
            frontier.frames[row] + tables.frames[macro_edge],
            self.remember(frontier.record[row], macro_edge),
        )

    def bounds(self, frontier: Frontier, horizon: int) -> Float[np.ndarray, " B"]:
        """Cost of each walk with what every continuation adds at least."""
        frames = (horizon - frontier.frames).astype(np.int32)
        parts = [
            np.asarray(
                lower_bounds(
                    self.macro_edges.ahead,
                    self.request,
                    _padded(frontier.state[a:b], size),
                    _padded(frontier.stop[a:b].astype(np.int32), size),
                    _padded(frames[a:b], size),
                )
            )[: b - a]
            for a, b, size in in_buckets(len(frames))
        ]
        return frontier.cost + np.concatenate(parts)


def _best(
    costs: np.ndarray,
    frames: np.ndarray,
    frontier: Frontier,
    row: np.ndarray,
    macro_edge: np.ndarray,
    complete: bool,
) -> Terminal | None:
    if not len(costs):
        return None
    i = int(np.argmin(costs))
    if not np.isfinite(costs[i]):
        return None
    return Terminal(
        float(costs[i]), int(frontier.record[row[i]]), int(macro_edge[i]), int(frames[i]), complete
    )


def _padded(array: np.ndarray, size: int) -> np.ndarray:
    """Zeros after the last row; quicker than numpy.pad, which counts here."""
    out = np.zeros((size, *array.shape[1:]), dtype=array.dtype)
    out[: len(array)] = array
    return out
