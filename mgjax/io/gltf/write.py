"""Writing GLB files: an animated skeleton with a body around it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, rest_positions, validate_skeleton
from mgjax.io.gltf.builder import INDICES, VERTICES, GlbBuilder
from mgjax.io.gltf.motion import add_animation, add_joints
from mgjax.io.output import replace_file
from mgjax.io.skin.mesh import COLOUR, body_mesh


def save_glb(path: str | Path, skeleton: Skeleton, motion: Motion) -> None:
    """Writes a GLB file (glTF 2.0; metres, y up) with one skin, one mesh and one animation.

    Joints have identity rest rotations, as ours do, and keep their names; the body is made of
    capsules along the bones. Reading it back gives the same numbers.

    Raises:
        ConfigError: pygltflib is not installed.
        SkeletonError: the skeleton is not valid.
        MotionError: the motion does not fit the skeleton or is not finite.
        OutputError: the file cannot be written.
    """
    validate_skeleton(skeleton)
    validate_motion(skeleton, motion)
    builder = GlbBuilder()
    joints = add_joints(builder, skeleton)
    mesh = _add_body(builder, skeleton)
    skin = _add_skin(builder, skeleton, joints)
    body = builder.node(name="body", mesh=mesh, skin=skin)
    builder.gltf.scenes.append(builder.lib.Scene(nodes=[joints[0], body]))
    builder.gltf.scene = 0
    add_animation(builder, joints, skeleton, motion)
    replace_file(path, builder.to_bytes())


def _add_skin(builder: GlbBuilder, skeleton: Skeleton, joints: list[int]) -> int:
    """The joints and the inverses of their rest transforms, which are translations."""
    places = rest_positions(skeleton)
    inverse = np.tile(np.eye(4, dtype=np.float32), (len(joints), 1, 1))
    inverse[:, 3, :3] = -places  # columns come one after the other
    matrices = builder.add(inverse.reshape(-1, 16))
    skin = builder.lib.Skin(name="skeleton", joints=joints, inverseBindMatrices=matrices)
    builder.gltf.skins.append(skin)
    return len(builder.gltf.skins) - 1


def _add_body(builder: GlbBuilder, skeleton: Skeleton) -> int:
    lib, body = builder.lib, body_mesh(skeleton)
    wide = np.uint8 if skeleton.num_joints <= 256 else np.uint16
    joints = np.zeros((len(body.joints), 4), wide)
    joints[:, 0] = body.joints
    weights = np.zeros((len(body.joints), 4), np.uint8)
    weights[:, 0] = 255
    attributes = lib.Attributes(
        POSITION=builder.add(body.vertices, target=VERTICES, bounds=True),
        NORMAL=builder.add(body.normals, target=VERTICES),
        JOINTS_0=builder.add(joints, target=VERTICES),
        WEIGHTS_0=builder.add(weights, target=VERTICES, normalized=True),
    )
    word = np.uint16 if len(body.vertices) < 2**16 - 1 else np.uint32
    indices = builder.add(body.triangles.reshape(-1, 1).astype(word), target=INDICES)
    surface = lib.PbrMetallicRoughness(
        baseColorFactor=[*COLOUR, 1.0], metallicFactor=0.0, roughnessFactor=0.6
    )
    builder.gltf.materials.append(lib.Material(name="body", pbrMetallicRoughness=surface))
    primitive = lib.Primitive(attributes=attributes, indices=indices, material=0)
    builder.gltf.meshes.append(lib.Mesh(name="body", primitives=[primitive]))
    return len(builder.gltf.meshes) - 1
