"""The check while searching: how near an attack comes to a walk as it would be written, jitted.

It looks at the same poses as :mod:`mgjax.avoidance.checks.written` (the frames of the written
motion and the moments between them), but only at those moments at which the attack can reach the
body at all.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import SPHERE_BUCKET
from mgjax.avoidance.body.poses import GraphPoses, PosedGraph, placed_poses, sphere_places
from mgjax.avoidance.rates import CHECK_RATE, FAR
from mgjax.core import planar, quaternion
from mgjax.core.arrays import Array
from mgjax.core.xla.exported import exported
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.core.xla.pytree import register
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, frames_at, place_edges


@register()
@dataclass(frozen=True, kw_only=True)
class Poses:
    """The two frames that each written frame lies between, each with its place in the world."""

    low: Int[Array, " N"]
    high: Int[Array, " N"]
    place_low: Float[Array, "N 3"]
    place_high: Float[Array, "N 3"]
    share: Float[Array, " N"]


CHECK_FRAMES = 64
"""Written frames that a call is compiled for, and four times as many, …"""


@jax.jit
@exported()
def nearest_of(
    graph_poses: GraphPoses,
    poses: Poses,
    attack_centres: Float[Array, "T I 3"],
    attack_radii: Float[Array, " I"],
    absent: Float[Array, "T1 I"],
) -> Float[Array, ""]:
    """Least swept distance over the intervals in which a sphere is not ``absent`` (0 or 1).

    T = 2 N − 1.
    """
    root, rotations = _written_frames(graph_poses, poses)
    # A moment between each two written frames, interpolated as a reader of the file would.
    middle = 0.5 * (root[:-1] + root[1:])
    half = jnp.full((1,), 0.5, dtype=jnp.float32)
    between = quaternion.slerp(rotations[:-1], rotations[1:], half[None])
    root = _interleave(root, middle)
    rotations = _interleave(rotations, between)
    spheres = sphere_places(graph_poses, root, rotations)
    gaps = attack_centres[:, :, None] - spheres[:, None]
    begin, move = gaps[:-1], gaps[1:] - gaps[:-1]
    along = jnp.maximum(jnp.sum(move * move, axis=-1), 1e-20)
    share = jnp.clip(-jnp.sum(begin * move, axis=-1) / along, 0.0, 1.0)
    near = begin + share[..., None] * move
    distance = jnp.sqrt(jnp.sum(near * near, axis=-1))
    distance = distance - attack_radii[None, :, None] - graph_poses.radii[None, None, :]
    return jnp.min(distance + FAR * absent[..., None])


def _written_frames(graph_poses: GraphPoses, poses: Poses) -> tuple[Array, Array]:
    share = poses.share[:, None]
    root_low, low = placed_poses(graph_poses, poses.low, poses.place_low)
    root_high, high = placed_poses(graph_poses, poses.high, poses.place_high)
    return root_low * (1 - share) + root_high * share, quaternion.slerp(low, high, share)


def _interleave(even: Array, odd: Array) -> Array:
    pairs = jnp.stack([even[:-1], odd], axis=1).reshape(-1, *even.shape[1:])
    return jnp.concatenate([pairs, even[-1:]])


def clearance_between(
    posed: PosedGraph, attack: Attack, walk: Walk, start: float, stop: float
) -> float:
    """Clearance of a walk that begins now, from ``start`` to ``stop`` s, m; ``FAR`` if untouched.

    Agrees with :func:`mgjax.avoidance.checks.written.clearance` on the written motion to float32
    rounding and, for attacks whose knots lie between its moments, to what those bend within 1/240
    s.
    """
    begin, end = max(start, attack.start, 0.0), min(stop, attack.end)
    if begin > end:
        return FAR
    first = int(np.floor(begin * CHECK_RATE / 2))  # written frames, at half the rate
    last = max(int(np.ceil(end * CHECK_RATE / 2)), first + 1)
    times = np.arange(first, last + 1) * 2 / CHECK_RATE
    poses, root = _read_walk(posed.graph, walk, times)
    offset = attack.at(np.clip(times, attack.start, attack.end)) - root[:, None]
    gap = np.linalg.norm(offset, axis=-1) - attack.radii[None, :] - posed.reach
    # Between two frames an attack moves on by at most half its step from the nearer one.
    step = attack.largest_speed / CHECK_RATE
    near = np.flatnonzero(gap.min(axis=1) <= step + 0.05)
    if not near.size:
        return FAR
    a, b = max(int(near[0]) - 1, 0), min(int(near[-1]) + 1, len(times) - 1)
    count = b - a + 1
    size = bucket_size(count, CHECK_FRAMES, 4)
    rows = np.minimum(np.arange(a, a + size), b)  # padded by the last
    poses = jax.tree.map(lambda x: x[rows], poses)
    moments = (2 * (first + a) + np.arange(2 * size - 1)) / CHECK_RATE
    moments = np.clip(moments, max(begin, attack.start), end)
    centres, absent = attack.at(moments), ~attack.lives(moments)
    absent[2 * count - 2 :] = True
    slots = bucket_size(len(attack.radii), SPHERE_BUCKET, 8)
    nearest = nearest_of(
        posed.poses,
        poses,
        pad_axis(centres.astype(np.float32), slots, axis=1),
        pad_axis(attack.radii.astype(np.float32), slots),
        pad_axis(absent.astype(np.float32), slots, axis=1, value=1),
    )
    longest = float((attack.times[1:] - attack.times[:-1]).max(initial=0.0))
    between = longest**2 / 8 if longest > 1 / CHECK_RATE else 0.0
    sag = attack.acceleration * (1 / CHECK_RATE**2 / 4 + between)
    return min(float(nearest) - sag, FAR)


def _read_walk(graph: MotionGraph, walk: Walk, times: np.ndarray) -> tuple[Poses, np.ndarray]:
    """Poses of a walk and its root in the world, as ``sample_walk`` has them."""
    played = frames_at(graph, walk, times)
    placed = place_edges(graph, walk.edges)
    share = played.share
    root_low, root_high = (
        np.asarray(planar.apply(placed[edge], graph.root_translation[frames]))
        for frames, edge in ((played.low, played.edge_low), (played.high, played.edge_high))
    )
    poses = Poses(
        low=played.low.astype(np.int32),
        high=played.high.astype(np.int32),
        place_low=placed[played.edge_low].astype(np.float32),
        place_high=placed[played.edge_high].astype(np.float32),
        share=share.astype(np.float32),
    )
    return poses, root_low * (1 - share)[:, None] + root_high * share[:, None]
