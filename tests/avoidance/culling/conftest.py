"""Slices that are drawn once for all tests of culling."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.avoidance.body.edge_tables import EdgeTables, edge_tables
from mgjax.avoidance.candidates.enumerate import enumerate_candidates
from mgjax.avoidance.culling.overlap import overlap_pixels
from mgjax.avoidance.culling.pictures import Form, Slices, build_slices
from mgjax.graph.types import MotionGraph
from tests.avoidance.culling.made import FORMS, RATE, crop_of, drawn_of, random_scales
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
    slices = build_slices(tables)
    rng = np.random.default_rng(2)
    cases: list = []
    for _ in range(300):  # what is drawn depends on the graph, and that on the version of jax
        attack = throw(rng)
        crop = crop_of(attack)
        node = int(rng.integers(made_graph.num_nodes))
        found = enumerate_candidates(made_graph, tables, node, crop.middle, window=1.0, capacity=40)
        if len(found.length) < 10:
            continue
        case = (found, random_scales(found, len(cases)), attack, crop)
        if all(_some_overlap(slices, case, form) for form in FORMS):
            cases.append(case)
        if len(cases) == 3:
            return slices, cases
    pytest.fail("got no three attacks that touch some candidates, expected them within 300 draws")


def _some_overlap(slices: Slices, case: tuple, form: Form) -> bool:
    """Whether some candidates overlap the attack well, and others less."""
    walks, scales, attack, crop = case
    counts = overlap_pixels(slices, walks, scales, drawn_of(attack, crop), crop, form=form)
    return bool(counts.max() > 20 and counts.max() > counts.min())
