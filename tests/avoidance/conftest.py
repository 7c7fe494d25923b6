"""Graphs that are built once for all tests of the avoidance room."""

from __future__ import annotations

import pytest

from mgjax.clips.synthetic import synthetic_clips
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import MotionGraph


@pytest.fixture(scope="package")
def made_graph() -> MotionGraph:
    """A graph of the procedural clips, with enough transitions to avoid something.

    A fifth of those that the demo has: candidates are as many as in the graph of real capture.
    """
    clips, labels = synthetic_clips()
    return build_graph(clips, labels=labels, config=GraphConfig(threshold_m=0.05, best_per_s=30))


@pytest.fixture(scope="package", params=["made", "real"])
def any_graph(request: pytest.FixtureRequest) -> MotionGraph:
    """Both graphs in turn."""
    return request.getfixturevalue(f"{request.param}_graph")
