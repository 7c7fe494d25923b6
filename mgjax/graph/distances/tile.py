"""What the search needs to know of the windows of one tile, as rows and as columns."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float
from numpy.lib.stride_tricks import sliding_window_view

from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.bounds import FAR, bound_rows
from mgjax.graph.distances.components import Components, Parts, parts_of
from mgjax.graph.distances.distance import WindowFeatures

Described = TypeVar("Described", WindowFeatures, Parts)


@dataclass(frozen=True, kw_only=True, eq=False)
class Tile:
    """The entries of an axis in one tile, and as many as the margin has on both sides.

    Attributes:
        axis: of all clips.
        number: of the tile.
        size: entries without the margins.
        components: of :meth:`parts`.
    """

    axis: Axis
    number: int
    size: int
    components: Components

    @cached_property
    def features(self) -> tuple[WindowFeatures, WindowFeatures]:
        """As rows and as columns; what is not allowed there is far from everything."""
        return self._masked(self._plain)

    @cached_property
    def parts(self) -> tuple[Parts, Parts]:
        """By components, likewise."""
        return self._masked(self._parts)

    @property
    def longest(self) -> float:
        """Squared length of the longest window, m²."""
        spread = np.asarray(self._plain.spread)
        return float(spread.max(where=self._used, initial=0.0))

    @property
    def bound_rows(self) -> Float[np.ndarray, "C T"]:
        """Of the entries without the margins."""
        inner = slice(self.axis.margin, self.axis.margin + self.size)
        return bound_rows(self._parts, self._used)[:, inner]

    @cached_property
    def alike(self) -> Bool[np.ndarray, " T"]:
        """Entries around which the same count as rows as count as columns; without the margins."""
        reach = 2 * self.axis.margin + 1
        same = np.equal(*self._allowed)
        return np.asarray(sliding_window_view(same, reach).all(axis=1))

    def limits(self, limits: Float[np.ndarray, " F"]) -> Float[np.ndarray, " T"]:
        """Of the entries by those of the frames, m²; 0 where no window begins."""
        size = self.size + 2 * self.axis.margin
        first = self.number * self.size
        frames = self.axis.frames[first : first + size]
        return np.pad(np.where(frames >= 0, limits[frames], 0.0), (0, size - len(frames)))

    @cached_property
    def _allowed(self) -> Bool[np.ndarray, "2 S"]:
        size = self.size + 2 * self.axis.margin
        known = np.stack([self.axis.leave, self.axis.arrive])
        known = known[:, self.number * self.size :][:, :size]
        return np.pad(known, ((0, 0), (0, size - known.shape[1])))

    @property
    def _used(self) -> Bool[np.ndarray, " S"]:
        return np.logical_or(*self._allowed)

    @cached_property
    def _plain(self) -> WindowFeatures:
        axis = self.axis
        return axis.features(self.number * self.size, self.size + 2 * axis.margin)

    @cached_property
    def _parts(self) -> Parts:
        return parts_of(self._plain, self.components, self.axis.window)

    def _masked(self, plain: Described) -> tuple[Described, Described]:
        """``plain`` as rows and as columns."""
        where = jnp.where if isinstance(plain.spread, jax.Array) else np.where
        rows, columns = (
            replace(plain, spread=where(mask, plain.spread, np.float32(FAR)))
            for mask in self._allowed
        )
        return rows, columns
