"""Pieces that are measured are what is played, and verdicts follow from figures."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.avoidance.graphs import built
from experiments.quality.pieces import random_pieces, room, seam_edges, seam_pieces, uncut_pieces
from experiments.quality.verdicts import auc, goals_of, line_of, row_of
from mgjax.core.kinematics import global_positions
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import unroll
from mgjax.quality.result import FIGURES


@pytest.fixture(scope="module")
def graph() -> MotionGraph:
    return built()


def test_seams_are_as_they_are_played(graph: MotionGraph) -> None:
    """Steps of joints through a seam are those of a walk over that edge."""
    around = room(graph)
    edges = seam_edges(graph, around)[::97][:5]
    pieces = seam_pieces(graph, edges, around)
    assert len(pieces) == len(edges) == 5
    for edge, motion, span in zip(edges, pieces.motions, pieces.spans_s or (), strict=True):
        after = graph.edges_from(int(graph.edge_target[edge]))
        after = next(e for e in after if graph.edge_clip[e] >= 0)
        count = graph.window + min(int(graph.edge_frames[after]), around)
        walk = np.asarray(global_positions(graph.skeleton, unroll(graph, np.array([edge, after]))))[
            :count
        ]
        got = np.asarray(global_positions(graph.skeleton, motion))[around : around + count]
        apart = [np.linalg.norm(np.diff(x, axis=0), axis=-1) for x in (walk, got)]
        np.testing.assert_allclose(*apart, atol=1e-4)
        assert motion.num_frames == 2 * around + graph.window + 1
        assert span == pytest.approx(((around - 1) / 30, (around + graph.window) / 30))


def test_uncut_pieces(graph: MotionGraph) -> None:
    around = room(graph)
    edges = seam_edges(graph, around)[:3]
    uncut = uncut_pieces(graph, edges, around)
    assert len(uncut) == 6
    leave = graph.node_frame[graph.edge_source[edges]]
    wanted = graph.local_rotations[leave[0] - around : leave[0] + graph.window + around + 1]
    np.testing.assert_array_equal(uncut.motions[0].local_rotations, wanted)
    pieces = random_pieces(graph, [1.7, 0.5, 1e9], 0)
    longest = int((graph.clip_stops - graph.clip_starts).max())
    assert [piece.num_frames for piece in pieces] == [52, 16, longest]


def test_blind() -> None:
    low, high = np.array([0.0, 1, 2, np.nan]), np.array([3.0, 4])
    assert auc(low, high) == auc(high, low) == 1.0
    assert auc(low, low) == 0.5
    assert auc(np.array([np.nan]), high) == 0.5
    assert auc(np.array([0.0, 2.0]), np.array([1.0, 3.0])) == pytest.approx(0.75)
    assert auc(np.array([0.0, 1e-6]), np.array([2e-6, 3e-6]), 0.01) == 0.5


def test_goals() -> None:
    values = {key: np.full(20, 0.004) for key in FIGURES if key != "speed_distance"}
    speeds = np.ones((3, 64))
    row = row_of("good", (values, speeds), (values, speeds))
    assert all(row["goals"].values())
    assert len(line_of(row)) > 10
    for key, goal in (
        ("skate_ratio", "G1 skate ratio"),
        ("contact_speed", "G1 contact speed"),
        ("skate_cm", "G1 skate"),
        ("jerky", "G2"),
        ("sink", "G3 sink"),
        ("self_penetration", "G3 depth"),
        ("limits", "G5 limits"),
        ("velocity_jump", "G4"),
    ):
        bad = values | {key: np.full(20, 9.0)}
        missed = {
            name
            for name, ok in row_of("bad", (bad, speeds), (values, speeds))["goals"].items()
            if not ok
        }
        assert goal in missed
        assert missed <= {goal, "G4"}
    fast = np.zeros((3, 64))
    fast[:, -1] = 1
    assert not row_of("fast", (values, fast), (values, speeds))["goals"]["G5 speeds"]
    assert goals_of(row) == row["goals"]
