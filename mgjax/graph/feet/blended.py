"""A planted foot stays where it is while two motions are blended.

The plants of the clips are inherited, the first clip's in the first half of a blend and the
second's in the second half. While a foot is planted its ball is held over one place on the floor;
where it is not, the correction fades from one place to the next. The frames around the blend are
not touched, so a foot that is planted throughout has to get from its place in the one clip to its
place in the other, and does so in one smooth move.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float

from mgjax.core import quaternion, two_bone
from mgjax.core.arrays import Array
from mgjax.core.contacts import floor_steps, stays_planted
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton
from mgjax.core.timing.easing import smoothstep
from mgjax.graph.feet.legs import FootChains

SHORT_GAP = 1 / 6
"""Share of the frames of a transition in which a foot cannot get from one plant to the next."""


def slide_per_frame(ball: Float[Array, "W 3"], planted: Bool[Array, " W"]) -> Float[Array, ""]:
    """Metres that a foot travels over the floor while planted, per step between frames."""
    moved = floor_steps(ball, softening=1e-20)
    return jnp.sum(jnp.where(stays_planted(planted), moved, 0.0)) / (ball.shape[0] - 1)


def close_gaps(planted: Bool[Array, " W"], longest: int) -> Bool[Array, " W"]:
    """Fills gaps of up to ``longest`` frames between plants and to both ends."""
    count = planted.shape[0]
    index = jnp.arange(count)
    before = jax.lax.cummax(jnp.where(planted, index, -1))
    after = jax.lax.cummin(jnp.where(planted, index, count), reverse=True)
    short = (after - before - 1 <= longest) & ~((before < 0) & (after >= count))
    return planted | short


def held_places(ball: Float[Array, "W 3"], planted: Bool[Array, " W"]) -> Float[Array, "W 3"]:
    """Where the ball of a foot should be: still while planted, smoothly moved in between.

    The first and the last frame are fixed. Each run of planted frames is held at one place: that
    of the first frame if the run begins there, that of the last if it ends there, the mean of the
    run otherwise; a run from first to last moves from the one to the other. Heights stay. Gaps
    too short for a foot to move in (:data:`SHORT_GAP` of the frames), also those to the first and
    the last frame, count as planted: else a foot would jump through them.
    """
    count = ball.shape[0]
    planted = close_gaps(planted, int(SHORT_GAP * count))
    index = jnp.arange(count)
    starts = jnp.concatenate([planted[:1], planted[1:] & ~planted[:-1]])
    run = jnp.where(planted, jnp.cumsum(starts), 0)
    same = (run[:, None] == run[None, :]) & planted[:, None] & planted[None, :]
    members = jnp.maximum(jnp.sum(same, axis=1), 1).astype(ball.dtype)
    mean = (same.astype(ball.dtype) @ ball) / members[:, None]
    with_first, with_last = same[:, 0], same[:, -1]
    u = index.astype(ball.dtype) / (count - 1)
    ease = smoothstep(u)[:, None]
    through = ball[:1] * (1 - ease) + ball[-1:] * ease
    place = jnp.where(with_last[:, None], ball[-1:], mean)
    place = jnp.where(with_first[:, None], ball[:1], place)
    place = jnp.where((with_first & with_last)[:, None], through, place)
    shift = jnp.where(planted[:, None], place - ball, 0.0)
    # Between plants, and to the fixed first and last frame, the shift is eased.
    known = planted | (index == 0) | (index == count - 1)
    before = jax.lax.cummax(jnp.where(known, index, 0))
    after = jax.lax.cummin(jnp.where(known, index, count - 1), reverse=True)
    t = (index - before).astype(ball.dtype) / jnp.maximum(after - before, 1).astype(ball.dtype)
    t = smoothstep(t)[:, None]
    shift = shift[before] * (1 - t) + shift[after] * t
    return ball + shift * jnp.array([1.0, 0.0, 1.0], dtype=ball.dtype)[None]


def keep_plants(
    skeleton: Skeleton,
    chains: FootChains,
    root: Float[jax.Array, "W1 3"],
    rotations: Float[jax.Array, "W1 J 4"],
    planted: Bool[Array, "W2 2"],
    before: Float[Array, "J 3"],
) -> tuple[Float[jax.Array, "W1 J 4"], Float[jax.Array, "2"]]:
    """Cleans the feet of one transition by two-bone IK.

    Args:
        skeleton: of the motion.
        chains: its legs.
        root, rotations: the blended frames and the frame of arrival.
        planted: for the left and right foot, from the frame before the blend to that of arrival.
        before: joint positions in the frame before the blend.

    Returns:
        New rotations, and metres that planted feet travel per frame, (before, after) clean-up.
    """
    positions, turns = forward(skeleton, root, rotations)
    slides = []
    for side in range(2):
        hip, knee, ankle = chains.hips[side], chains.knees[side], chains.ankles[side]
        ball = chains.balls[side]
        path = jnp.concatenate([before[ball][None], positions[:, ball]])
        held = held_places(path, planted[:, side])
        # The foot keeps its blended orientation, so the ankle moves as the ball does.
        shift = (held - path)[1:]
        pole = quaternion.rotate(turns[:, hip], jnp.array([0.0, 0.0, 1.0])[None])
        hip_turn, knee_turn = two_bone.solve(
            positions[:, hip],
            positions[:, knee],
            positions[:, ankle],
            positions[:, ankle] + shift,
            pole,
        )
        moved = jnp.sum(shift * shift, axis=1) > 1e-10
        rotations = _turn_leg(
            skeleton, rotations, turns, (hip, knee, ankle), hip_turn, knee_turn, moved
        )
        slides.append((path, planted[:, side], ball))
    cleaned, _ = forward(skeleton, root, rotations)
    blended = sum(slide_per_frame(path, on) for path, on, _ in slides)
    after = sum(
        slide_per_frame(jnp.concatenate([before[ball][None], cleaned[:, ball]]), on)
        for _, on, ball in slides
    )
    return rotations, jnp.stack([jnp.asarray(blended), jnp.asarray(after)])


def _turn_leg(
    skeleton: Skeleton,
    rotations: jax.Array,
    turns: Array,
    leg: tuple[int, int, int],
    hip_turn: Array,
    knee_turn: Array,
    moved: Array,
) -> jax.Array:
    """Local rotations of a leg after turning thigh and shin in the world, the foot's kept."""
    hip, knee, ankle = leg
    above = [turns[:, skeleton.parents[j]] for j in leg]
    new = two_bone.local_rotations(
        hip_turn,
        knee_turn,
        (above[0], above[1], above[2]),
        (turns[:, hip], turns[:, knee], turns[:, ankle]),
    )
    for joint, local in zip(leg, new, strict=True):
        rotations = rotations.at[:, joint].set(
            jnp.where(moved[:, None], local, rotations[:, joint])
        )
    return rotations
