"""A skeleton as the page draws it: its bones and the surface around them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from mgjax.core.skeleton import Skeleton
from mgjax.io.skin.mesh import body_mesh
from mgjax.stage.show.types import Body, BodyMesh


def body_of(skeleton: Skeleton) -> Body:
    """The body of any skeleton, made once for each that is equal."""
    offsets = np.ascontiguousarray(skeleton.offsets, dtype=np.float32)
    return _body(
        skeleton.names, skeleton.parents, skeleton.end_joints, skeleton.roles, offsets.tobytes()
    )


@lru_cache(maxsize=64)
def _body(
    names: tuple[str, ...],
    parents: tuple[int, ...],
    end_joints: tuple[int, ...],
    roles: tuple[tuple[str, int], ...],
    offsets: bytes,
) -> Body:
    bones = np.frombuffer(offsets, np.float32).reshape(-1, 3)
    skeleton = Skeleton(
        names=names, parents=parents, offsets=bones, end_joints=end_joints, roles=roles
    )
    mesh = body_mesh(skeleton)
    joints = np.zeros((len(mesh.joints), 4), np.uint16)
    joints[:, 0] = mesh.joints
    weights = np.zeros((len(mesh.joints), 4), np.uint8)
    weights[:, 0] = 255
    unit = max(float(np.abs(mesh.vertices).max()), 1e-3) / 32767
    return Body(
        parents=np.array(parents, np.int16),
        offsets=bones,
        names=names,
        mesh=BodyMesh(
            places=np.rint(mesh.vertices / unit).astype(np.int16),
            unit=unit,
            normals=np.rint(127 * mesh.normals).astype(np.int8),
            joints=joints,
            weights=weights,
            triangles=mesh.triangles.astype(np.uint32),
        ),
    )
