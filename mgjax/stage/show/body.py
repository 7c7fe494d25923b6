"""A skeleton as the page draws it: its bones and the skin around them."""

from __future__ import annotations

import numpy as np

from mgjax.core.skeleton import Skeleton
from mgjax.io.skin.cached import skin_of
from mgjax.stage.show.types import Body, BodyMesh

_STEPS = 4095
"""A place is one of so many steps from the root: within a quarter of a millimetre for a person."""


def body_of(skeleton: Skeleton) -> Body:
    """The body of any skeleton.

    The skin of a body whose rest pose does not stand has seams at its joints: see
    :func:`mgjax.stage.show.standing.standing`.
    """
    mesh = skin_of(skeleton)
    unit = max(float(np.abs(mesh.vertices).max()), 1e-3) / _STEPS
    joint_type = np.uint8 if skeleton.num_joints <= 256 else np.uint16
    return Body(
        parents=np.array(skeleton.parents, np.int16),
        offsets=np.asarray(skeleton.offsets, np.float32),
        names=skeleton.names,
        mesh=BodyMesh(
            places=np.rint(mesh.vertices / unit).astype(np.int16),
            unit=unit,
            normals=np.rint(127 * mesh.normals).astype(np.int8),
            joints=mesh.joints.astype(joint_type),
            weights=mesh.weights.astype(np.uint8),
            triangles=_sorted(mesh.triangles).astype(
                np.uint16 if len(mesh.vertices) < 65536 else np.uint32
            ),
        ),
    )


def _sorted(triangles: np.ndarray) -> np.ndarray:
    """In an order in which they take less room in a file."""
    first = triangles.argmin(axis=1)[:, None]
    turned = np.take_along_axis(triangles, (first + np.arange(3)) % 3, axis=1)
    return turned[np.lexsort((turned[:, 2], turned[:, 1], turned[:, 0]))]
