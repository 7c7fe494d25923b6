"""Curves, changed poses and their derivatives, against plain NumPy."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.refinement.played import refiner_of
from mgjax.avoidance.refinement.pose import ankles_of, changed
from mgjax.avoidance.refinement.refinement import channels_at, free_feet
from mgjax.avoidance.refinement.rig import Rig, joint_groups, make_rig, outside
from mgjax.avoidance.refinement.slopes import base_of, changed_with_slopes
from mgjax.avoidance.refinement.splines import SPLINES, basis, size_matrix
from mgjax.core.body.roles import find_role
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton
from mgjax.graph.types import MotionGraph
from tests.reference import refinement as reference


def test_splines_are_those_of_cox_and_de_boor_and_vanish_at_both_ends() -> None:
    times = np.linspace(0.4, 1.4, 200)
    values = basis(times, 0.5, 1.3)
    for row, at in zip(values, (times - 0.5) / 0.8 * (SPLINES + 3), strict=True):
        expected = [reference.spline(k, 3, at) for k in range(SPLINES)]
        np.testing.assert_allclose(row, expected, atol=1e-12)
    near = basis(np.array([0.5, 0.5 + 1e-4, 1.3 - 1e-4, 1.3]), 0.5, 1.3)
    assert np.abs(near).max() < 1e-9  # value and first two derivatives are 0 at the ends
    assert np.linalg.eigvalsh(size_matrix()).min() > 1e-4


@pytest.fixture(scope="module")
def rig(still: MotionGraph) -> Rig:
    return refiner_of(still).rig


changed_jit = jax.jit(changed_with_slopes)
"""All tests have three poses, so that it is compiled once."""


def poses(graph: MotionGraph) -> tuple[np.ndarray, np.ndarray]:
    rows = np.array([10, 60, 95])
    return graph.root_translation[rows], graph.local_rotations[rows]


def drawn(rig: Rig, size: float) -> np.ndarray:
    channels = np.random.default_rng(1).normal(scale=size, size=(3, rig.channels))
    channels[:, 1] = -0.03  # down, so that the feet stay in reach
    channels[:, -3 * len(rig.legs) :] *= 0.3
    return channels.astype(np.float32)


def test_places_of_changed_poses(still: MotionGraph, rig: Rig) -> None:
    root, rotations = poses(still)
    channels = drawn(rig, 0.06)
    base = base_of(rig, root, rotations, np.ones((3, len(rig.legs))))
    found = np.asarray(changed_jit(rig, base, channels).places)
    ankles, feet = ankles_of(rig, jnp.asarray(root), jnp.asarray(rotations))
    values = (jnp.asarray(x) for x in (root, rotations, channels))
    written = changed(rig, next(values), next(values), next(values), ankles, feet)
    places, _ = forward(rig.skeleton, *written)
    groups = list(joint_groups(still.skeleton).values())
    parents, offsets = still.skeleton.parents, np.asarray(still.skeleton.offsets)
    for row in range(2):  # those that stand
        vectors = {
            joint: channels[row, 3 + 3 * g : 6 + 3 * g].astype(np.float64) / len(joints)
            for g, joints in enumerate(groups)
            for joint in joints
        }
        upper = reference.upper_places(
            parents, offsets, root[row], rotations[row], vectors, channels[row, :3]
        )
        legs = {j for hip, _, _ in rig.legs for j in range(len(parents)) if _below(parents, hip, j)}
        others = [j for j in range(len(parents)) if j not in legs]
        np.testing.assert_allclose(found[row, others], upper[others], atol=2e-5)
        np.testing.assert_allclose(np.asarray(places)[row, others], upper[others], atol=2e-5)
        for leg, (hip, knee, ankle) in enumerate(rig.legs):
            shift = channels[row, -3 * len(rig.legs) + 3 * leg :][:3]
            target = np.asarray(base.places)[row, ankle] + shift
            expected = reference.knee_place(upper[hip], upper[knee], upper[ankle], target)
            for got in (found, np.asarray(places)):
                np.testing.assert_allclose(got[row, ankle], target, atol=2e-5)
                np.testing.assert_allclose(got[row, knee], expected, atol=1e-4)


def _below(parents: tuple[int, ...], top: int, joint: int) -> bool:
    while joint > top:
        joint = parents[joint]
    return joint == top


def test_slopes_are_finite_differences(still: MotionGraph, rig: Rig) -> None:
    root, rotations = poses(still)
    base = base_of(rig, root, rotations, np.full((3, len(rig.legs)), 0.5))
    values = partial(changed_jit, rig, base)
    channels, step = drawn(rig, 0.06), 2e-3
    now = values(channels)
    for channel in range(rig.channels):
        aside = np.zeros_like(channels)
        aside[:, channel] = step
        more, less = values(channels + aside), values(channels - aside)
        for name, tolerance in (("places", 3e-3), ("bounds", 2e-2)):
            slope = (np.asarray(getattr(more, name)) - np.asarray(getattr(less, name))) / (2 * step)
            exact = np.asarray(getattr(now, f"to_{name}"))[..., channel]
            kink = np.abs(slope - exact) > tolerance
            # Bounds have kinks; what is beside one is no derivative.
            assert kink.mean() < (1e-9 if name == "places" else 0.02), channel


def test_slopes_are_finite_where_nothing_is_changed_yet(still: MotionGraph, rig: Rig) -> None:
    root, rotations = poses(still)
    straight = rotations.copy()
    straight[:] = (1, 0, 0, 0)  # straight legs have no plane
    base = base_of(rig, root, straight, np.ones((3, len(rig.legs))))
    now = changed_jit(rig, base, np.zeros((3, rig.channels), np.float32))
    assert all(np.isfinite(x).all() for x in jax.tree.leaves(now))


def test_limits_hold_what_the_clips_show(still: MotionGraph, rig: Rig) -> None:
    stop = int(still.clip_stops[-1])
    shown = still.local_rotations[:stop, list(rig.limited)]
    assert np.asarray(outside(shown, jax.tree.map(np.asarray, rig.limits))).max() < 1e-3
    turned = np.broadcast_to(np.array([0, 0, 1, 0], np.float32), shown[:1].shape)
    assert np.asarray(outside(turned, jax.tree.map(np.asarray, rig.limits))).min() > 0.3


def test_feet_are_free_only_away_from_where_they_stand() -> None:
    times = np.arange(120) / 120
    stands = np.zeros((120, 2), bool)
    stands[40:60, 0] = True
    free = free_feet(stands, times)
    np.testing.assert_array_equal(free[:, 1], 1.0)
    np.testing.assert_array_equal(free[39:61, 0], 0.0)
    assert free[20, 0] == free[85, 0] == 1.0
    assert (np.diff(free[61:, 0]) >= 0).all()


def test_channels_between_frames() -> None:
    values = np.array([[0.0], [1.0], [0.0]])
    found = channels_at(values, 0.5, np.array([0.4, 0.5, 0.5 + 0.5 / 120, 0.5 + 1 / 120, 0.6]))
    np.testing.assert_allclose(found[:, 0], [0, 0, 0.5, 1, 0], atol=1e-9)


def test_a_body_without_an_arm_and_toes_keeps_its_other_channels(still: MotionGraph) -> None:
    skeleton = still.skeleton
    lost = {
        j
        for j, name in enumerate(skeleton.names)
        if _of_left_arm(skeleton, j) or "toe" in name.lower()
    }
    kept = [j for j in range(skeleton.num_joints) if j not in lost]
    place = {old: new for new, old in enumerate(kept)}
    smaller = Skeleton(
        names=tuple(skeleton.names[j] for j in kept),
        parents=tuple(place.get(skeleton.parents[j], -1) for j in kept),
        offsets=np.asarray(skeleton.offsets)[kept],
        end_joints=tuple(place[j] for j in skeleton.end_joints if j in place),
    )
    graph = replace(still, skeleton=smaller, local_rotations=still.local_rotations[:, kept])
    groups = joint_groups(smaller)
    assert "left_elbow" not in groups
    assert {"pelvis", "spine", "right_shoulder", "right_elbow"} <= set(groups)
    rig = make_rig(graph, preset_spheres(skeleton))
    assert rig.channels == 3 + 3 * len(groups) + 6


def _of_left_arm(skeleton: Skeleton, joint: int) -> bool:
    shoulder = find_role(skeleton, "left_shoulder")
    assert shoulder is not None
    return _below(skeleton.parents, shoulder, joint)
