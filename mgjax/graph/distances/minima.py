"""Candidate transitions: local minima of the distance over every ordered pair of clips.

All clips lie on one axis of frames, with a gap after each. Pairs are compared in tiles that are
thrown away once searched, so memory does not grow with the square of the clips' length. What
float32 cannot tell apart, float64 decides: both ways of searching find the same minima.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Literal, Protocol, TypeVar, runtime_checkable

import numpy as np
from jaxtyping import Float, Int
from tqdm import tqdm

from mgjax.core.errors import ConfigError
from mgjax.graph.distances.axis import Axis, make_axis
from mgjax.graph.distances.judge import MAYBE, neighbours, settle
from mgjax.graph.distances.pruned import search_pruned, tile_pairs
from mgjax.graph.distances.tiles import search_tiles

T = TypeVar("T")

_BATCH = 1 << 14
"""Minima that are handed to a shortlist at once."""

_SMALL = 4096
"""Up to so many frames all pairs are compared: that needs no programs of its own."""


@dataclass(frozen=True, kw_only=True)
class Minima:
    """Local minima of the window distance, sorted by distance.

    Attributes:
        rows, columns: window starts on the flat axis of frames. [M]
        distances: m RMS. [M]
        largest: the largest distance of any pair of windows, m; 0 unless all minima were asked for.
    """

    rows: np.ndarray
    columns: np.ndarray
    distances: np.ndarray
    largest: float


@runtime_checkable
class Shortlist(Protocol):
    """Of the minima found so far those that may be wanted."""

    def limits(self) -> Float[np.ndarray, " F"]:
        """What a further one has to be below by the frame that its row begins at, m²."""
        ...

    def add(self, rows: np.ndarray, columns: np.ndarray, squared: np.ndarray) -> None:
        """Further ones: frames that their windows begin at, and D², m². [M]"""
        ...

    def kept(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Those of all that may be wanted, likewise."""
        ...


def find_minima(
    positions: Float[np.ndarray, "F J 3"],
    starts: np.ndarray,
    stops: np.ndarray,
    weights: np.ndarray,
    *,
    window: int,
    neighbourhood: int,
    threshold: float,
    leave: np.ndarray | None = None,
    arrive: np.ndarray | None = None,
    thinned: int = 0,
    grain: float | None = None,
    shortlist: Shortlist | None = None,
    search: Literal["auto", "all", "pruned"] = "auto",
    progress: bool = False,
    watch: Callable[[float], None] | None = None,
) -> Minima:
    """Minima of the distance below ``threshold``, each the lowest of its neighbourhood.

    Args:
        positions: joints of all clips one after another, m.
        starts, stops: frames of each clip on that axis, stop exclusive.
        weights: [J], with the sum 1.
        window: frames in a window.
        neighbourhood: n; a minimum is compared with its (2n+1)² − 1 neighbours in the matrix of its
            own pair of clips. Ties go to the lowest (row, column), so that a flat bottom has one.
        threshold: m; ``numpy.inf`` for all minima.
        leave, arrive: at which frames windows of the rows and of the columns may begin; None: at
            all. Others count as infinitely far, so a minimum is the lowest of what may be used.
        thinned: also the lowest pair of each block of so many by so many windows; 0: only minima.
        grain: squared distances that differ by less are alike, m²; None: by the height that is
            moved through.
        shortlist: takes the minima as they are found, and says which others it would still take.
            The result then is what it keeps.
        search: ``"all"`` pairs, or ``"pruned"`` by bounds, with the same result; bounds serve
            neither blocks nor an infinite threshold. ``"auto"``: bounds where there is much.
        progress: shows a bar on stderr.
        watch: told the share of the work that is done.

    Raises:
        ConfigError: a pruned search for what bounds do not serve; a shortlist where bounds are not
            used.
    """
    axis = make_axis(
        positions,
        starts,
        stops,
        weights,
        window=window,
        margin=neighbourhood,
        leave=leave,
        arrive=arrive,
        grain=grain,
    )
    limit = float(threshold) ** 2

    def watched(tiles: Iterable[T], count: int, done: Callable[[T], bool]) -> Iterator[T]:
        with tqdm(
            desc="distances", unit="tile", total=count, disable=not progress, leave=False
        ) as bar:
            for tile in tiles:
                if watch is not None:
                    watch(bar.n / count)
                yield tile
                bar.update(done(tile))

    can = np.isfinite(limit) and not thinned
    if search == "pruned" and not can:
        what = "blocks" if thinned else "an infinite threshold"
        raise ConfigError(
            got=f"a pruned search for {what}", expected="a finite threshold, no blocks"
        )
    pruned = search == "pruned" or (search == "auto" and can and len(positions) > _SMALL)
    if shortlist is not None and not pruned:
        raise ConfigError(got="a shortlist", expected="a search that is pruned")
    largest = 0.0
    if pruned:
        limits = None if shortlist is None else shortlist.limits
        pairs = tile_pairs(axis)
        searched = search_pruned(axis, limit, pairs, limits=limits)
        found = (each for each, _ in watched(searched, len(pairs), lambda part: part[1]))
        if shortlist is not None:
            for batch in _batches(found):
                shortlist.add(*_placed(axis, batch))
            rows, columns, squared = shortlist.kept()
        else:
            rows, columns, squared = _placed(axis, _joined(list(found)))
    else:
        every, largest = search_tiles(
            axis,
            limit,
            thinned=thinned,
            watched=lambda pairs: watched(pairs, len(pairs), lambda _: True),
        )
        rows, columns, squared = _placed(axis, _settled(axis, every, limit))
    order = np.lexsort((columns, rows, squared))
    return Minima(
        rows=rows[order],
        columns=columns[order],
        distances=np.sqrt(squared[order]),
        largest=float(np.sqrt(largest)) if np.isinf(limit) else 0.0,
    )


def _settled(axis: Axis, found: Int[np.ndarray, "3 N"], limit: float) -> Float[np.ndarray, "3 M"]:
    """Rows, columns and D², m², of the minima among pairs that are judged."""
    rows, columns, judged = found
    unsure = np.flatnonzero(judged == MAYBE)
    doubts = [unsure] * len(neighbours(axis.margin))
    squared, lowest = settle(axis, rows, columns, limit, doubts)
    return np.stack([rows, columns, squared])[:, lowest[0]]


def _placed(
    axis: Axis, found: Float[np.ndarray, "3 M"]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frames that the windows of minima begin at, and D², m²."""
    rows, columns = found[:2].astype(np.int64)
    return axis.frames[rows], axis.frames[columns], found[2]


def _joined(found: list[np.ndarray]) -> Float[np.ndarray, "3 M"]:
    return np.concatenate([np.zeros((3, 0)), *found], axis=1)


def _batches(found: Iterable[np.ndarray]) -> Iterator[Float[np.ndarray, "3 M"]]:
    """Joins what is found to batches of about ``_BATCH``."""
    waiting: list[np.ndarray] = []
    count = 0
    for each in found:
        waiting.append(each)
        count += each.shape[1]
        if count >= _BATCH:
            yield _joined(waiting)
            waiting, count = [], 0
    yield _joined(waiting)
