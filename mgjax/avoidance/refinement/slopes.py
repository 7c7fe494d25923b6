"""How the body of a changed pose moves with its channels: places and their derivatives."""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from mgjax.avoidance.refinement.leg import Bones, Followed, follow
from mgjax.avoidance.refinement.rig import Rig, outside
from mgjax.core import quaternion
from mgjax.core.arrays import Array
from mgjax.core.kinematics import forward
from mgjax.core.xla.pytree import register


@register()
@dataclass(frozen=True, kw_only=True)
class Base:
    """Unchanged poses, and what of them changed ones are compared with.

    Attributes:
        root, rotations: the poses, m and local. [T, 3], [T, J, 4]
        places, world: of their joints, m and wxyz. [T, J, 3], [T, J, 4]
        free: how far each foot may be moved, 0 … 1. [T, L]
        outside: by how much joints are outside the captured range, rad. [T, n]
    """

    root: Float[Array, "T 3"]
    rotations: Float[Array, "T J 4"]
    places: Float[Array, "T J 3"]
    world: Float[Array, "T J 4"]
    free: Float[Array, "T L"]
    outside: Float[Array, "T n"]


@register()
@dataclass(frozen=True, kw_only=True)
class Changed:
    """Changed poses with derivatives with respect to the channels of their own moment.

    Attributes:
        places: of the joints, m. [T, J, 3]
        to_places: their derivatives. [T, J, 3, C]
        bounds: turns of the joints of the legs, rad, then what ``limited`` joints are outside of
            the captured range more than before, rad, then what feet miss, m. [T, R]
        to_bounds: their derivatives. [T, R, C]
    """

    places: Float[Array, "T J 3"]
    to_places: Float[Array, "T J 3 C"]
    bounds: Float[Array, "T R"]
    to_bounds: Float[Array, "T R C"]


def base_of(
    rig: Rig,
    root: Float[np.ndarray, "T 3"],
    rotations: Float[np.ndarray, "T J 4"],
    free: Float[np.ndarray, "T L"],
) -> Base:
    """What of unchanged poses is needed at every step, without compilation."""
    skeleton = replace(rig.skeleton, offsets=np.asarray(rig.skeleton.offsets))
    places, world = forward(skeleton, root, rotations)
    limits = jax.tree.map(np.asarray, rig.limits)
    beyond = outside(rotations[:, np.array(rig.limited, dtype=np.int64)], limits)
    arrays = (root, rotations, places, world, free, beyond)
    names = ("root", "rotations", "places", "world", "free", "outside")
    rounded = (np.asarray(x, dtype=np.float32) for x in arrays)
    return Base(**dict(zip(names, rounded, strict=True)))


def changed_with_slopes(rig: Rig, base: Base, channels: Float[Array, "T C"]) -> Changed:
    """Places of joints in changed poses, and how they and bounds change with the channels.

    As :func:`mgjax.avoidance.refinement.pose.changed` has them; joints between hip and knee count
    as if they did not follow.
    """
    groups, legs = len(rig.groups), len(rig.legs)
    moments = len(base.root)
    split = 3 + 3 * groups
    vectors = channels[:, 3:split].reshape(moments, groups, 3)
    turns = jnp.einsum("tgx,gj->tjx", vectors, rig.shares)
    rotations = quaternion.multiply(base.rotations, quaternion.exp(turns))
    places, world = forward(rig.skeleton, base.root + channels[:, :3], rotations)

    # A joint that turns moves all below it about itself.
    joints = np.array(rig.limited, dtype=np.int64)
    turning = np.array([0, *joints], dtype=np.int64)
    below = jnp.asarray(_below(rig.skeleton.parents)[turning], dtype=places.dtype)  # [M, J]
    spin = _spins(world[:, turning], turns[:, turning])  # [T, M, 3 (world), 3 (channel)]
    share = rig.shares[:, turning]  # [G, M]
    axes = jnp.einsum("gm,mj,tmxk->tjxgk", share, below, spin)
    lever = jnp.cross(jnp.swapaxes(spin, -1, -2), places[:, turning, None])  # [T, M, k, x]
    shift = jnp.einsum("gm,mj,tmkx->tjxgk", share, below, lever)
    axes, shift = (x.reshape(*x.shape[:3], 3 * groups) for x in (axes, shift))
    turned = jnp.cross(axes, places[..., None], axis=2) - shift
    root = jnp.broadcast_to(jnp.eye(3, dtype=places.dtype), (*places.shape[:2], 3, 3))
    still = jnp.zeros((*places.shape, 3 * legs), dtype=places.dtype)
    to_places = jnp.concatenate([root, turned, still], axis=-1)

    own, own_slopes = _outside_with_slopes(rig, base, turns[:, joints])
    to_own = jnp.einsum("gn,tnk->tngk", rig.shares[:, joints], own_slopes)
    to_own = to_own.reshape(moments, len(joints), 3 * groups)
    zeros = (jnp.zeros((moments, len(joints), k), dtype=places.dtype) for k in (3, 3 * legs))
    to_own = jnp.concatenate([next(zeros), to_own, next(zeros)], axis=-1)
    own = own - base.outside
    if not legs:
        return Changed(places=places, to_places=to_places, bounds=own, to_bounds=to_own)
    hips, knees, ends = (np.array(x, dtype=np.int64) for x in zip(*rig.legs, strict=True))
    moved = channels[:, split:].reshape(moments, legs, 3) * base.free[..., None]
    ahead = jnp.array([0.0, 0.0, 1.0], dtype=places.dtype)
    bones = Bones(
        hip=places[:, hips],
        knee=places[:, knees],
        ankle=places[:, ends],
        shin=world[:, knees],
        before=base.world[:, knees],
        target=base.places[:, ends] + moved,
        ahead=quaternion.rotate(world[:, knees], jnp.broadcast_to(ahead, (moments, legs, 3))),
    )
    followed, slopes = _follow_with_slopes(bones)
    free = jnp.einsum(
        "tl,lm,xy->tlxmy",
        base.free,
        jnp.eye(legs, dtype=places.dtype),
        jnp.eye(3, dtype=places.dtype),
    )
    free = free.reshape(moments, legs, 3, 3 * legs)
    to_target = jnp.concatenate(
        [jnp.zeros((moments, legs, 3, split), dtype=places.dtype), free], axis=-1
    )
    spins = jnp.concatenate([jnp.zeros_like(root[:, hips]), axes[:, hips], still[:, hips]], axis=-1)
    told = jnp.concatenate([to_places[:, hips], spins, to_target], axis=-2)  # [T, L, 9, C]
    to_leg = jax.tree.map(lambda x: jnp.einsum("tl...n,tlnc->tl...c", x, told), slopes)

    places, to_places = jnp.asarray(places), jnp.asarray(to_places)
    feet = _below(rig.skeleton.parents)[ends] | np.eye(rig.skeleton.num_joints, dtype=bool)[ends]
    for leg in range(legs):
        places = places.at[:, knees[leg]].set(followed.knee[:, leg])
        to_places = to_places.at[:, knees[leg]].set(to_leg.knee[:, leg])
        foot = np.flatnonzero(feet[leg])
        places = places.at[:, foot].set(base.places[:, foot] + moved[:, leg, None])
        to_places = to_places.at[:, foot].set(to_target[:, leg, None])
    flat = (moments, -1, rig.channels)
    return Changed(
        places=places,
        to_places=to_places,
        bounds=jnp.concatenate([followed.turns.reshape(moments, -1), own, followed.missed], axis=1),
        to_bounds=jnp.concatenate([to_leg.turns.reshape(flat), to_own, to_leg.missed], axis=1),
    )


def _below(parents: tuple[int, ...]) -> np.ndarray:
    """Whether the second joint is below the first. [J, J]"""
    count = len(parents)
    below = np.zeros((count, count), dtype=bool)
    for joint, parent in enumerate(parents):
        if parent >= 0:
            below[:, joint] = below[:, parent]
            below[parent, joint] = True
    return below


def _spins(world: Float[Array, "T M 4"], turns: Float[Array, "T M 3"]) -> Float[Array, "T M 3 3"]:
    """Rotation of the world for a change of each component of rotation vectors.

    exp(v + dv) = exp(v) exp(J dv) with the right Jacobian J of rotations.
    """
    square = jnp.sum(turns * turns, axis=-1)[..., None]
    # Series: cosine and sine of small angles cancel in 32 bits.
    first = 0.5 - square / 24 + square * square / 720
    second = 1 / 6 - square / 120 + square * square / 5040
    columns = []
    for unit in np.eye(3, dtype=np.float32):
        e = jnp.broadcast_to(jnp.asarray(unit), turns.shape)
        once = jnp.cross(turns, e)
        own = e - first * once + second * jnp.cross(turns, once)
        columns.append(quaternion.rotate(world, own))
    return jnp.stack(columns, axis=-1)


def _outside_with_slopes(
    rig: Rig, base: Base, turns: Float[Array, "T n 3"]
) -> tuple[Float[Array, "T n"], Float[Array, "T n 3"]]:
    """By how much joints are outside of their range, and derivatives by their own turns."""
    before = base.rotations[:, np.array(rig.limited, dtype=np.int64)]

    def along(unit: Array) -> tuple[Array, Array]:
        return jax.jvp(
            lambda v: outside(quaternion.multiply(before, quaternion.exp(v)), rig.limits),
            (turns,),
            (jnp.broadcast_to(unit, turns.shape),),
        )

    return jax.vmap(along, out_axes=(None, -1))(jnp.eye(3, dtype=turns.dtype))


def _follow_with_slopes(bones: Bones) -> tuple[Followed, Followed]:
    """What the legs do, and its derivatives with respect to what they are told, last axis."""
    told = jnp.zeros((*bones.hip.shape[:-1], 9), dtype=bones.hip.dtype)

    def along(unit: Array) -> tuple[Followed, Followed]:
        return jax.jvp(lambda x: follow(bones, x), (told,), (jnp.broadcast_to(unit, told.shape),))

    return jax.vmap(along, out_axes=(None, -1))(jnp.eye(9, dtype=told.dtype))
