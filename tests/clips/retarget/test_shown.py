from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.clips.retarget.body import make_body
from mgjax.clips.retarget.shown import look_at, mean_turn
from mgjax.clips.synthetic import synthetic_clips
from mgjax.core import quaternion
from mgjax.core.body.roles import find_roles
from mgjax.core.motion import cut

MADE = {clip.name: clip for clip in synthetic_clips()[0]}
WALK = MADE["walk"]
ROLES = find_roles(WALK.skeleton)


def test_what_a_walk_shows():
    shown = look_at(WALK.skeleton, ROLES, [WALK.motion])
    # The procedural knees bend about X and elbows about Y; balls of the feet stand 2 cm up.
    for side in ("left", "right"):
        for role in ("hip", "knee"):
            np.testing.assert_allclose(shown.hinges[f"{side}_{role}"], [1, 0, 0], atol=1e-3)
    np.testing.assert_allclose(shown.hinges["left_elbow"], [0, -1, 0], atol=1e-3)
    np.testing.assert_allclose(shown.hinges["right_elbow"], [0, 1, 0], atol=1e-3)
    assert shown.heights["toe"] == pytest.approx(0.02, abs=1e-3)
    assert shown.heights["ankle"] == pytest.approx(0.075, abs=3e-3)
    still = np.array([1.0, 0.0, 0.0, 0.0])
    for side in ("left", "right"):
        for part in ("ankle", "toe"):
            flat = shown.flat[f"{side}_{part}"]
            assert np.degrees(quaternion.angle_between(flat, still)) < 4.0


def test_too_little_shows_nothing():
    shown = look_at(WALK.skeleton, ROLES, [cut(WALK.motion, 0, 5)])
    assert shown.hinges == {}
    assert shown.flat == {}
    assert look_at(WALK.skeleton, ROLES, []).heights == {}


def test_a_limb_that_bends_to_all_sides_has_no_hinge():
    rng = np.random.default_rng(0)
    local = np.array(WALK.motion.local_rotations)
    angle = rng.uniform(0, 2 * np.pi, len(local))
    axis = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=-1)
    local[:, WALK.skeleton.index("ltibia")] = quaternion.from_axis_angle(axis, 0 * angle + 1.0)
    shown = look_at(WALK.skeleton, ROLES, [replace(WALK.motion, local_rotations=local)])
    assert "left_hip" not in shown.hinges
    assert "right_hip" in shown.hinges


def test_the_mean_of_turns_does_not_mind_signs():
    axis = np.array([[0.0, 0.6, 0.8]])
    turns = np.asarray(quaternion.from_axis_angle(axis, np.array([0.1, 0.2, 0.3])))
    mean = mean_turn(turns * np.array([[1], [-1], [1]]))
    want = quaternion.from_axis_angle(axis[0], np.array(0.2))
    assert quaternion.angle_between(mean, want) < 1e-6


def test_axes_of_a_body_without_motion():
    body = make_body(WALK.skeleton)
    for side in ("left", "right"):
        np.testing.assert_allclose(body.hinge(f"{side}_hip"), [1, 0, 0], atol=1e-6)
    assert body.thigh_and_shin == pytest.approx(0.85)
    assert body.leg_length("ankle") == pytest.approx(0.85)
    assert body.leg_length("toe") == pytest.approx(0.905)
    assert body.heights == {}
