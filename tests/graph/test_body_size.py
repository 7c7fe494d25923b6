"""A graph of larger or smaller bodies is the same graph."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.plants import planted_frames
from mgjax.graph.types import NO_CLIP, MotionGraph
from tests.sized import EXACT, SIZES, clips_of_size, graph_of_size

SAME = (
    "clip_starts",
    "clip_stops",
    "node_frame",
    "node_clip",
    "edge_source",
    "edge_target",
    "edge_clip",
    "out_edges",
    "label_edge",
    "label_starts",
    "plants",
)
CONFIGS = [GraphConfig(), GraphConfig(threshold_m=0.05), GraphConfig(normalised=0.2)]


def transitions(graph: MotionGraph) -> set[tuple[int, int]]:
    """The frames that transitions lead from and to."""
    edges = graph.edge_clip == NO_CLIP
    pairs = (graph.node_frame[x[edges]] for x in (graph.edge_source, graph.edge_target))
    return set(zip(*(frames.tolist() for frames in pairs), strict=True))


@pytest.mark.parametrize("config", CONFIGS, ids=["automatic", "given", "normalised"])
@pytest.mark.parametrize("size", EXACT)
def test_the_same_graph(made, size, config):
    clips, labels = made
    want = build_graph(clips, labels=labels, config=config)
    got = build_graph(clips_of_size(clips, size), labels=labels, config=config)
    for name in SAME:
        np.testing.assert_array_equal(getattr(got, name), getattr(want, name), err_msg=name)
    np.testing.assert_array_equal(got.edge_distance, size * want.edge_distance)
    np.testing.assert_array_equal(got.root_translation, size * want.root_translation)
    # Feet that would be moved by less than 10 µm are left as they are, whatever the body.
    np.testing.assert_allclose(got.local_rotations, want.local_rotations, atol=1e-4)
    assert got.report["threshold_m"] == want.report["threshold_m"]


@pytest.mark.parametrize("size", SIZES)
def test_about_the_same_graph(made, size):
    clips, labels = made
    config = GraphConfig(threshold_m=0.05)
    want = transitions(build_graph(clips, labels=labels, config=config))
    got = transitions(build_graph(clips_of_size(clips, size), labels=labels, config=config))
    # Steps of these clips are alike, so that rounding says which of two frames is the minimum.
    assert len(got & want) > 0.9 * max(len(got), len(want)) > 10


@pytest.mark.parametrize("size", [*EXACT, *SIZES])
def test_the_same_plants(made_graph, size):
    got, want = planted_frames(graph_of_size(made_graph, size)), planted_frames(made_graph)
    assert want.any()
    assert (got != want).mean() <= (0 if size in EXACT else 1e-3)
