"""The two long steps of a build, the search and the blending: in one piece, or in stages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from mgjax.core.body.height import ADULT_M, body_scale
from mgjax.graph.config import GraphConfig
from mgjax.graph.distances.axis import grain_of
from mgjax.graph.distances.minima import Minima, find_minima
from mgjax.graph.feet.legs import FootChains
from mgjax.graph.pruning.candidates import Conditions
from mgjax.graph.pruning.keep import Kept
from mgjax.graph.pruning.shortlist import best_of_seconds
from mgjax.graph.stages.groups import Group, corpus_groups
from mgjax.graph.stages.minima import staged_minima
from mgjax.graph.stages.stages import Stages
from mgjax.graph.stages.transitions import BlendSettings, staged_transitions
from mgjax.graph.timeline import ClipTimeline
from mgjax.graph.transition import build_transitions
from mgjax.io.content_key import content_key

GRAPH = "graph"
"""The stage that finds which transitions are kept."""

_NUMBERS = ("threshold", "dropped", "lost")
"""What is kept of :class:`Kept` beside the transitions."""

Watch = Callable[[float], None]


@dataclass(frozen=True, kw_only=True)
class Steps:
    """What both steps need.

    Attributes:
        timeline: all clips.
        weights: of the joints, with the sum 1. [J]
        window: frames in a window.
        allowed: at which frames a window may begin that is left, and one that is arrived in. [F]
        config: settings.
        stages: where blocks are computed and kept; None: in one piece, here.
        progress: shows bars on stderr.
    """

    timeline: ClipTimeline
    weights: np.ndarray
    window: int
    allowed: tuple[np.ndarray, np.ndarray]
    config: GraphConfig
    stages: Stages | None
    progress: bool

    @cached_property
    def _groups(self) -> list[Group]:
        assert self.stages is not None
        masks = self.allowed if self.config.minima == "allowed" else ()
        return corpus_groups(self.timeline, masks, self.stages, gap=self.config.neighbourhood)

    def minima(self, limit: float, watch: Watch, conditions: Conditions) -> tuple[Minima, bool]:
        """Minima below a limit for an adult, m, and whether they are all that there are, or those
        that may stay. What bounds do not serve is found in one piece."""
        leave, arrive = self.allowed if self.config.minima == "allowed" else (None, None)
        # What is nearest to the limit is decided by the caller.
        scale = body_scale(self.timeline.skeleton)
        threshold, grain = scale * limit * (1 + 1e-12), grain_of(scale * ADULT_M)
        shortlist = best_of_seconds(conditions, threshold**2) if np.isfinite(limit) else None
        if self.stages is None or not np.isfinite(limit) or self.config.range_frames:
            found = find_minima(
                self.timeline.positions,
                self.timeline.starts,
                self.timeline.stops,
                self.weights,
                window=self.window,
                neighbourhood=self.config.neighbourhood,
                threshold=threshold,
                grain=grain,
                leave=leave,
                arrive=arrive,
                thinned=self.config.range_frames,
                shortlist=shortlist,
                progress=self.progress,
                watch=watch,
            )
            return found, shortlist is None
        found = staged_minima(
            self.timeline,
            self._groups,
            self.weights,
            self.stages,
            window=self.window,
            neighbourhood=self.config.neighbourhood,
            threshold=threshold,
            grain=grain,
            leave=leave,
            arrive=arrive,
            shortlist=shortlist,
            progress=self.progress,
            watch=watch,
        )
        return found, shortlist is None

    def kept(self, of: Any, make: Callable[[], Kept]) -> Kept:
        """What is kept of the candidates, as ``make`` finds it; ``of`` is all that it depends on
        beside the settings."""
        key = content_key(of, self.config) if self.stages else ""
        known = self.stages.load(GRAPH, key) if self.stages else None
        if known is not None:
            arrays, numbers = known
            return Kept(transitions=arrays["kept"], **{name: numbers[name] for name in _NUMBERS})
        found = make()
        if self.stages:
            numbers = {name: getattr(found, name) for name in _NUMBERS}
            self.stages.save(GRAPH, key, {"kept": found.transitions}, numbers)
        return found

    def transitions(
        self, rows: np.ndarray, columns: np.ndarray, chains: FootChains | None, watch: Watch
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """What :func:`build_transitions` returns of windows that begin at rows and columns."""
        timeline, config = self.timeline, self.config
        settings = BlendSettings(
            skeleton=timeline.skeleton,
            chains=chains,
            weights=self.weights,
            window=self.window,
            form=config.blend,
            clean=config.clean_feet,
        )
        if self.stages is not None and len(rows):
            return staged_transitions(
                timeline,
                self._groups,
                settings,
                rows,
                columns,
                self.stages,
                progress=self.progress,
                watch=watch,
            )
        return build_transitions(
            settings.skeleton,
            timeline.root,
            timeline.rotations,
            timeline.positions,
            timeline.plants,
            chains,
            rows,
            columns,
            settings.weights,
            settings.window,
            form=settings.form,
            clean=settings.clean,
        )
