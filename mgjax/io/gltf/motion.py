"""The part of a GLB file that moves: joints as nodes, and an animation of them."""

from __future__ import annotations

import numpy as np

from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.gltf.builder import GlbBuilder


def add_joints(builder: GlbBuilder, skeleton: Skeleton) -> list[int]:
    """Adds a node for each joint in the rest pose, marked where it only ends a bone."""
    offsets = np.asarray(skeleton.offsets, np.float32)
    ends = set(skeleton.end_joints)
    first = len(builder.gltf.nodes)
    return [
        builder.node(
            name=name,
            translation=offsets[joint].tolist(),
            children=[first + c for c, parent in enumerate(skeleton.parents) if parent == joint],
            extras={"end_joint": True} if joint in ends else {},
        )
        for joint, name in enumerate(skeleton.names)
    ]


def add_animation(
    builder: GlbBuilder, nodes: list[int], skeleton: Skeleton, motion: Motion
) -> None:
    """Adds the animation: the root's place, all rotations, places of joints that are not rigid.

    What never changes gets one key. The frame rate is told beside it, since float32 times of keys
    do not tell it exactly.
    """
    lib = builder.lib
    times = (np.arange(motion.num_frames) / motion.frame_rate).astype(np.float32)[:, None]
    inputs: dict[int, int] = {}
    animation = lib.Animation(name="motion", extras={"frame_rate": motion.frame_rate})

    def move(joint: int, path: str, values: np.ndarray, *, keep: bool = False) -> None:
        still = not keep and bool((values == values[:1]).all())
        count = 1 if still else len(values)
        if count not in inputs:
            inputs[count] = builder.add(times[:count], bounds=True)
        output = builder.add(values[:count])
        animation.samplers.append(lib.AnimationSampler(input=inputs[count], output=output))
        target = lib.AnimationChannelTarget(node=nodes[joint], path=path)
        sampler = len(animation.samplers) - 1
        animation.channels.append(lib.AnimationChannel(sampler=sampler, target=target))

    move(0, "translation", np.asarray(motion.root_translation, np.float32), keep=True)
    rotations = np.asarray(motion.local_rotations, np.float32)[..., [1, 2, 3, 0]]
    ends = set(skeleton.end_joints)
    for joint in range(skeleton.num_joints):
        turns = rotations[:, joint]
        if joint not in ends or (turns[:, :3] != 0).any():
            move(joint, "rotation", turns)
    if motion.joint_offsets is not None:
        offsets = np.asarray(motion.joint_offsets, np.float32)
        for joint in range(1, skeleton.num_joints):
            move(joint, "translation", offsets[:, joint])
    builder.gltf.animations.append(animation)
