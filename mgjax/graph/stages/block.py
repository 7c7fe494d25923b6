"""Minima of the distance between two groups of clips: the unit of work of the search.

What a block holds depends on its own clips only. Which pairs are minima, float64 decides where
float32 cannot; here the distances of all of them are measured in float64, too, since float32 sees
them differently beside other clips.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mgjax.core.xla.compilation import threads
from mgjax.graph.distances.axis import Axis, make_axis
from mgjax.graph.distances.components import Components
from mgjax.graph.distances.pruned import TILE, search_pruned

PART = 4
"""Most pairs of tiles in one block: two groups of short clips are one pair."""


@dataclass(frozen=True, kw_only=True)
class BlockTask:
    """Pairs of tiles of one group of clips, or of two.

    Attributes:
        positions: joints of the frames of each group, m. 1 or 2 × [G, J, 3]
        lengths: frames of each clip of each group.
        leave, arrive: where windows may begin, as rows and as columns. 1 or 2 × [G]
        weights: of the joints. [J]
        window, neighbourhood, limit: of :func:`mgjax.graph.distances.minima.find_minima`; the
            limit in m², finite.
        limits: what a minimum has to be below by the frame that its row begins at, m². 1 or 2 ×
            [G]
        grain: of squared distances, m², the same for all blocks.
        components: of bounds; they decide how quickly the minima are found, not which.
        part: which ``PART`` of the pairs of tiles.
    """

    positions: tuple[np.ndarray, ...]
    lengths: tuple[tuple[int, ...], ...]
    leave: tuple[np.ndarray, ...]
    arrive: tuple[np.ndarray, ...]
    weights: np.ndarray
    window: int
    neighbourhood: int
    limit: float
    limits: tuple[np.ndarray, ...]
    grain: float
    components: Components
    part: int


def search_block(task: BlockTask) -> dict[str, np.ndarray]:
    """Minima of a block, both ways round.

    Returns:
        ``rows`` and ``columns``, frames where windows begin, counted through both groups, and
        ``squared``, their D², m². [M] ``below``, the limits that they were looked for
        below, m², each for the frames before ``until``. [N]
    """
    axis, tiles = _block_axis(task)
    pairs = tile_pairs(tiles)[task.part * PART : (task.part + 1) * PART]

    limits = np.concatenate(task.limits)
    each = search_pruned(
        axis,
        task.limit,
        pairs,
        limits=limits,
        threads=threads(),
        components=task.components,
    )
    found = np.concatenate([np.zeros((3, 0)), *(found for found, _ in each)], axis=1)
    rows, columns = found[:2].astype(np.int64)
    squared = found[2]
    # A pair that was found for the sake of its column may be above the limit of its row.
    kept = squared <= limits[axis.frames[rows]]
    until = np.append(np.flatnonzero(np.diff(limits)) + 1, len(limits))
    return {
        "rows": axis.frames[rows[kept]].astype(np.int32),
        "columns": axis.frames[columns[kept]].astype(np.int32),
        "squared": squared[kept],
        "until": until.astype(np.int32),
        "below": limits[until - 1],
    }


def tile_counts(lengths: Sequence[Sequence[int]], neighbourhood: int) -> tuple[int, ...]:
    """Tiles of each group."""
    entries = (sum(each) + neighbourhood * len(each) for each in lengths)
    return tuple(-(-count // TILE) for count in entries)


def tile_pairs(tiles: Sequence[int]) -> list[tuple[int, int]]:
    """Within one group each pair of tiles once; of two groups those of one with the other."""
    first = tiles[0]
    if len(tiles) == 1:
        return [(i, j) for i in range(first) for j in range(i, first)]
    return [(i, first + j) for i in range(first) for j in range(tiles[1])]


def _block_axis(task: BlockTask) -> tuple[Axis, tuple[int, ...]]:
    """The groups on one axis, each beginning with a tile; and how many tiles they have."""
    margin = task.neighbourhood
    tiles = tile_counts(task.lengths, margin)
    stops = np.cumsum([length for group in task.lengths for length in group])
    starts = np.concatenate([[0], stops[:-1]])
    whole = make_axis(
        np.concatenate(task.positions),
        starts,
        stops,
        task.weights,
        window=task.window,
        margin=margin,
        leave=np.concatenate(task.leave),
        arrive=np.concatenate(task.arrive),
        grain=task.grain,
    )
    first = sum(task.lengths[0]) + margin * len(task.lengths[0]) + margin
    missing = np.zeros(margin + tiles[0] * TILE - first if len(tiles) > 1 else 0, bool)

    def spread(values: np.ndarray, gap: np.ndarray) -> np.ndarray:
        return np.concatenate([values[:first], gap, values[first:]])

    axis = replace(
        whole,
        frames=spread(whole.frames, np.full(len(missing), -1)),
        valid=spread(whole.valid, missing),
        leave=spread(whole.leave, missing),
        arrive=spread(whole.arrive, missing),
    )
    return axis, tiles
