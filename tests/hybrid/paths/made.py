"""Graphs for the tests of the path search."""

from __future__ import annotations

from functools import lru_cache

from mgjax.clips.synthetic import synthetic_clips
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import MotionGraph


@lru_cache(maxsize=2)
def walking(
    names: tuple[str, ...] = ("walk", "walk_curve"), neighbourhood: int = 10
) -> MotionGraph:
    """Embedded clips of walking with few transitions, so that all walks can be enumerated."""
    clips = [clip for clip in synthetic_clips()[0] if clip.name in names]
    config = GraphConfig(threshold_m=0.05, neighbourhood=neighbourhood, best_per_s=0)
    return build_graph(clips, config=config)
