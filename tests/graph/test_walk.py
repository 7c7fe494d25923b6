from __future__ import annotations

import numpy as np
import pytest

from mgjax.core import planar
from mgjax.core.errors import MotionError
from mgjax.core.kinematics import forward, global_positions, planar_frames
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.graph.walk import Walk, make_walk, place_edges, sample_walk, unroll
from tests.reference import kinematics


@pytest.fixture(params=["made_graph", "real_graph"])
def graph(request) -> MotionGraph:
    return request.getfixturevalue(request.param)


def random_walk(graph: MotionGraph, length: int, seed: int) -> list[int]:
    """Any edges that follow one another, transitions as often as pieces of clips."""
    rng = np.random.default_rng(seed)
    node, walk = int(rng.integers(graph.num_nodes)), []
    for _ in range(length):
        edges = graph.edges_from(node)
        jumps = edges[graph.edge_clip[edges] == NO_CLIP]
        if len(jumps) and rng.uniform() < 0.6:
            edges = jumps
        walk.append(int(rng.choice(edges)))
        node = int(graph.edge_target[walk[-1]])
    return walk


def largest_steps(positions: np.ndarray) -> tuple[float, float]:
    """Longest way of a joint in one frame, and largest change of that from frame to frame, m."""
    step = np.diff(positions, axis=0)
    return (
        float(np.linalg.norm(step, axis=-1).max()),
        float(np.linalg.norm(np.diff(step, axis=0), axis=-1).max()),
    )


@pytest.fixture
def allowed(graph) -> float:
    """How much faster than inside the clips. The made feet glide and are stopped by clean-up."""
    return 1.5 if "a" in graph.clip_names else 1.02


def test_no_jump_at_any_seam(graph, allowed):
    p, _ = forward(graph.skeleton, graph.root_translation, graph.local_rotations)
    inside = np.array(
        [largest_steps(p[a:b]) for a, b in zip(graph.clip_starts, graph.clip_stops, strict=True)]
    ).max(axis=0)
    seams = 0
    for seed in range(12):
        walk = random_walk(graph, 40, seed)
        seams += int((graph.edge_clip[walk] == NO_CLIP).sum())
        motion = unroll(graph, walk)
        step, change = largest_steps(np.asarray(global_positions(graph.skeleton, motion)))
        assert step <= allowed * inside[0]
        assert change <= allowed * inside[1]
    assert seams > 100


def test_every_single_seam(graph, allowed):
    """From the frame before each transition to the one after it, in the clip's coordinates."""
    p, _ = forward(graph.skeleton, graph.root_translation, graph.local_rotations)
    inside = np.array(
        [largest_steps(p[a:b]) for a, b in zip(graph.clip_starts, graph.clip_stops, strict=True)]
    ).max(axis=0)
    edges = np.flatnonzero(graph.edge_clip == NO_CLIP)
    before = graph.node_frame[graph.edge_source[edges]][:, None] + np.array([-2, -1])
    during = graph.edge_starts[edges][:, None] + np.arange(graph.window)
    node = graph.node_frame[graph.edge_target[edges]]
    there = node + np.arange(2)[:, None]
    exits = graph.edge_exit[edges][:, None]
    after = np.stack([planar.apply(exits, p[f]) for f in there], axis=1)
    # Two frames before a window or after it may belong to another clip: leave those out.
    source = graph.node_clip[graph.edge_source[edges]]
    target = graph.node_clip[graph.edge_target[edges]]
    ok = (before[:, 0] >= graph.clip_starts[source]) & (there[1] < graph.clip_stops[target])
    frames = np.concatenate([p[before], p[during], after], axis=1)[ok]
    step = np.diff(frames, axis=1)
    assert ok.sum() > 0.9 * len(edges)
    assert np.linalg.norm(step, axis=-1).max() <= allowed * inside[0]
    assert np.linalg.norm(np.diff(step, axis=1), axis=-1).max() <= allowed * inside[1]


def test_a_piece_of_a_clip_plays_its_frames(graph):
    edge = int(np.flatnonzero((graph.edge_clip != NO_CLIP) & (graph.edge_frames > 3))[0])
    motion = unroll(graph, [edge])
    frames = slice(graph.edge_starts[edge], graph.edge_stops[edge] + 1)
    assert motion.num_frames == graph.edge_frames[edge] + 1
    np.testing.assert_allclose(
        motion.local_rotations[:, 1:], graph.local_rotations[frames, 1:], atol=1e-6
    )
    # The root is where the clip has it, seen from the body's frame at the start.
    plane = graph.node_plane[graph.edge_source[edge]].astype(np.float64)
    for got, root in zip(motion.root_translation, graph.root_translation[frames], strict=True):
        np.testing.assert_allclose(kinematics.planar_apply(plane, got), root, atol=1e-4)


def test_a_walk_starts_where_it_is_told(graph):
    # The first frame of a transition is already a little on its way.
    walk = [int(np.flatnonzero(graph.edge_clip != NO_CLIP)[3])]
    origin = unroll(graph, walk)
    start = np.array([2.0, 5.0, -7.0])
    placed = unroll(graph, walk, start=start)
    for motion, want in ((origin, np.zeros(3)), (placed, start)):
        first = planar_frames(graph.skeleton, np.asarray(global_positions(graph.skeleton, motion)))[
            0
        ]
        np.testing.assert_allclose(first, want, atol=2e-5)
    moved = planar.apply(start, np.asarray(global_positions(graph.skeleton, origin), np.float64))
    np.testing.assert_allclose(global_positions(graph.skeleton, placed), moved, atol=1e-4)


def test_places_follow_the_exits(graph):
    walk = random_walk(graph, 20, 5)
    places = place_edges(graph, np.array(walk))
    for i in range(len(walk) - 1):
        for point in np.eye(3):
            via = kinematics.planar_apply(graph.edge_exit[walk[i]], point)
            np.testing.assert_allclose(
                kinematics.planar_apply(places[i + 1], point),
                kinematics.planar_apply(places[i], via),
                atol=1e-6,
            )


def test_natural_times_are_those_of_unroll(graph):
    walk = random_walk(graph, 15, 1)
    plain = unroll(graph, walk)
    assert plain.frame_rate == graph.frame_rate
    assert plain.num_frames == graph.edge_frames[walk].sum() + 1
    timed = make_walk(graph, walk, np.ones(15))
    times = np.arange(plain.num_frames) / graph.frame_rate
    got = sample_walk(graph, timed, times)
    np.testing.assert_array_equal(got.root_translation, plain.root_translation)
    np.testing.assert_array_equal(got.local_rotations, plain.local_rotations)


def test_sampling_between_frames(graph):
    walk = make_walk(graph, random_walk(graph, 8, 2))
    whole = unroll(graph, walk.edges)
    times = (np.arange(whole.num_frames - 1) + 0.25) / graph.frame_rate
    got = sample_walk(graph, walk, times)
    want = 0.75 * whole.root_translation[:-1] + 0.25 * whole.root_translation[1:]
    np.testing.assert_allclose(got.root_translation, want, atol=1e-4)
    assert got.frame_rate == pytest.approx(graph.frame_rate)
    for frame in range(0, len(times), 7):
        for joint in (0, 1, 4):
            turn = kinematics.slerp(*whole.local_rotations[frame : frame + 2, joint], 0.25)
            np.testing.assert_allclose(
                kinematics.matrix(got.local_rotations[frame, joint]), turn, atol=2e-4
            )


def test_scaled_edges_last_longer(graph):
    edges = random_walk(graph, 5, 4)
    scales = np.array([1.0, 2.0, 0.5, 1.5, 1.0])
    walk = make_walk(graph, edges, scales)
    natural = graph.edge_frames[edges] / graph.frame_rate
    begins = walk.starts(graph)
    np.testing.assert_allclose(np.diff(begins), natural * scales)
    assert begins[0] == 0
    # The same poses, at other times: at its beginning, its middle and its end.
    plain = make_walk(graph, edges)
    before = plain.starts(graph)
    for share in (0.0, 0.3, 0.5, 1.0):
        one = sample_walk(graph, walk, begins[:-1] + share * np.diff(begins))
        two = sample_walk(graph, plain, before[:-1] + share * np.diff(before))
        np.testing.assert_allclose(one.root_translation, two.root_translation, atol=1e-4)
        cosine = np.sum(one.local_rotations * two.local_rotations, axis=-1)
        np.testing.assert_allclose(np.abs(cosine), 1.0, atol=1e-5)


def test_nothing_jumps_between_frames_either(graph):
    """Sampled 16 times as finely, no step is longer than a sixteenth of one between frames."""
    walk = make_walk(graph, random_walk(graph, 30, 7))
    coarse = unroll(graph, walk.edges)
    fine = sample_walk(graph, walk, np.arange(16 * (coarse.num_frames - 1) + 1) / (16 * 30.0))
    np.testing.assert_allclose(fine.root_translation[::16], coarse.root_translation, atol=1e-6)
    np.testing.assert_allclose(fine.local_rotations[::16], coarse.local_rotations, atol=1e-6)
    steps = np.linalg.norm(np.diff(coarse.root_translation, axis=0), axis=1)
    small = np.linalg.norm(np.diff(fine.root_translation, axis=0), axis=1).reshape(-1, 16)
    np.testing.assert_allclose(small, np.repeat(steps[:, None] / 16, 16, axis=1), atol=2e-6)


def test_times_outside_hold_the_ends(graph):
    walk = make_walk(graph, random_walk(graph, 3, 6))
    whole = unroll(graph, walk.edges)
    got = sample_walk(graph, walk, np.array([-1.0, 0.0, 100.0]))
    np.testing.assert_allclose(got.root_translation, whole.root_translation[[0, 0, -1]], atol=1e-5)
    one = sample_walk(graph, walk, np.array([0.0]))
    assert one.num_frames == 1
    assert one.frame_rate == graph.frame_rate


def test_broken_walks(graph):
    after = int(graph.edge_target[0])
    wrong = next(e for e in range(graph.num_edges) if graph.edge_source[e] != after)
    with pytest.raises(MotionError, match=f"got edge {wrong} after 0, expected one from its end"):
        make_walk(graph, [0, wrong])
    with pytest.raises(MotionError, match="without edges"):
        unroll(graph, [])
    for edge in (-1, graph.num_edges):
        with pytest.raises(MotionError, match=f"got edge {edge}, expected one of 0 … "):
            unroll(graph, [edge])
    follower = int(graph.edges_from(after)[0])
    for scales in ([1.0], [1.0, 0.0], [1.0, -1.0], [np.nan, 1.0], [np.inf, 1.0], [1.0] * 3):
        with pytest.raises(MotionError, match="expected 2 numbers above 0"):
            make_walk(graph, [0, follower], scales)


def test_a_walk_is_what_it_was_made_of(graph):
    walk = make_walk(graph, random_walk(graph, 4, 0), [1.0, 2.0, 3.0, 4.0])
    assert isinstance(walk, Walk)
    np.testing.assert_array_equal(walk.scales, [1, 2, 3, 4])
