"""What is played of a walk."""

from __future__ import annotations

import dataclasses

import jax
import numpy as np
import pytest

from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion
from mgjax.graph.feet.contacts import foot_points, standing_points
from mgjax.graph.feet.course import MOST_LEAD_M, MOST_M, at_rest
from mgjax.graph.feet.legs import foot_chains
from mgjax.graph.feet.played import (
    LOT,
    at_times,
    keep_feet,
    legs_of,
    play,
    play_at,
    play_walk,
    with_feet,
)
from mgjax.graph.feet.posed import STRAIGHT
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.graph.walk import Walk, random_walk, sample_walk
from tests.graph.made import BODY, STANDING_M, bend

RATE = 120.0
CHAINS = foot_chains(BODY)


def long_walk(graph: MotionGraph, seed: int) -> tuple[Walk, np.ndarray]:
    """A walk with edges that are stretched and shrunk, and the moments of its first second."""
    walk = random_walk(graph, seed, 4.0, seed)
    scales = np.random.default_rng(seed).uniform(0.7, 1.4, len(walk.edges))
    return dataclasses.replace(walk, scales=scales), np.arange(120) / RATE


def bent(frames: int, *, slide: float) -> Motion:
    """A body on bent knees that slides ahead by so much in a third of a second, feet and all."""
    rotations = np.tile([1.0, 0, 0, 0], (frames, BODY.num_joints, 1))
    for side in ("l", "r"):
        bend(rotations, f"{side}femur", np.full(frames, -0.3))
        bend(rotations, f"{side}tibia", np.full(frames, 0.6))
        bend(rotations, f"{side}foot", np.full(frames, -0.3))
    root = np.zeros((frames, 3))
    root[:, 1] = STANDING_M - 0.9 * (1 - np.cos(0.3))
    root[:, 2] = slide * np.clip(np.arange(frames) / RATE * 3, 0, 1)
    return Motion(
        root_translation=root.astype(np.float32),
        local_rotations=rotations.astype(np.float32),
        frame_rate=RATE,
    )


def placed(motion: Motion) -> np.ndarray:
    return np.asarray(global_positions(BODY, motion), np.float64)


def test_a_body_that_slides_across_a_seam_stands() -> None:
    """By hand: both feet slide 5 cm with the body; they stay, and the root goes back with them."""
    plain = bent(64, slide=0.05)
    stands = np.ones((64, 2, 2), bool)
    kept, _ = keep_feet(BODY, CHAINS, plain, stands, scale=1.0)
    before, after = placed(plain), placed(kept)
    feet = [*CHAINS.balls, *CHAINS.ankles]
    assert np.linalg.norm((before[-1] - before[0])[feet], axis=-1).min() > 0.049
    assert np.linalg.norm(after[:, feet] - after[0, feet], axis=-1).max() < 0.003
    np.testing.assert_allclose(after[0], before[0], atol=1e-6)
    np.testing.assert_array_equal(kept.local_rotations[0], plain.local_rotations[0])
    # The root is led after the feet: legs hardly bend.
    assert abs(after[-1, 0, 2]) < 0.012


def test_nothing_to_do_nothing_changes() -> None:
    plain = bent(40, slide=0.0)
    for stands in (np.ones((40, 2, 2), bool), np.zeros((40, 2, 2), bool)):
        kept, state = keep_feet(BODY, CHAINS, plain, stands, scale=1.0)
        np.testing.assert_allclose(kept.root_translation, plain.root_translation, atol=1e-6)
        np.testing.assert_allclose(kept.local_rotations, plain.local_rotations, atol=1e-6)
        assert np.abs(state.offset).max() < 1e-6


def test_no_foot_stays_below_the_floor() -> None:
    """A body that stands 1.5 cm too low comes up by its legs, which begin as they are."""
    plain = bent(40, slide=0.0)
    low = min(placed(plain)[0, j, 1] for j in (*CHAINS.balls, *CHAINS.ankles))
    root = plain.root_translation - np.array([0, low + 0.015, 0], np.float32)
    plain = dataclasses.replace(plain, root_translation=root)
    kept, _ = keep_feet(BODY, CHAINS, plain, np.ones((40, 2, 2), bool), scale=1.0)
    heights = placed(kept)[:, [*CHAINS.balls, *CHAINS.ankles], 1].min(axis=1)
    assert heights[0] == pytest.approx(-0.015, abs=1e-5)
    assert heights[12:].min() > -1e-4
    assert (np.diff(heights[:8]) > 0).all()


def test_knees_never_get_straight() -> None:
    """Feet that are held back farther than legs reach: the pelvis comes down, knees stay bent."""
    plain = bent(64, slide=0.5)
    stands = np.ones((64, 2, 2), bool)
    kept, state = keep_feet(BODY, CHAINS, plain, stands, scale=1.0)
    positions = placed(kept)
    for hip, knee, ankle in zip(CHAINS.hips, CHAINS.knees, CHAINS.ankles, strict=True):
        bones = [
            np.linalg.norm(positions[:, a] - positions[:, b], axis=-1)
            for a, b in ((knee, hip), (ankle, knee))
        ]
        far = np.linalg.norm(positions[:, ankle] - positions[:, hip], axis=-1)
        assert (far / sum(bones)).max() < STRAIGHT + 1e-3
        # The knee points ahead, as it did.
        middle = 0.5 * (positions[:, hip] + positions[:, ankle])
        assert (positions[:, knee, 2] - middle[:, 2]).min() > 0
    # Half a metre cannot be held: what can is held, the rest slides.
    off = np.linalg.norm(state.offset[1:] - state.lead[:-1, None, None], axis=-1)
    assert off.max() <= MOST_M + 1e-5


@pytest.mark.parametrize("seed", range(2))
def test_a_walk_of_a_graph(made_graph: MotionGraph, seed: int) -> None:
    walk, times = long_walk(made_graph, seed)
    start = np.array([1.0, 30.0, -20.0])
    plain = sample_walk(made_graph, walk, times, start=start)
    kept, states = play(made_graph, walk, times, start=start)
    np.testing.assert_allclose(kept.root_translation[0], plain.root_translation[0], atol=1e-5)
    np.testing.assert_array_equal(kept.local_rotations[0], plain.local_rotations[0])
    before, after = (
        np.asarray(global_positions(made_graph.skeleton, m), float) for m in (plain, kept)
    )
    assert legs_of(made_graph) is not None
    points = foot_points(made_graph)
    size = made_graph.body_scale
    assert (
        np.linalg.norm(np.asarray(kept.root_translation) - plain.root_translation, axis=-1).max()
        < 1.2 * size * MOST_LEAD_M
    )
    low = [after[:, p, 1].min() for foot in points for p in foot]
    assert min(low) > min(-0.005, before[0, points, 1].min() - 1e-5)
    assert np.isfinite(after).all()
    assert np.abs(np.asarray(states.offset)).max() < size * (MOST_M + 1.2 * MOST_LEAD_M)


def test_padding_and_what_follows_change_nothing(made_graph: MotionGraph) -> None:
    walk, times = long_walk(made_graph, 0)
    whole = play_walk(made_graph, walk, times)
    assert len(times) > 2 * LOT + 1
    for count in (2, LOT - 1, LOT, LOT + 1, 2 * LOT + 1):
        part = play_walk(made_graph, walk, times[:count])
        np.testing.assert_allclose(part.root_translation, whole.root_translation[:count], atol=2e-6)
        np.testing.assert_allclose(part.local_rotations, whole.local_rotations[:count], atol=2e-5)


def test_handed_on_in_the_middle(made_graph: MotionGraph) -> None:
    walk, times = long_walk(made_graph, 1)
    whole, states = play(made_graph, walk, times)
    middle = 60
    begin = jax.tree.map(lambda x: x[middle], states)
    rest = play_walk(made_graph, walk, times[middle:], begin=begin)
    np.testing.assert_allclose(rest.root_translation[0], whole.root_translation[middle], atol=1e-5)
    np.testing.assert_allclose(rest.root_translation, whole.root_translation[middle:], atol=2e-3)


def test_poses_at_any_moment(made_graph: MotionGraph) -> None:
    walk, times = long_walk(made_graph, 0)
    whole, states = play(made_graph, walk, times)
    some = times[[3, 50, 51, 110]]
    got = play_at(made_graph, walk, some, rate=RATE)
    np.testing.assert_allclose(
        got.root_translation, whole.root_translation[[3, 50, 51, 110]], atol=1e-5
    )
    np.testing.assert_allclose(
        got.local_rotations, whole.local_rotations[[3, 50, 51, 110]], atol=2e-5
    )
    plain = sample_walk(made_graph, walk, some)
    same = with_feet(made_graph, plain, at_times(states, times, some))
    np.testing.assert_allclose(same.root_translation, got.root_translation, atol=1e-6)
    half = at_times(states, times, np.array([-1.0, 0.5 / RATE, 99.0]))
    np.testing.assert_allclose(
        half.lead,
        np.stack([states.lead[0], 0.5 * (states.lead[0] + states.lead[1]), states.lead[-1]]),
        atol=1e-7,
    )


def test_a_graph_that_is_not_cleaned_is_played_as_captured(made_graph: MotionGraph) -> None:
    raw = dataclasses.replace(made_graph, report={**made_graph.report, "clean_feet": False})
    assert legs_of(raw) is None
    walk, times = long_walk(made_graph, 0)
    plain = sample_walk(raw, walk, times)
    kept, states = play(raw, walk, times)
    np.testing.assert_array_equal(kept.local_rotations, plain.local_rotations)
    np.testing.assert_array_equal(states.lead, np.zeros((120, 2)))
    assert with_feet(raw, plain, states) is plain
    assert play_walk(raw, walk, times, rate=30.0).frame_rate == 30.0
    np.testing.assert_array_equal(at_rest().anchor, 1)


def test_transitions_inherit_what_stands(made_graph: MotionGraph) -> None:
    graph, stands = made_graph, standing_points(made_graph)
    assert stands.shape == (len(graph.root_translation), 2, 2)
    share = stands[: int(graph.clip_stops[-1])].mean(axis=0)
    assert 0.01 < share.mean() < 0.9
    half = graph.window // 2
    for edge in np.flatnonzero(graph.edge_clip == NO_CLIP)[:20]:
        frames = stands[graph.edge_starts[edge] : graph.edge_stops[edge] + 1]
        leave = int(graph.node_frame[graph.edge_source[edge]])
        arrive = int(graph.node_frame[graph.edge_target[edge]]) - graph.window
        np.testing.assert_array_equal(frames[:half], stands[leave : leave + half])
        np.testing.assert_array_equal(
            frames[half:], stands[arrive + half : arrive + graph.window + 1]
        )
