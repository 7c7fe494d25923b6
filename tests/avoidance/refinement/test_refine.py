"""Near misses that are made clear, by the exact check."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.attacks.transform import in_frame
from mgjax.avoidance.body.spheres import preset_spheres, sphere_centres
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.results import Choice, Status
from mgjax.avoidance.choice.selection import Selection, refine, select, write
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.many.attacks import select_batch
from mgjax.avoidance.play.planner import Planner
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.avoidance.refinement.inside import DEPTH_M, depths, too_deep
from mgjax.avoidance.refinement.played import refiner_of
from mgjax.avoidance.refinement.refine import ENOUGH_M, refine_walks
from mgjax.cli.avoid import selection_json
from mgjax.core import planar
from mgjax.core.body.roles import require_roles
from mgjax.core.errors import ConfigError
from mgjax.core.kinematics import forward
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, make_walk
from tests.avoidance.refinement.made import CONFIG, asked

PAIRS = "apart", "pairs"


def head_of(graph: MotionGraph) -> tuple[np.ndarray, float]:
    """Centre and radius of the head as it stands, m."""
    spheres = preset_spheres(graph.skeleton)
    root, rotations = graph.root_translation[:1], graph.local_rotations[:1]
    centres = np.asarray(
        sphere_centres(spheres, np.asarray(forward(graph.skeleton, root, rotations)[0]))
    )
    number = next(k for k, name in enumerate(spheres.names) if "head_end" in name)
    return centres[0, number].astype(np.float64), float(spheres.radii[number])


def ball_into_head(graph: MotionGraph, depth: float, side: float = 1.0) -> Attack:
    """A ball from ahead that would meet the head so deep at its upper left or right, m."""
    centre, radius = head_of(graph)
    aside = np.array([side * 0.8, 0.6, 0.0]) * (radius + 0.12 - depth)
    target = centre + aside
    return ball_attack(target + np.array([0, 0, 5.0]), target, speed=10.0, arrives=1.2)


def standing(graph: MotionGraph) -> Walk:
    return make_walk(graph, [0])


def test_a_head_leans_away_from_a_ball_by_little_more_than_it_must(still: MotionGraph) -> None:
    prepared, config = asked(still)
    attacks = [ball_into_head(still, 0.03), ball_into_head(still, 0.03, side=-1.0)]
    for attack in attacks:
        (found,) = refine_walks(prepared, [standing(still)], attack, config)
        assert found is not None
        assert found.clearance_before_m == pytest.approx(-0.03, abs=2e-3)
        assert found.clearance_m >= ENOUGH_M * still.body_scale
        # By the depth and the margin at least; other joints of the head move a little farther.
        assert 0.03 < found.largest_m < 0.06
        assert found.largest_deg < 8.0
        np.testing.assert_allclose(found.values[[0, -1]], 0.0, atol=1e-9)
        np.testing.assert_allclose(np.diff(found.values, axis=0)[[0, -1]], 0.0, atol=1e-5)
        assert np.abs(found.values[:, -6:]).max() == 0.0  # it stands on both feet


def test_what_is_written_is_clear_and_stands_where_it_stood(still: MotionGraph) -> None:
    attack = ball_into_head(still, 0.04)
    before = answer(still, attack)
    assert before.status == Status.HIT
    after = refine(still, before, attack, config=CONFIG)
    assert after.status == Status.AVOIDED
    assert after.refinement is not None
    assert after.clearance_m is not None
    assert after.clearance_m >= ENOUGH_M * still.body_scale
    frames = np.arange(after.motion.num_frames) / EXPORT_RATE
    skeleton = still.skeleton
    old, new = (
        np.asarray(
            forward(skeleton, m.root_translation[: len(frames)], m.local_rotations[: len(frames)])[
                0
            ]
        )
        for m in (before.motion, after.motion)
    )
    count = min(len(old), len(new))
    feet = list(require_roles(skeleton, ("left_ankle", "right_ankle")))
    np.testing.assert_allclose(new[:count, feet], old[:count, feet], atol=1e-4)
    moved = np.linalg.norm(new[:count] - old[:count], axis=-1).max(axis=0)
    change = after.refinement
    for name, most in zip(change.joints, change.moved_m, strict=True):
        assert moved[skeleton.index(name)] == pytest.approx(most, abs=1e-4)
    assert change.largest_m <= CONFIG.refine_max_m
    outside = (frames[:count] < change.start) | (frames[:count] > change.stop)
    np.testing.assert_allclose(new[:count][outside], old[:count][outside], atol=1e-6)
    again = refine(still, after, attack, config=CONFIG)
    assert again is after  # what avoids is left alone


def answer(graph: MotionGraph, attack: Attack) -> Selection:
    """What is written of a body that goes on standing."""
    prepared, _ = asked(graph)
    made = Choice(
        status=Status.HIT, node=0, walk=standing(graph), path_length=1, part=0, time_scale=1.0
    )
    return write(prepared, attack, made, replace(CONFIG, warp="linear"))


def test_several_at_once_are_as_one_by_one(still: MotionGraph) -> None:
    prepared, config = asked(still)
    attack = ball_into_head(still, 0.03)
    longer = make_walk(still, [0, 0])
    together = refine_walks(prepared, [standing(still), longer, standing(still)], attack, config)
    (alone,) = refine_walks(prepared, [standing(still)], attack, config)
    assert alone is not None
    for one in together:
        assert one is not None
        np.testing.assert_allclose(one.values, alone.values, atol=2e-4)


def test_nothing_is_changed_of_what_is_clear_as_it_is_written(still: MotionGraph) -> None:
    prepared, config = asked(still)
    attack = ball_into_head(still, -0.05)
    (found,) = refine_walks(prepared, [standing(still)], attack, config)
    assert found is not None
    assert found.largest_m == found.largest_deg == 0.0
    assert not found.values.any()
    assert found.clearance_m == found.clearance_before_m == pytest.approx(0.05, abs=2e-3)


def test_only_limbs_deeper_than_before_and_than_in_the_capture_are_too_deep(
    still: MotionGraph,
) -> None:
    rig = refiner_of(still).rig
    rng = np.random.default_rng(2)
    frames = still.positions[10:20]
    said = []
    for size in np.linspace(0.0, 0.2, 12).tolist():
        moved = frames + rng.normal(scale=size, size=frames.shape[1:]).astype(np.float32)
        plain = replace(rig, **{k: jax.tree.map(np.asarray, getattr(rig, k)) for k in PAIRS})
        deep = [max(float(np.max(depths(plain, x))), 0.0) for x in (frames, moved)]
        expected = deep[1] > max(deep[0], DEPTH_M * still.body_scale)
        assert too_deep(rig, frames, moved, still.body_scale) == expected
        said.append(expected)
    assert any(said)
    assert not all(said)


def test_caps_are_kept(still: MotionGraph) -> None:
    prepared, config = asked(still)
    attack = ball_into_head(still, 0.05)
    (found,) = refine_walks(prepared, [standing(still)], attack, config)
    assert found is not None
    for cap in ({"refine_max_m": 0.03}, {"refine_max_deg": 0.5}):
        (none,) = refine_walks(prepared, [standing(still)], attack, replace(config, **cap))
        assert none is None


def test_what_cannot_be_survived_is_a_hit_and_stays_as_it_was(still: MotionGraph) -> None:
    centre = still.root_translation[0].astype(np.float64)
    attack = ball_attack(
        centre + np.array([0, 0, 20.0]), centre, speed=50.0, arrives=1.5, radius=1.0
    )
    chosen = select(still, 0, attack, config=replace(CONFIG, T_wide=0.0))
    assert chosen.status == Status.HIT
    assert chosen.refinement is None
    for array in (chosen.motion.root_translation, chosen.motion.local_rotations):
        assert np.isfinite(array).all()


def test_what_nobody_waits_for_is_not_refined(still: MotionGraph) -> None:
    attack, narrow = ball_into_head(still, 0.03), replace(CONFIG, T_wide=0.0)
    assert choose(still, 0, attack, config=narrow, wanted=lambda: True).refinement is not None
    dropped = choose(still, 0, attack, config=narrow, wanted=lambda: False)
    assert dropped.refinement is None
    assert dropped.status == Status.HIT


def test_near_misses_are_refined_unless_it_is_off(still: MotionGraph) -> None:
    attack = ball_into_head(still, 0.03)
    narrow = replace(CONFIG, T_wide=0.0)
    near = select(still, 0, attack, config=narrow)
    off = select(still, 0, attack, config=replace(narrow, refine="off"))
    assert off.status == Status.HIT
    assert off.refinement is None
    assert near.status == Status.AVOIDED
    assert near.refinement is not None
    # The written motion, by the sphere centres that go into volumes.npz.
    radii = preset_spheres(still.skeleton).radii
    there = (near.trace.times >= attack.start) & (near.trace.times <= attack.end)
    gaps = np.linalg.norm(attack.at(near.trace.times[there]) - near.trace.centres[there], axis=-1)
    assert (gaps - radii - attack.radii).min() > 0
    many = select_batch(still, [0, 0], [attack, attack], config=narrow)
    assert many.status.tolist() == [Status.AVOIDED.code] * 2
    np.testing.assert_allclose(many.clearance, near.refinement.clearance_m, atol=1e-3)
    told = selection_json(still, near)["refinement"]
    assert told["largest_m"] == near.refinement.largest_m
    assert set(told["joints"]) == set(near.refinement.joints)
    assert selection_json(still, off)["refinement"] is None


def test_the_planner_plays_what_was_refined(still: MotionGraph) -> None:
    attack = ball_into_head(still, 0.03)
    place = np.array([0.7, 1.0, -2.0])
    planner = Planner(still, config=replace(CONFIG, T_wide=0.0), node=0, start=place)
    end = planner.timeline.end  # the search is for the end of the edge that is being played
    world = in_frame(attack, np.asarray(planar.inverse(planner.timeline.frame_at_end())), -end)
    planner.attack(world)
    (found,) = planner.finish()
    assert found.status == "avoided"
    assert found.clearance_m >= ENOUGH_M * still.body_scale
    assert planner.timeline.changes


@pytest.mark.parametrize(
    ("name", "value"), [("refine_max_m", -0.1), ("refine_max_deg", float("nan"))]
)
def test_settings_out_of_range(still: MotionGraph, name: str, value: float) -> None:
    config = replace(AvoidanceConfig(), **{name: value})
    with pytest.raises(ConfigError, match=name):
        select(still, 0, ball_into_head(still, 0.03), config=config)
