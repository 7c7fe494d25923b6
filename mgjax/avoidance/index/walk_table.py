"""Walks of the grid index: those to an avoidance part, and the stretches that longer ones share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int, Integer, UInt

from mgjax.core.csr import expand, row_starts


@dataclass(frozen=True, kw_only=True, eq=False)
class WalkTable:
    """Some walks of every node, in as few bytes as hold them; those of a node lie together.

    Attributes:
        first: the walks of node n are first[n] … first[n+1] − 1. [N+1]
        end: where a walk leads: a node, or an avoidance part on its last edge. [X]
        time: until then, half frames: until the node is reached, or the middle of the part. [X]
        length: edges of a walk. [X]
        rank: place in the order of out-edges taken, then parts, among all walks of the node that
            have one, counted from 1; 0: none. [X]
        place: planar frame of the node that the walk leads to, or at which the part's edge begins,
            in that of the node where the walk begins: θ in rad, x and z in m. [X, 3]
        edges: of all walks that have a rank, one after another. [Y]
    """

    first: UInt[np.ndarray, " N1"]
    end: UInt[np.ndarray, " X"]
    time: UInt[np.ndarray, " X"]
    length: UInt[np.ndarray, " X"]
    rank: UInt[np.ndarray, " X"]
    place: Float[np.ndarray, "X 3"]
    edges: UInt[np.ndarray, " Y"]

    @cached_property
    def first_edge(self) -> Int[np.ndarray, " X1"]:
        """The edges of walk x are edges[first_edge[x]] … edges[first_edge[x+1] − 1]."""
        return row_starts(np.where(self.rank > 0, self.length.astype(np.int64), 0))

    def of_nodes(self, nodes: Int[np.ndarray, " R"]) -> tuple[np.ndarray, np.ndarray]:
        """All walks of some nodes: which of the nodes each is of, and its number."""
        if len(nodes) == 1:  # as at the beginning of every look-up
            node = nodes.item()
            number = np.arange(self.first.item(node), self.first.item(node + 1))
            return np.zeros(len(number), np.int64), number
        first = self.first[nodes].astype(np.int64)
        row, number = expand(self.first[nodes + 1] - first)
        return row, first[row] + number


@dataclass(frozen=True, kw_only=True, eq=False)
class Arrivals(WalkTable):
    """Walks to an avoidance part. Those without a rank begin with one of their node's jumps.

    Attributes:
        jump: which of them, counted from the node's first; 0 with a rank. [X]
        then: which arrival of the node it leads to goes on; 0 with a rank. [X]
    """

    jump: UInt[np.ndarray, " X"]
    then: UInt[np.ndarray, " X"]


def smallest(values: Integer[np.ndarray, "*a"]) -> UInt[np.ndarray, "*a"]:
    """Numbers ≥ 0 in as few bytes as hold them."""
    return values.astype(np.min_scalar_type(int(values.max(initial=0))))
