"""Candidate transitions: local minima of the distance over every ordered pair of clips.

All clips lie on one axis of frames, with a gap after each, and the matrix of that axis with itself
is computed in tiles that are thrown away once searched, so memory does not grow with the square of
the clips' length.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int
from tqdm import tqdm

from mgjax.core.arrays import Array
from mgjax.core.xla.padding import pad_axis
from mgjax.graph.distance import (
    WindowFeatures,
    block_distances,
    rows_of,
    trim_paths,
    window_features,
)

TILE = 1024


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


@partial(jax.jit, static_argnames=("window", "reach", "thinned"))
def _tile(
    a: WindowFeatures,
    b: WindowFeatures,
    valid: Bool[Array, " R"],
    leave: Bool[Array, " R"],
    arrive: Bool[Array, " R"],
    row: Array,
    column: Array,
    threshold: Float[Array, ""],
    *,
    window: int,
    reach: int,
    thinned: int,
) -> tuple[Bool[Array, "T T"], Float[Array, "T2 T2"]]:
    """One tile of window starts: which are minima, and all D² with a margin of ``reach``.

    ``valid``: windows that fit their clip; ``leave`` and ``arrive``: those of them that count as
    rows and as columns.
    """
    size = TILE + 2 * reach
    squared = block_distances(
        rows_of(a, row, size, window), rows_of(b, column, size, window), window
    )

    def pairs(rows: Array, columns: Array) -> Array:
        return (
            jax.lax.dynamic_slice_in_dim(rows, row, size)[:, None]
            & jax.lax.dynamic_slice_in_dim(columns, column, size)[None, :]
        )

    every = jnp.where(pairs(valid, valid), jnp.maximum(squared, 0.0), jnp.inf)
    squared = jnp.where(pairs(leave, arrive), every, jnp.inf)
    inner = slice(reach, reach + TILE)
    centre = squared[inner, inner]
    minima = centre < threshold**2
    for i in range(-reach, reach + 1):
        for j in range(-reach, reach + 1):
            other = squared[reach + i : reach + i + TILE, reach + j : reach + j + TILE]
            if (i, j) < (0, 0):
                minima &= centre < other  # a tie goes to the lower (row, column)
            elif (i, j) > (0, 0):
                minima &= centre <= other
    if thinned:
        minima |= (centre < threshold**2) & _lowest_of_blocks(centre, thinned)
    return minima, every


def _lowest_of_blocks(squared: Float[Array, "T T"], size: int) -> Bool[Array, "T T"]:
    """Which are the lowest of their block of ``size`` × ``size`` entries; blocks at the ends may be
    smaller."""
    count = -(-TILE // size)
    pad = count * size - TILE
    blocks = jnp.pad(squared, (0, pad), constant_values=jnp.inf).reshape(count, size, count, size)
    lowest = blocks.min(axis=(1, 3))
    spread = jnp.repeat(jnp.repeat(lowest, size, axis=0), size, axis=1)
    return squared <= spread[:TILE, :TILE]


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
        progress: shows a bar on stderr.
        watch: told the share of tiles that are done.
    """
    frames, valid, features = _features(positions, starts, stops, weights, window, neighbourhood)
    features, _ = trim_paths(features, features)
    features = jax.tree.map(jnp.asarray, features)
    masks = [
        jnp.asarray(pad_axis(_where(valid, frames, allowed), len(features.spread), value=0))
        for allowed in (None, leave, arrive)
    ]
    count = -(-(len(valid) - neighbourhood) // TILE)  # as many as the features have room for
    minima: list[tuple[np.ndarray, ...]] = []
    largest = 0.0
    tiles = [(i * TILE, j * TILE) for i in range(count) for j in range(count)]
    bar = tqdm(tiles, desc="distances", unit="tile", disable=not progress, leave=False)
    for number, (row, column) in enumerate(bar):
        if watch is not None:
            watch(number / len(tiles))
        hits, squared = _tile(
            features,
            features,
            *masks,
            jnp.int32(row),
            jnp.int32(column),
            jnp.float32(min(threshold, 1e18) * (1 + 1e-5)),
            window=window,
            reach=neighbourhood,
            thinned=thinned,
        )
        squares = np.asarray(squared)[neighbourhood:-neighbourhood, neighbourhood:-neighbourhood]
        if np.isinf(threshold):
            largest = max(largest, float(squares.max(where=np.isfinite(squares), initial=0.0)))
        r, c = np.nonzero(np.asarray(hits))
        if len(r):
            minima.append((r + row, c + column, squares[r, c]))
    parts = [np.concatenate(x) for x in zip(*minima, strict=True)] if minima else [np.zeros(0)] * 3
    # The axis carries the neighbourhood as a margin in front.
    r, c = (frames[x.astype(np.int64) + neighbourhood] for x in parts[:2])
    distance = np.sqrt(parts[2].astype(np.float64))
    order = np.lexsort((c, r, distance))
    order = order[distance[order] < threshold]  # exactly, which float32 cannot tell
    return Minima(
        rows=r[order],
        columns=c[order],
        distances=distance[order],
        largest=float(np.sqrt(largest)),
    )


def _where(
    valid: Bool[np.ndarray, " R"], frames: Int[np.ndarray, " R"], allowed: np.ndarray | None
) -> Bool[np.ndarray, " R"]:
    """Which entries of the axis with gaps are windows that may be used."""
    return valid if allowed is None else valid & allowed[frames]


def _features(
    positions: np.ndarray,
    starts: np.ndarray,
    stops: np.ndarray,
    weights: np.ndarray,
    window: int,
    margin: int,
) -> tuple[np.ndarray, np.ndarray, WindowFeatures]:
    """Features of an axis with gaps of ``margin`` frames, each entry's frame, and which are starts.

    Windows that do not fit their clip count as infinitely far, as do those of the gaps, so the
    neighbourhoods of two pairs of clips never meet.
    """
    pieces: list[np.ndarray] = [np.full(margin, -1)]
    valid: list[np.ndarray] = [np.zeros(margin, dtype=bool)]
    for start, stop in zip(starts, stops, strict=True):
        pieces += [np.arange(start, stop), np.full(margin, -1)]
        fits = np.arange(start, stop) + window <= stop
        valid += [fits, np.zeros(margin, dtype=bool)]
    frames, starting = np.concatenate(pieces), np.concatenate(valid)
    rows = -(-(len(frames) - margin) // TILE) * TILE + 2 * margin
    size = rows + window - 1
    padded = np.zeros((size, *positions.shape[1:]), dtype=np.float32)
    padded[: len(frames)][frames >= 0] = positions[frames[frames >= 0]]
    level = float(positions[..., 1].mean())
    return frames, starting, window_features(padded, weights, level, window)
