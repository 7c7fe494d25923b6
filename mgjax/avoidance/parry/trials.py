"""Ways of meeting an attack, tried all at once: with either arm, at several moments and places.

A trial is an arm, a moment, a place on the forearm or hand, and how the elbow lies. The arm is led
to meet the attack there by :mod:`mgjax.avoidance.parry.meet` and by the course of
:mod:`mgjax.avoidance.parry.course`; what stands against it is measured 60 times a second. It is
coarse: :mod:`mgjax.avoidance.parry.checked` decides on the written motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.parry.course import share_at
from mgjax.avoidance.parry.meet import ArmPose, meet, turned
from mgjax.avoidance.refinement.rig import outside
from mgjax.core import quaternion
from mgjax.core.arrays import Array
from mgjax.core.body.capsules import segment_distance
from mgjax.core.body.joint_limits import JointLimits
from mgjax.core.xla.exported import exported
from mgjax.core.xla.pytree import register

COARSE_RATE = 60.0
"""Moments per second at which trials are measured."""
SWIVELS_DEG = (-90.0, -60.0, -30.0, 0.0, 30.0, 60.0, 90.0)
"""How the arm is turned about the line from the shoulder to where it meets the attack."""
PLACES = (0.3, 0.55, 0.8, 1.4)
"""Where the attack is met: shares of the forearm; above 1, of the hand."""
SQUARE = 0.5
"""Least cosine between the way of an attack and the direction in which it presses on the arm:
what only grazes an arm is not turned away by it."""
ALONG = 0.7
"""Largest cosine between the bone that meets an attack and its way: a limb that points at a ball
does not lead it aside."""
APART_M = 0.003
"""How far the rest of the body still is from an attack when it is met: at a wrist forearm and hand
would be met at once."""
HAND_RAD = 0.5
"""What it counts against a hand: a forearm is the firmer guard."""
MISS_M = 0.01
"""Where an arm cannot reach it is this far off, at least."""
LIMIT_RAD = 0.01
"""By how much a joint may be farther outside of its captured range than it was."""
DEEPER_M = 0.01
"""By how much forearm and hand may be deeper in trunk and head than they were, of an adult."""


@register()
@dataclass(frozen=True, kw_only=True)
class Body:
    """A motion in which arms are turned, at T moments 60 times a second.

    Attributes:
        times: s from now. [T]
        arms: A arms. [A, T, …]
        local: local rotations of shoulder and elbow. [A, T, 2, 4]
        limits: of these joints, 2 for each arm. [2A]
        begins, axes: of the capsules that arms are kept out of. [T, B, 3]
        reach: radii of these, m. [B]
        radii: of upper arm, forearm and hand, m. [3]
        fastest: speed that a hand may have, m/s.
        deeper: what forearm and hand may be deeper in the body than they were, m.
    """

    times: Float[Array, " T"]
    arms: ArmPose
    local: Float[Array, "A T 2 4"]
    limits: JointLimits
    begins: Float[Array, "T B 3"]
    axes: Float[Array, "T B 3"]
    reach: Float[Array, " B"]
    radii: Float[Array, "3"]
    fastest: Float[Array, ""]
    deeper: Float[Array, ""]


@register()
@dataclass(frozen=True, kw_only=True)
class Trials:
    """N ways of meeting a sphere of an attack.

    Attributes:
        arm: number of the arm. [N]
        contact: when it is met, s. [N]
        pose: the arm then, before it is turned. [N]
        centre: of the sphere then, m. [N, 3]
        way: unit vector along which it comes. [N, 3]
        place: see ``PLACES``. [N]
        swivel: rad. [N]
        radius: of the sphere, m.
    """

    arm: Int[Array, " N"]
    contact: Float[Array, " N"]
    pose: ArmPose
    centre: Float[Array, "N 3"]
    way: Float[Array, "N 3"]
    place: Float[Array, " N"]
    swivel: Float[Array, " N"]
    radius: Float[Array, ""]


@register()
@dataclass(frozen=True, kw_only=True)
class Tried:
    """What came of trials.

    Attributes:
        turns: of shoulder and elbow, rotation vectors, rad. [N, 2, 3]
        effort: how far both turn, rad, and ``HAND_RAD`` for a hand. [N]
        good: whether nothing stands against it. [N]
    """

    turns: Float[Array, "N 2 3"]
    effort: Float[Array, " N"]
    good: Bool[Array, " N"]


def try_all(body: Body, trials: Trials) -> Tried:
    """All trials on one body; see :class:`Tried`."""
    hand = trials.place > 1
    limb = jnp.where(hand, body.radii[2], body.radii[1])
    target = trials.centre + trials.way * (trials.radius + limb)[..., None]
    turns, miss = meet(trials.pose, place_on(trials.pose, trials.place), target, trials.swivel)
    good = miss <= MISS_M
    good &= _meets(body, trials, turned(trials.pose, turns), hand)
    good &= jax.vmap(lambda *lane: _keeps(body, *lane))(trials.arm, trials.contact, turns)
    angles = jnp.sum(turns * turns, axis=-1)
    effort = jnp.sqrt(jnp.sum(angles, axis=-1)) + jnp.where(hand, HAND_RAD, 0.0)
    return Tried(turns=turns, effort=effort, good=good)


try_jitted = jax.jit(exported()(try_all))


def place_on(pose: ArmPose, place: Float[Array, "*b"]) -> Float[Array, "*b 3"]:
    """A place of ``PLACES`` on an arm, m."""
    beyond = (place > 1)[..., None]
    along = pose.elbow + place[..., None] * (pose.wrist - pose.elbow)
    return jnp.where(beyond, pose.wrist + (place - 1)[..., None] * (pose.tip - pose.wrist), along)


def _meets(body: Body, trials: Trials, pose: ArmPose, hand: Bool[Array, " N"]) -> Bool[Array, " N"]:
    """Whether a sphere presses squarely on what is to meet it, which lies across its way, and
    reaches nothing else of the arm."""
    bones = ((pose.shoulder, pose.elbow), (pose.elbow, pose.wrist), (pose.wrist, pose.tip))
    gaps: list[Array] = []
    presses: list[Array] = []
    lies: list[Array] = []
    for row, (a, b) in enumerate(bones):
        axis = b - a
        along = jnp.maximum(jnp.sum(axis * axis, axis=-1), 1e-9)
        share = jnp.clip(jnp.sum((trials.centre - a) * axis, axis=-1) / along, 0.0, 1.0)
        away = a + share[..., None] * axis - trials.centre
        far = jnp.sqrt(jnp.maximum(jnp.sum(away * away, axis=-1), 1e-12))
        gaps.append(far - trials.radius - body.radii[row])
        presses.append(jnp.sum(away * trials.way, axis=-1) / far)
        lies.append(jnp.abs(jnp.sum(axis * trials.way, axis=-1)) / jnp.sqrt(along))
    other = jnp.minimum(gaps[0], jnp.where(hand, gaps[1], gaps[2]))
    square = jnp.where(hand, presses[2], presses[1])
    own = jnp.where(hand, gaps[2], gaps[1])
    across = jnp.where(hand, lies[2], lies[1]) <= ALONG
    return across & (square >= SQUARE) & (other > APART_M + jnp.minimum(own, 0.0))


def _keeps(
    body: Body, arm: Int[Array, ""], contact: Float[Array, ""], turns: Float[Array, "2 3"]
) -> Bool[Array, ""]:
    """Whether an arm on its course keeps its limits, its speed, and out of the body."""
    share = share_at(body.times, contact)
    vectors = share[:, None, None] * turns[None]
    own = jax.tree.map(lambda x: x[arm], body.arms)
    new = turned(own, vectors)
    local = body.local[arm]
    row = 2 * arm + jnp.arange(2, dtype=arm.dtype)
    limits = jax.tree.map(lambda x: x[row], body.limits)
    after = outside(quaternion.multiply(local, quaternion.exp(vectors)), limits)
    within = jnp.max(after - outside(local, limits)) <= LIMIT_RAD
    speed = jnp.linalg.norm(jnp.diff(new.tip, axis=0), axis=-1) * COARSE_RATE
    before = jnp.linalg.norm(jnp.diff(own.tip, axis=0), axis=-1) * COARSE_RATE
    slow = jnp.max(speed - jnp.maximum(before, body.fastest)) <= 0
    depth = jnp.minimum(_to_body(body, own), 0.0) - body.deeper
    return within & slow & jnp.all(_to_body(body, new) >= depth)


def _to_body(body: Body, arm: ArmPose) -> Float[Array, " T"]:
    """Distance of forearm and hand to the capsules that they are kept out of, m."""
    gaps = [
        segment_distance(
            jnp.broadcast_to(a[:, None], body.begins.shape),
            jnp.broadcast_to(b[:, None], body.begins.shape),
            body.begins,
            body.axes,
        )
        - body.reach[None]
        - radius
        for a, b, radius in (
            (arm.elbow, arm.wrist, body.radii[1]),
            (arm.wrist, arm.tip + 1e-4, body.radii[2]),
        )
    ]
    return jnp.minimum(jnp.min(gaps[0], axis=1), jnp.min(gaps[1], axis=1))
