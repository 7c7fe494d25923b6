"""Shows for tests: characters of the procedural set with a body of capsules."""

from __future__ import annotations

from functools import cache

import numpy as np

from mgjax.clips.synthetic import synthetic_clips
from mgjax.clips.types import Clip
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.skin.mesh import body_mesh
from mgjax.stage.show.types import Actor, Body, BodyMesh, Frames

UNIT = 1e-4


@cache
def clips() -> dict[str, Clip]:
    return {clip.name: clip for clip in synthetic_clips()[0]}


def capsule_body(skeleton: Skeleton) -> Body:
    mesh = body_mesh(skeleton)
    count = len(mesh.joints)
    joints = np.zeros((count, 4), np.uint16)
    joints[:, 0] = mesh.joints
    weights = np.zeros((count, 4), np.uint8)
    weights[:, 0] = 255
    return Body(
        parents=np.asarray(skeleton.parents, np.int16),
        offsets=np.asarray(skeleton.offsets, np.float32),
        names=skeleton.names,
        mesh=BodyMesh(
            places=np.round(mesh.vertices / UNIT).astype(np.int16),
            unit=UNIT,
            normals=np.round(mesh.normals * 127).astype(np.int8),
            joints=joints,
            weights=weights,
            triangles=mesh.triangles.astype(np.uint32),
        ),
    )


def frames_of(motion: Motion, *, start: float = 0.0, delta: bool = False) -> Frames:
    turns = np.round(np.asarray(motion.local_rotations) * 32767).astype(np.int16)
    if delta:
        turns = np.concatenate([turns[:1], np.diff(turns, axis=0)])
    return Frames(
        rate=float(motion.frame_rate),
        start=start,
        rotations=turns,
        root=np.asarray(motion.root_translation, np.float32),
        delta=delta,
    )


def moved(motion: Motion, x: float, z: float) -> Motion:
    shift = np.array([x, 0, z], np.float32)
    return Motion(
        root_translation=np.asarray(motion.root_translation) + shift,
        local_rotations=motion.local_rotations,
        frame_rate=motion.frame_rate,
    )


def actor(name: str, *, id: str = "a", at: tuple[float, float] = (0, 0), **settings) -> Actor:
    return Actor(id=id, body=0, frames=frames_of(moved(clips()[name].motion, *at)), **settings)
