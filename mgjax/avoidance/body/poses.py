"""All poses of a graph and the spheres of its skeleton, as compiled code reads them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.body.spheres import BodySpheres
from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.pytree import register
from mgjax.graph.types import MotionGraph


@register()
@dataclass(frozen=True, kw_only=True)
class GraphPoses:
    """All poses of a graph, and the spheres of its skeleton, as jax arrays.

    Attributes:
        skeleton: with offsets as a jax array.
        root: its place in every frame, m. [F, 3]
        rotations: local, wxyz. [F, J, 4]
        first, second, share: each sphere lies between two joints, so far from the first. [S]
        radii: m. [S]
    """

    skeleton: Skeleton
    root: Float[Array, "F 3"]
    rotations: Float[Array, "F J 4"]
    first: Int[Array, " S"]
    second: Int[Array, " S"]
    share: Float[Array, "S 1"]
    radii: Float[Array, " S"]


@dataclass(frozen=True, kw_only=True, eq=False)
class PosedGraph:
    """A graph with its poses on the device: what the exact check reads.

    Attributes:
        graph: the motion graph.
        poses: all of them.
        reach: how far from the root any point of the body can be, m.
    """

    graph: MotionGraph
    poses: GraphPoses
    reach: float


def graph_poses(graph: MotionGraph, spheres: BodySpheres) -> GraphPoses:
    """Puts the poses of a graph and the spheres of its body on the device."""
    skeleton = graph.skeleton
    return GraphPoses(
        skeleton=replace(skeleton, offsets=jnp.asarray(skeleton.offsets, dtype=jnp.float32)),
        root=jnp.asarray(graph.root_translation, dtype=jnp.float32),
        rotations=jnp.asarray(graph.local_rotations, dtype=jnp.float32),
        first=jnp.asarray(spheres.first, dtype=jnp.int32),
        second=jnp.asarray(spheres.second, dtype=jnp.int32),
        share=jnp.asarray(spheres.share[:, None], dtype=jnp.float32),
        radii=jnp.asarray(spheres.radii, dtype=jnp.float32),
    )


def body_reach(skeleton: Skeleton, spheres: BodySpheres) -> float:
    """How far from the root any point of the body can be, m: along its bones, in any pose."""
    lengths = np.zeros(skeleton.num_joints)
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            lengths[joint] = lengths[parent] + np.linalg.norm(np.asarray(skeleton.offsets)[joint])
    first, second = lengths[spheres.first], lengths[spheres.second]
    beyond = np.maximum(spheres.share - 1, 0) * np.abs(second - first)
    reach = np.maximum(first, second) + beyond + spheres.radii
    return float(reach.max())


def sphere_places(
    poses: GraphPoses, root: Float[Array, "N 3"], rotations: Float[Array, "N J 4"]
) -> Float[Array, "N S 3"]:
    """Centres of the body's spheres in given poses, m, by forward kinematics."""
    positions, _ = forward(poses.skeleton, root, rotations)
    share = poses.share[None]
    return positions[:, poses.first] * (1 - share) + positions[:, poses.second] * share


def placed_poses(
    poses: GraphPoses, frames: Int[Array, " N"], place: Float[Array, "N 3"]
) -> tuple[Float[Array, "N 3"], Float[Array, "N J 4"]]:
    """Root and local rotations of frames of the graph, each moved by a planar transform."""
    rotations = poses.rotations[frames]
    root, first = planar.apply_pose(place, poses.root[frames], rotations[:, 0])
    return root, jnp.concatenate([first[:, None], rotations[:, 1:]], axis=1)
