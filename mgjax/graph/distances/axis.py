"""All clips on one axis of frames with gaps between them, so that neighbourhoods never meet."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.core.arrays import Array
from mgjax.graph.distances.distance import WindowFeatures, centre_of, features_about
from mgjax.graph.distances.windows import Windows, windows_of


@dataclass(frozen=True, kw_only=True, eq=False)
class Axis:
    """Window starts of all clips, with ``margin`` entries before, between and after them.

    An entry of a gap, or whose window does not fit its clip, is infinitely far from all others.

    Attributes:
        positions: joints of all clips one after another, m. [F, J, 3]
        weights: with the sum 1. [J]
        window: frames in a window.
        margin: entries in a gap.
        grain: squared distances that differ by less are alike, m²; as the bodies are, larger for
            larger ones.
        frames: frame of each entry; −1 in a gap. [R]
        centre: about the middle of all joints, from which their places are taken. [3]
        valid: which entries are windows. [R]
        leave, arrive: which of them count as rows and as columns. [R]
    """

    positions: Float[np.ndarray, "F J 3"]
    weights: Float[np.ndarray, " J"]
    window: int
    margin: int
    centre: Float[np.ndarray, "3"]
    grain: float
    frames: Int[np.ndarray, " R"]
    valid: Bool[np.ndarray, " R"]
    leave: Bool[np.ndarray, " R"]
    arrive: Bool[np.ndarray, " R"]

    def __len__(self) -> int:
        return len(self.frames)

    @cached_property
    def windows(self) -> Windows:
        """All windows in float64."""
        return windows_of(self.positions, self.weights, self.window)

    def tiles(self, size: int) -> int:
        """How many tiles of so many entries there are, beside the margin in front."""
        return -(-(len(self) - self.margin) // size)

    def masks(self, size: int) -> tuple[Array, Array]:
        """Those of rows and columns, with room for the last tile."""
        length = self.tiles(size) * size + 2 * self.margin
        leave, arrive = np.zeros((2, length), bool)
        leave[: len(self)], arrive[: len(self)] = self.leave, self.arrive
        return jnp.asarray(leave), jnp.asarray(arrive)

    def features(self, first: int, count: int) -> WindowFeatures:
        """Features of the entries ``first … first + count − 1``; what lies beyond is not valid."""
        size = count + self.window - 1
        frames = np.full(size, -1)
        known = self.frames[first : first + size]
        frames[: len(known)] = known
        places = self.positions[np.maximum(frames, 0)]
        places = np.where(frames[:, None, None] >= 0, places, 0).astype(np.float32)
        return features_about(places, self.centre, self.weights, self.window)


def make_axis(
    positions: Float[np.ndarray, "F J 3"],
    starts: np.ndarray,
    stops: np.ndarray,
    weights: np.ndarray,
    *,
    window: int,
    margin: int,
    leave: np.ndarray | None,
    arrive: np.ndarray | None,
    grain: float | None = None,
) -> Axis:
    """The axis of clips that lie one after another; see
    :func:`mgjax.graph.distances.minima.find_minima`."""
    pieces: list[np.ndarray] = [np.full(margin, -1)]
    valid: list[np.ndarray] = [np.zeros(margin, dtype=bool)]
    for start, stop in zip(starts, stops, strict=True):
        pieces += [np.arange(start, stop), np.full(margin, -1)]
        fits = np.arange(start, stop) + window <= stop
        valid += [fits, np.zeros(margin, dtype=bool)]
    frames, fits = np.concatenate(pieces), np.concatenate(valid)
    rows, columns = (fits if some is None else fits & some[frames] for some in (leave, arrive))
    return Axis(
        positions=positions,
        weights=weights,
        window=window,
        margin=margin,
        centre=centre_of(positions, float(positions[..., 1].mean())),
        grain=grain_of(float(np.ptp(positions[..., 1])) if positions.size else 0.0)
        if grain is None
        else grain,
        frames=frames,
        valid=fits,
        leave=rows,
        arrive=columns,
    )


def grain_of(tall: float) -> float:
    """Of squared distances of bodies so tall (m): a power of two, about 1e-12 m² for an adult; four
    times that for a body twice as tall. A finer one would tell windows apart that are alike."""
    return float(2.0 ** (2 * np.floor(np.log2(tall)) - 40)) if tall > 0 else 2.0**-40
