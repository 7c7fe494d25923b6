"""What a choice asks of an index of candidates, however the index finds it (§5.1)."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.index.found_paths import FoundPaths


@runtime_checkable
class CandidateIndex(Protocol):
    """Walks to avoidance parts that were looked for beforehand."""

    def in_time(self, node: int, t_attack: float, window: float) -> FoundPaths | None:
        """All walks from a node with t_attack − T/2 < t_avoid < t_attack + T/2 (eq. 1).

        Args:
            node: where the walks begin.
            t_attack: s from the beginning of the walk.
            window: T, s.

        Returns:
            The walks as paths of the index, or None where the index cannot say.
        """
        ...

    def touched(
        self, paths: FoundPaths, attack: Attack, crop: Crop
    ) -> Bool[np.ndarray, " C"] | None:
        """Which of some walks avoid something that is where the attack passes through.

        Args:
            paths: walks of one node.
            attack: in the planar frame of that node.
            crop: the part of it that counts.

        Returns:
            Whether each does, or None where the index cannot say.
        """
        ...

    def walks(self, paths: FoundPaths) -> Candidates:
        """The edges of walks, in the order of
        :func:`~mgjax.avoidance.candidates.enumerate.enumerate_candidates` as
        long as that of the paths is kept."""
        ...
