"""Candidate transitions: local minima of the distance over every ordered pair of clips.

All clips lie on one axis of frames, with a gap after each. Pairs are compared in tiles that are
thrown away once searched, so memory does not grow with the square of the clips' length. What
float32 cannot tell apart, float64 decides: both ways of searching find the same minima.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from tqdm import tqdm

from mgjax.core.errors import ConfigError
from mgjax.graph.distances.axis import make_axis
from mgjax.graph.distances.judge import MAYBE, settle
from mgjax.graph.distances.pruned import search_pruned
from mgjax.graph.distances.tiles import search_tiles

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
        search: ``"all"`` pairs, or ``"pruned"`` by bounds, with the same result; bounds serve
            neither blocks nor an infinite threshold. ``"auto"``: bounds where there is much.
        progress: shows a bar on stderr.
        watch: told the share of the work that is done.

    Raises:
        ConfigError: a pruned search for what bounds do not serve.
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
    )
    limit = float(threshold) ** 2

    def watched(tiles: list[tuple[int, int]]) -> Iterator[tuple[int, int]]:
        bar: Iterable[tuple[int, int]] = tqdm(
            tiles, desc="distances", unit="tile", disable=not progress, leave=False
        )
        for number, tile in enumerate(bar):
            if watch is not None:
                watch(number / len(tiles))
            yield tile

    can = np.isfinite(limit) and not thinned
    if search == "pruned" and not can:
        what = "blocks" if thinned else "an infinite threshold"
        raise ConfigError(
            got=f"a pruned search for {what}", expected="a finite threshold, no blocks"
        )
    largest = 0.0
    if search == "pruned" or (search == "auto" and can and len(positions) > _SMALL):
        found = search_pruned(axis, limit, watched=watched)
    else:
        found, largest = search_tiles(axis, limit, thinned=thinned, watched=watched)
    rows, columns, judged = found[:3].astype(np.int64)
    squared = found[3]
    unsure = np.flatnonzero(judged == MAYBE)
    squared[unsure] = settle(axis, rows[unsure], columns[unsure], limit)
    rows, columns = axis.frames[rows], axis.frames[columns]
    order = np.lexsort((columns, rows, squared))
    order = order[squared[order] < limit]
    return Minima(
        rows=rows[order],
        columns=columns[order],
        distances=np.sqrt(squared[order]),
        largest=float(np.sqrt(largest)) if np.isinf(limit) else 0.0,
    )
