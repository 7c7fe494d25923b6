"""Which minima may become transitions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.core.body.height import body_scale
from mgjax.graph.blending.alignment import same_support
from mgjax.graph.config import GraphConfig
from mgjax.graph.pruning.prune import Candidates
from mgjax.graph.timeline import ClipTimeline


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """What a minimum has to fulfil.

    Attributes:
        timeline: all clips.
        allowed: at which frames a window may begin that is left, and one that is arrived in. [F]
        window: frames in a window.
        config: of the graph.
    """

    timeline: ClipTimeline
    allowed: tuple[np.ndarray, np.ndarray]
    window: int
    config: GraphConfig

    def candidates(
        self,
        rows: Int[np.ndarray, " M"],
        columns: Int[np.ndarray, " M"],
        distances: Float[np.ndarray, " M"],
    ) -> tuple[Candidates, Bool[np.ndarray, " M"]]:
        """The candidates among some minima, and which of those they are.

        Args:
            rows, columns: frames that the windows begin at.
            distances: m, ascending.
        """
        timeline, config, window = self.timeline, self.config, self.window
        leaves, arrives = (
            np.searchsorted(timeline.starts, frames, side="right") for frames in (rows, columns)
        )
        gap = round(config.self_gap_s * config.frame_rate)
        near = (leaves == arrives) & (np.abs(rows - columns) < gap)
        ok = ~near & self.allowed[0][rows] & self.allowed[1][columns]
        if config.contacts > 0:
            ok &= same_support(timeline.plants, rows, columns, window) >= config.contacts
        found = Candidates(
            leave=rows[ok],
            arrive=columns[ok] + window,
            distances=distances[ok] / body_scale(timeline.skeleton),
            starts=timeline.starts,
            stops=timeline.stops,
            label_starts=timeline.core_starts,
            label_stops=timeline.core_stops,
        )
        return found, ok
