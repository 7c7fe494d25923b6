"""What of a body may be changed: the root, groups of joints, and feet that stand on nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.body.spheres import BodySpheres
from mgjax.core.arrays import Array, namespace
from mgjax.core.body.capsules import CapsulePairs, pair_distances
from mgjax.core.body.joint_limits import JointLimits, joint_limits, swing_twist
from mgjax.core.body.roles import find_role
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.pytree import register
from mgjax.graph.types import MotionGraph
from mgjax.quality.subject import subject_of

_CHUNK = 1024
Leg = tuple[int, int, int]
"""Hip, knee and ankle."""


@register("legs", "groups", "limited")
@dataclass(frozen=True, kw_only=True)
class Rig:
    """The channels of a body, in this order: 3 of the root, 3 of each group, 3 of each foot.

    The root is moved, m. The joints of a group turn by a common rotation vector, rad, in their own
    frames, each by its share. A foot is moved, m, with the leg following.

    Attributes:
        skeleton: the body, offsets as a jax array.
        groups: their names.
        shares: how much of the vector of a group each joint turns by. [G, J]
        legs: those that stay with their feet.
        limited: joints with limits.
        limits: of those, as the captured clips show them.
        first, second, place: each sphere of the body lies between two joints, so far from the
            first. [S], [S], [S, 1]
        radii: of the spheres, m. [S]
        pairs: capsules that should not meet. [P]
        apart: how far they are apart at least in the capture, m; at most 0. [P]
    """

    skeleton: Skeleton
    groups: tuple[str, ...]
    shares: Float[Array, "G J"]
    legs: tuple[Leg, ...]
    limited: tuple[int, ...]
    limits: JointLimits
    first: Int[Array, " S"]
    second: Int[Array, " S"]
    place: Float[Array, "S 1"]
    radii: Float[Array, " S"]
    pairs: CapsulePairs
    apart: Float[Array, " P"]

    @property
    def channels(self) -> int:
        """How many there are."""
        return 3 + 3 * len(self.groups) + 3 * len(self.legs)


def make_rig(graph: MotionGraph, spheres: BodySpheres) -> Rig:
    """The channels of a graph's body: those for which it has joints.

    Args:
        graph: its captured clips say how far joints turn.
        spheres: of the body.
    """
    skeleton = graph.skeleton
    groups = joint_groups(skeleton)
    shares = np.zeros((len(groups), skeleton.num_joints), np.float32)
    for row, joints in enumerate(groups.values()):
        shares[row, list(joints)] = 1 / len(joints)
    legs = tuple(leg for side in ("left", "right") if (leg := _leg(skeleton, side)) is not None)
    limited = sorted(j for name, joints in groups.items() if name != "pelvis" for j in joints)
    pairs = subject_of(skeleton)[0].pairs
    return Rig(
        skeleton=replace(skeleton, offsets=jnp.asarray(skeleton.offsets, dtype=jnp.float32)),
        groups=tuple(groups),
        shares=jnp.asarray(shares),
        legs=legs,
        limited=tuple(limited),
        limits=captured_limits(graph, limited),
        first=jnp.asarray(spheres.first, dtype=jnp.int32),
        second=jnp.asarray(spheres.second, dtype=jnp.int32),
        place=jnp.asarray(spheres.share[:, None], dtype=jnp.float32),
        radii=jnp.asarray(spheres.radii, dtype=jnp.float32),
        pairs=pairs,
        apart=jnp.asarray(_apart(graph, pairs), dtype=jnp.float32),
    )


def _apart(graph: MotionGraph, pairs: CapsulePairs) -> Float[np.ndarray, " P"]:
    """How far capsules are apart at least in the captured clips of a graph, m; at most 0."""
    least = np.zeros(len(pairs.reach))
    for first in range(0, int(graph.clip_stops[-1]), _CHUNK):
        some = graph.positions[first : min(first + _CHUNK, int(graph.clip_stops[-1]))]
        np.minimum(least, np.asarray(pair_distances(pairs, some)).min(axis=0), out=least)
    return least


def joint_groups(skeleton: Skeleton) -> dict[str, tuple[int, ...]]:
    """Joints that turn together, by the name of the group; what the body lacks is left out."""
    chest, head = find_role(skeleton, "chest"), find_role(skeleton, "head")
    groups: dict[str, tuple[int, ...]] = {"pelvis": (0,)}
    spine = _between(skeleton, 0, chest)
    groups["spine"] = spine
    groups["neck"] = tuple(j for j in _between(skeleton, 0, head) if j not in spine)
    for side in ("left", "right"):
        for part in ("shoulder", "elbow"):
            joint = find_role(skeleton, f"{side}_{part}")
            groups[f"{side}_{part}"] = () if joint is None else (joint,)
    return {name: joints for name, joints in groups.items() if joints}


def _between(skeleton: Skeleton, top: int, joint: int | None) -> tuple[int, ...]:
    """The joints below one down to another, without the former."""
    found: list[int] = []
    while joint is not None and joint > top:
        found.append(joint)
        joint = skeleton.parents[joint]
    return tuple(reversed(found))


def _leg(skeleton: Skeleton, side: str) -> Leg | None:
    hip, knee, ankle = (find_role(skeleton, f"{side}_{part}") for part in ("hip", "knee", "ankle"))
    return None if hip is None or knee is None or ankle is None else (hip, knee, ankle)


def captured_limits(graph: MotionGraph, joints: list[int]) -> JointLimits:
    """Least and largest swing and twist of joints over the captured clips of a graph.

    Angles count from the mean rotation of a joint there.
    """
    skeleton = graph.skeleton
    offsets = np.asarray(skeleton.offsets, np.float64)
    children = [next((c for c, p in enumerate(skeleton.parents) if p == j), j) for j in joints]
    stop = int(graph.clip_stops[-1])
    rotations = graph.local_rotations[:stop, joints].astype(np.float64)
    moments = np.einsum("fni,fnj->nij", rotations, rotations)
    centre = np.linalg.eigh(moments)[1][..., -1]
    free = [[0.0] * 4] * len(joints)
    open_ = joint_limits(
        offsets[children], swing=free, twist=[[0.0, 0.0]] * len(joints), centre=centre
    )
    swing, twist = swing_twist(rotations, open_)
    box = np.stack(
        [swing[..., 0].min(0), swing[..., 0].max(0), swing[..., 1].min(0), swing[..., 1].max(0)],
        axis=-1,
    )
    return replace(
        open_,
        swing=box.astype(np.float32),
        twist=np.stack([twist.min(0), twist.max(0)], axis=-1).astype(np.float32),
    )


def outside(rotations: Float[Array, "*b n 4"], limits: JointLimits) -> Float[Array, "*b n"]:
    """By how much joints are outside their limits, rad: the largest of swing and twist, or 0."""
    swing, twist = swing_twist(rotations, limits)
    xp = namespace(swing)
    lead = (1,) * (swing.ndim - 2)
    box, span = (xp.asarray(x).reshape(*lead, *x.shape) for x in (limits.swing, limits.twist))
    beyond = xp.concatenate(
        [
            swing - box[..., 1::2],
            box[..., 0::2] - swing,
            (twist - span[..., 1])[..., None],
            (span[..., 0] - twist)[..., None],
        ],
        axis=-1,
    )
    return xp.maximum(xp.max(beyond, axis=-1), 0.0)


def unit_of(rig: Rig, metres: float, radians: float) -> Float[np.ndarray, " C"]:
    """A change of each channel that weighs as much as any other: so many metres, or radians."""
    rotations = 3 * len(rig.groups)
    ends = np.full(3 * len(rig.legs), metres)
    return np.concatenate([np.full(3, metres), np.full(rotations, radians), ends])
