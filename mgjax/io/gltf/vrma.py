"""Writing VRM animations (``.vrma``: GLB with the extension VRMC_vrm_animation 1.0)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mgjax.core import quaternion
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, validate_skeleton
from mgjax.io.gltf.builder import GlbBuilder
from mgjax.io.gltf.motion import add_animation, add_joints
from mgjax.io.gltf.tpose import Humanoid, find_humanoid
from mgjax.io.output import replace_file

EXTENSION = "VRMC_vrm_animation"


def save_vrma(path: str | Path, skeleton: Skeleton, motion: Motion) -> None:
    """Writes a motion for any VRM avatar: rotations of humanoid bones and the place of the hips.

    Bones are found by the roles of joints; joints that VRM does not know (such as fingers) are left
    out, their rotations being part of the next bone's. The rest pose is a T-pose, see
    :mod:`mgjax.io.gltf.tpose`. The hips are where the root is.

    Raises:
        ConfigError: pygltflib is not installed.
        SkeletonError: the skeleton is not valid, or lacks bones that VRM requires; it names them.
        MotionError: the motion does not fit the skeleton or is not finite.
        OutputError: the file cannot be written.
    """
    validate_skeleton(skeleton)
    validate_motion(skeleton, motion)
    humanoid = find_humanoid(skeleton)
    builder = GlbBuilder()
    bones, moves = _on_bones(skeleton, motion, humanoid)
    nodes = add_joints(builder, bones)
    builder.gltf.scenes.append(builder.lib.Scene(nodes=[nodes[0]]))
    builder.gltf.scene = 0
    add_animation(builder, nodes, bones, moves)
    humans = {name: {"node": node} for name, node in zip(humanoid.names, nodes, strict=True)}
    extension = {"specVersion": "1.0", "humanoid": {"humanBones": humans}}
    builder.gltf.extensionsUsed = [EXTENSION]
    builder.gltf.extensions = {EXTENSION: extension}
    replace_file(path, builder.to_bytes())


def _on_bones(skeleton: Skeleton, motion: Motion, humanoid: Humanoid) -> tuple[Skeleton, Motion]:
    """The humanoid bones as a skeleton in T-pose, and the same motion on it.

    With our global rotation G and the turn C from the rest pose to the T-pose, the bone's is
    G·C⁻¹: both lay the bone in the same direction.
    """
    parents, places = humanoid.parents, humanoid.places
    offsets = places.copy()
    offsets[1:] -= places[list(parents[1:])]
    bones = Skeleton(names=humanoid.names, parents=parents, offsets=offsets.astype(np.float32))
    turned = forward(
        skeleton,
        np.asarray(motion.root_translation, np.float64),
        np.asarray(motion.local_rotations, np.float64),
    )[1]
    world = quaternion.multiply(
        turned[:, list(humanoid.joints)], quaternion.conjugate(humanoid.turns)[None]
    )
    above = quaternion.conjugate(world[:, [max(parent, 0) for parent in parents]])
    above[:, 0] = (1, 0, 0, 0)
    local = quaternion.normalise(quaternion.multiply(above, world))
    moves = Motion(
        root_translation=np.asarray(motion.root_translation, np.float32),
        local_rotations=np.asarray(local, np.float32),
        frame_rate=motion.frame_rate,
    )
    return bones, moves
