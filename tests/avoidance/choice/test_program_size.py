"""The program of a search is as large as it was."""

from __future__ import annotations

import numpy as np

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.graph.types import MotionGraph
from tests.programs import check, operations_within


def test_operations_of_a_search(made_graph: MotionGraph) -> None:
    config = AvoidanceConfig(refine="off")

    def call() -> None:
        for node in range(made_graph.num_nodes):  # until candidates of one are in time
            choose(made_graph, node, ball_from(np.pi / 3, 1.2), config=config)

    check("search", operations_within("mgjax.avoidance.choice.search.search_one", call))
