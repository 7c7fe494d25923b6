"""What several tests of the stage look at: one graph, and one thing of each kind made from it."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.choice.selection import Selection, select
from mgjax.clips.synthetic import synthetic_clips
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import MotionGraph


@pytest.fixture(scope="session")
def graph() -> MotionGraph:
    """The graph of the procedural clips, with enough transitions to avoid something."""
    clips, labels = synthetic_clips()
    return build_graph(clips, labels=labels, config=GraphConfig(threshold_m=0.05, best_per_s=30))


@pytest.fixture(scope="session")
def thrown(graph: MotionGraph) -> tuple[Attack, Selection]:
    """A ball at the chest that is avoided, from the first node at which it is."""
    ball = ball_attack(np.array([0.0, 1.4, 5.0]), np.array([0.0, 1.4, 0.0]), speed=9.0, arrives=1.0)
    for node in range(0, graph.num_nodes, 7):
        selection = select(graph, node, ball)
        if selection.status == "avoided":
            return ball, selection
    raise AssertionError("no node avoids the ball")
