"""Slices that are drawn once for all tests of culling."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.avoidance.body.edge_tables import EdgeTables, edge_tables
from mgjax.avoidance.candidates.enumerate import enumerate_candidates
from mgjax.avoidance.culling.pictures import (
    Slices,
    build_slices,
)
from mgjax.graph.types import MotionGraph
from tests.avoidance.culling.made import (
    RATE,
    crop_of,
    random_scales,
)
from tests.avoidance.made import random_graph, throw


@pytest.fixture(scope="package")
def small() -> tuple[MotionGraph, EdgeTables, Slices]:
    graph = random_graph(3)
    tables = edge_tables(graph, RATE)
    return graph, tables, build_slices(tables)


@pytest.fixture(scope="package")
def thrown(made_graph: MotionGraph) -> tuple[Slices, list]:
    """Slices of the graph of clips, and candidates with scales for some balls."""
    tables = edge_tables(made_graph, RATE)
    rng = np.random.default_rng(2)
    cases: list = []
    while len(cases) < 3:
        attack = throw(rng)
        crop = crop_of(attack)
        node = int(rng.integers(made_graph.num_nodes))
        found = enumerate_candidates(made_graph, tables, node, crop.middle, window=1.0, capacity=40)
        if len(found.length) >= 10:
            cases.append((found, random_scales(found, len(cases)), attack, crop))
    return build_slices(tables), cases
