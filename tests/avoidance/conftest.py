"""Graphs that are built once for all tests of the avoidance room."""

from __future__ import annotations

import pytest

from mgjax.clips.synthetic import synthetic_clips
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import MotionGraph


@pytest.fixture(scope="session")
def made_graph() -> MotionGraph:
    """The graph of the procedural clips, with enough transitions to avoid something."""
    clips, labels = synthetic_clips()
    return build_graph(clips, labels=labels, config=GraphConfig(threshold_m=0.05))


@pytest.fixture(scope="session", params=["made", "real"])
def any_graph(request: pytest.FixtureRequest) -> MotionGraph:
    """Both graphs in turn."""
    return request.getfixturevalue(f"{request.param}_graph")
