"""Candidates as compiled code reads them, padded to few sizes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.core.arrays import Array
from mgjax.core.xla.padding import bucket_size
from mgjax.core.xla.pytree import register
from mgjax.graph.types import NO_EDGE

CANDIDATE_TILE = 64
"""Candidates judged together: their volumes then stay in the cache."""

CANDIDATE_BUCKETS = (CANDIDATE_TILE, 1024, 4096)
"""Numbers of candidates that a call is compiled for; then four times as many, …

From two tiles on those without candidates are left out, so more sizes would hardly save time.
"""

LONG_CANDIDATE_BUCKETS = (1024, 4096)
"""Numbers of candidates that a call is compiled for where walks or attacks are long."""

EDGE_BUCKET = 40
"""Edges of a walk that a call is compiled for, and four times as many, …"""


@register("shared")
@dataclass(frozen=True, kw_only=True)
class CandidateBatch:
    """Candidates as compiled code reads them.

    Attributes:
        table: edges of each walk, padded; then how many they are (0 for a candidate that is
            padding), the avoidance part at the end, and which of several attacks it is meant for.
            [L+3, C]
        shared: whether all are meant for one attack.
    """

    table: Int[Array, "L3 C"]
    shared: bool

    @property
    def edges(self) -> Int[Array, "L C"]:
        """Padded."""
        return self.table[:-3]

    @property
    def length(self) -> Int[Array, " C"]:
        """Edges."""
        return self.table[-3]

    @property
    def part(self) -> Int[Array, " C"]:
        """The avoidance part at the end."""
        return self.table[-2]

    @property
    def owner(self) -> Int[Array, " C"] | None:
        """The attack of each; None where there is but one."""
        return None if self.shared else self.table[-1]

    def each(self, values: Float[Array, " A"]) -> Float[Array, " C"]:
        """What is known of attacks, for each of the walks."""
        if self.owner is None:
            return jnp.broadcast_to(values, self.length.shape)
        return values[self.owner]

    def rows(self, chosen: Int[Array, " K"]) -> CandidateBatch:
        """The batch of the candidates with the given numbers."""
        return replace(self, table=self.table[:, chosen])


def empty_candidate_batch(longest: int, count: int, *, shared: bool) -> CandidateBatch:
    """Room for walks, all of them padding."""
    table = np.full((longest + 3, count), NO_EDGE, np.int32)
    table[longest:] = 0
    return CandidateBatch(table=table, shared=shared)


def pad_candidates(candidates: Candidates, *, long: bool = False) -> CandidateBatch:
    """Candidates padded to few sizes; to larger ones if their attack is ``long``."""
    count, longest = len(candidates.length), int(candidates.length.max(initial=1))
    sizes = LONG_CANDIDATE_BUCKETS if long else CANDIDATE_BUCKETS
    size = next((s for s in sizes if count <= s), 0) or bucket_size(count, sizes[-1], 4)
    edges = bucket_size(max(longest, EDGE_BUCKET + 1 if long else 0), EDGE_BUCKET, 4)
    walks = empty_candidate_batch(edges, size, shared=True)
    table = walks.table
    table[:longest, :count] = candidates.edges[:, :longest].T
    table[-3, :count], table[-2, :count] = candidates.length, candidates.part
    return walks
