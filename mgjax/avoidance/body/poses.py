"""All poses of a graph and the spheres of its skeleton, as compiled code reads them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.core.arrays import Array
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.pytree import register
from mgjax.graph.types import MotionGraph


@register()
@dataclass(frozen=True, kw_only=True)
class Body:
    """All poses of a graph, and the spheres of its skeleton, as jax arrays."""

    skeleton: Skeleton
    root: Float[Array, "F 3"]
    rotations: Float[Array, "F J 4"]
    first: Int[Array, " S"]
    second: Int[Array, " S"]
    share: Float[Array, "S 1"]
    radii: Float[Array, " S"]


@lru_cache(maxsize=4)
def body_of(graph: MotionGraph) -> tuple[Body, float]:
    """The graph's body, and how far from the root any point of it can be, m."""
    skeleton, spheres = graph.skeleton, preset_spheres(graph.skeleton)
    lengths = np.zeros(skeleton.num_joints)
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            lengths[joint] = lengths[parent] + np.linalg.norm(np.asarray(skeleton.offsets)[joint])
    reach = np.maximum(lengths[spheres.first], lengths[spheres.second]) + spheres.radii
    body = Body(
        skeleton=Skeleton(
            names=skeleton.names,
            parents=skeleton.parents,
            offsets=jnp.asarray(skeleton.offsets, dtype=jnp.float32),
            end_joints=skeleton.end_joints,
        ),
        root=jnp.asarray(graph.root_translation, dtype=jnp.float32),
        rotations=jnp.asarray(graph.local_rotations, dtype=jnp.float32),
        first=jnp.asarray(spheres.first, dtype=jnp.int32),
        second=jnp.asarray(spheres.second, dtype=jnp.int32),
        share=jnp.asarray(spheres.share[:, None], dtype=jnp.float32),
        radii=jnp.asarray(spheres.radii, dtype=jnp.float32),
    )
    return body, float(reach.max())
