"""The embedded clips are enough: whoever is thrown at in them finds a way out nearly always."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.many.attacks import select_batch
from mgjax.avoidance.prepared import prepared_for
from mgjax.clips.synthetic import synthetic_clips
from mgjax.graph.build import build_graph
from mgjax.graph.config import EMBEDDED

BALLS = 100


@pytest.mark.long
def test_nine_of_ten_balls_are_avoided_wherever_they_come_from() -> None:
    """From any side, from the knees to the head, at any node, there in 1.2 and in 0.8 s."""
    clips, labels = synthetic_clips()
    graph = build_graph(clips, labels=labels, config=EMBEDDED)
    rng = np.random.default_rng(11)
    nodes = rng.integers(graph.num_nodes, size=BALLS)
    sides, heights = rng.uniform(0, 2 * np.pi, BALLS), rng.uniform(0.5, 1.7, BALLS)
    config = AvoidanceConfig()
    prepared = prepared_for(graph, config)
    share: list[float] = []
    for arrives in (1.2, 0.8):
        balls = [
            ball_from(float(side), float(height), distance=5.0, speed=10.0, arrives=arrives)
            for side, height in zip(sides, heights, strict=True)
        ]
        answers = select_batch(prepared, nodes, balls, config=config)
        avoided = answers.status == Status.AVOIDED.code
        share.append(float(avoided.mean()))
        kinds = {graph.label_kind[part] for part in answers.part[avoided]}
        assert len(kinds) >= 6, kinds  # no single trick
    assert share[0] >= 0.9
    assert share[1] >= 0.75
