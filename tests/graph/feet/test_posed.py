from __future__ import annotations

import math
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.core import quaternion
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton
from mgjax.graph.feet.course import FeetState, at_rest
from mgjax.graph.feet.legs import foot_chains
from mgjax.graph.feet.posed import SWIVEL, posed


def standing(body: Skeleton, lean: float) -> tuple[np.ndarray, np.ndarray]:
    """Two poses: the root 0.95 m high, knees bent by 0.6 rad, the left thigh ``lean`` aside."""
    rotations = np.zeros((2, body.num_joints, 4), np.float32)
    rotations[..., 0] = 1.0
    for side in "lr":
        bend = np.array([1.0, 0.0, 0.0], np.float32)
        for joint, angle in ((f"{side}femur", -0.3), (f"{side}tibia", 0.6), (f"{side}foot", -0.3)):
            rotations[:, body.index(joint)] = quaternion.from_axis_angle(bend, np.float32(angle))
    hip = body.index("lfemur")
    aside = quaternion.from_axis_angle(np.array([0.0, 0.0, 1.0], np.float32), np.float32(lean))
    rotations[:, hip] = quaternion.multiply(aside, rotations[:, hip])
    return np.tile(np.array([0.0, 0.95, 0.0], np.float32), (2, 1)), rotations


def turned(yaw: float, along: np.ndarray) -> FeetState:
    """The left foot held at its ankle, its ball led aside as a turn by ``yaw`` takes it."""
    plain = at_rest()
    c, s = math.cos(yaw), math.sin(yaw)
    led = [c * along[0] + s * along[1], c * along[1] - s * along[0]]
    offset = np.zeros((2, 2, 2, 2), np.float32)
    offset[:, 0, 0] = led - along
    both = jax.tree.map(lambda x: jnp.asarray(np.stack([x, x])), plain)
    return replace(both, offset=jnp.asarray(offset), anchor=jnp.zeros((2, 2)))


@pytest.mark.parametrize("lean", [0.0, 0.25])
@pytest.mark.parametrize("yaw", [0.2, -0.3])
def test_the_leg_goes_along_with_its_foot(body: Skeleton, lean: float, yaw: float) -> None:
    chains = foot_chains(body)
    root, rotations = standing(body, lean)
    positions, turns = (np.asarray(x) for x in forward(body, root, rotations))
    ankle, ball, knee = chains.ankles[0], chains.balls[0], chains.knees[0]
    along = (positions[0, ball] - positions[0, ankle])[::2]
    state = turned(yaw, along)
    new_root, new = posed(
        body,
        chains,
        jnp.asarray(root),
        jnp.asarray(rotations),
        jnp.asarray(positions),
        jnp.asarray(turns),
        state,
        scale=1.0,
    )
    after, after_turns = (
        np.asarray(x) for x in forward(body, np.asarray(new_root), np.asarray(new))
    )
    np.testing.assert_allclose(after[:, ankle], positions[:, ankle], atol=2e-5)
    # The foot turns about the vertical alone, by a little less than is asked for.
    foot = quaternion.multiply(
        after_turns[0, ankle], np.asarray(quaternion.conjugate(turns[0, ankle]))
    )
    angle = 2 * math.atan2(float(foot[2]), float(foot[0]))
    assert 0.6 * abs(yaw) < abs(angle) <= abs(yaw)
    assert math.copysign(1.0, angle) == math.copysign(1.0, yaw)
    assert np.abs(foot[[1, 3]]).max() < 1e-5
    # By hand: the knee goes round the line from hip to ankle by a share of that turn.
    hip = positions[0, chains.hips[0]]
    up = (hip - positions[0, ankle]) / np.linalg.norm(hip - positions[0, ankle])
    c, s = math.cos(SWIVEL * angle), math.sin(SWIVEL * angle)
    arm = positions[0, knee] - hip
    wanted = hip + c * arm + s * np.cross(up, arm) + (1 - c) * (up @ arm) * up
    np.testing.assert_allclose(after[0, knee], wanted, atol=5e-5)
    # The other leg, and what nothing is off of, stay as they are.
    for joint in (chains.hips[1], chains.knees[1], chains.ankles[1]):
        np.testing.assert_array_equal(np.asarray(new)[:, joint], rotations[:, joint])
