"""Poses whose feet are where the course has them: the root led, the legs by two-bone IK."""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion, two_bone
from mgjax.core.arrays import Array
from mgjax.core.skeleton import Skeleton
from mgjax.graph.feet.course import FeetState
from mgjax.graph.feet.legs import FootChains

SOFT, STRAIGHT = 0.96, 0.99
"""Shares of its full length to which a leg is led: beyond the first with resistance, and never to
the second. A leg that is straighter in the motion may stay so."""
MOST_TURN = math.radians(25.0)
"""A foot is turned on the floor by less than this, rad."""
SWIVEL = 0.4
"""Share of a foot's turn by which its leg goes along, about the line from hip to ankle. Turned
alone a foot twists its ankle beyond what ankles do; the leg wholly with it puts knee to knee."""
FLAT_M = 0.04
"""An adult's foot whose ball and ankle are nearer than this over the floor is hardly turned, m."""


def leg_lengths(positions: Float[Array, "T J 3"], chains: FootChains) -> Float[Array, "T 2"]:
    """Thigh and shin together, of the left and the right leg, m."""
    hips, knees, ankles = (
        positions[:, np.array(joints)] for joints in (chains.hips, chains.knees, chains.ankles)
    )
    return _length(knees - hips) + _length(ankles - knees)


def reach_of(
    hips: Float[Array, "*t 2 3"], ankles: Float[Array, "*t 2 3"], lengths: Float[Array, "*t 2"]
) -> Float[Array, "*t 2"]:
    """How far from its hip an ankle may be: nearly straight, or as it is in the motion."""
    return jnp.maximum(0.5 * (SOFT + STRAIGHT) * lengths, _length(ankles - hips))


def posed(
    skeleton: Skeleton,
    chains: FootChains,
    root: Float[Array, "T 3"],
    rotations: Float[jax.Array, "T J 4"],
    positions: Float[Array, "T J 3"],
    turns: Float[Array, "T J 4"],
    state: FeetState,
    *,
    scale: Array | float,
) -> tuple[Array, Array]:
    """Root and rotations of poses whose feet are where the state has them.

    The root goes along with the lead and down with the drop. Each foot is turned on the floor and
    put down so that its ball and its ankle meet their places, the one by which it is held exactly;
    the knee bends in its plane. A pose that nothing is off of stays as it is, to rounding.

    Args:
        skeleton, chains: the body and its legs.
        root, rotations: the poses.
        positions, turns: of all joints, in the world.
        state: with an axis [T].
        scale: of the body.
    """
    lead = jnp.stack([state.lead[:, 0], -state.drop, state.lead[:, 1]], axis=-1)
    lengths = leg_lengths(positions, chains)
    legs = zip(chains.hips, chains.knees, chains.ankles, chains.balls, strict=True)
    for side, (hip, knee, ankle, ball) in enumerate(legs):
        target, yaw = _foot(positions[:, ball], positions[:, ankle], state, side, scale)
        start = positions[:, hip] + lead
        target = _within_reach(
            start, target, _length(positions[:, ankle] - positions[:, hip]), lengths[:, side]
        )
        pole = quaternion.rotate(turns[:, hip], jnp.array([[0.0, 0.0, 1.0]], dtype=positions.dtype))
        hip_turn, knee_turn = two_bone.solve(
            start, positions[:, knee] + lead, positions[:, ankle] + lead, target, pole
        )
        hip_turn = quaternion.multiply(_swivel(start, target, SWIVEL * yaw), hip_turn)
        above = [turns[:, skeleton.parents[j]] for j in (hip, knee, ankle)]
        new = two_bone.local_rotations(
            hip_turn,
            knee_turn,
            (above[0], above[1], above[2]),
            (
                turns[:, hip],
                turns[:, knee],
                quaternion.multiply(quaternion.from_yaw(yaw), turns[:, ankle]),
            ),
        )
        moved = _length(target - positions[:, ankle] - lead) + jnp.abs(yaw) > 1e-5
        for joint, local in zip((hip, knee, ankle), new, strict=True):
            kept = jnp.where(moved[:, None], local, rotations[:, joint])
            rotations = rotations.at[:, joint].set(kept)
    return root + lead, rotations


def _foot(
    ball: Array, ankle: Array, state: FeetState, side: int, scale: Array | float
) -> tuple[Array, Array]:
    """Where the ankle of a foot goes, and the turn of the foot on the floor, rad."""
    to_ball = state.offset[:, side, 0]
    to_ankle = state.offset[:, side, 1]
    along = (ball - ankle)[:, ::2]
    wanted = along + to_ball - to_ankle
    # From z to x, as headings count.
    cross = wanted[:, 0] * along[:, 1] - wanted[:, 1] * along[:, 0]
    square = jnp.sum(along * wanted, axis=-1)
    least = (FLAT_M * jnp.asarray(scale, ball.dtype)) ** 2
    yaw = jnp.arctan2(cross, square + least * 1e-3)
    flat = jnp.sum(along * along, axis=-1)
    yaw = yaw * flat / (flat + least * 0.25)
    yaw = MOST_TURN * jnp.tanh(yaw / MOST_TURN)
    cosine, sine = jnp.cos(yaw), jnp.sin(yaw)
    turned = jnp.stack(
        [along[:, 0] * cosine + along[:, 1] * sine, along[:, 1] * cosine - along[:, 0] * sine],
        axis=-1,
    )
    by_ball = ball[:, ::2] + to_ball - turned
    by_ankle = ankle[:, ::2] + to_ankle
    held = state.anchor[:, side][:, None]
    place = held * by_ball + (1 - held) * by_ankle
    height = ankle[:, 1] + state.lift[:, side]
    return jnp.stack([place[:, 0], height, place[:, 1]], axis=-1), yaw


def _swivel(hip: Array, ankle: Array, angle: Array) -> Array:
    """The turn about the line from hip to ankle that goes with one about the vertical, rad."""
    up = (hip - ankle) / jnp.maximum(_length(hip - ankle), 1e-6)[:, None]
    return quaternion.from_axis_angle(up, angle)


def _within_reach(hip: Array, target: Array, now: Array, length: Array) -> Array:
    """The target, as far from the hip as a leg that is not straight gets."""
    gap = target - hip
    far = _length(gap)
    soft, most = SOFT * length, STRAIGHT * length
    room = most - soft
    beyond = jnp.maximum(far - soft, 0.0)
    led = jnp.where(far > soft, soft + room * (1 - jnp.exp(-beyond / room)), far)
    kept = jnp.maximum(led, jnp.minimum(far, now))
    return hip + gap * (kept / jnp.maximum(far, 1e-6))[:, None]


def _length(vector: Array) -> Array:
    return jnp.sqrt(jnp.maximum(jnp.sum(vector * vector, axis=-1), 1e-12))
