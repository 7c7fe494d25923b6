"""Motion carried from one skeleton to another whose names, rest pose and proportions differ."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mgjax.clips.retarget.body import Body, make_body
from mgjax.clips.retarget.legs import Scale, planted_feet, scale_of, stand
from mgjax.clips.retarget.measure import ENDS, foot_slide, outside_limits, path_error
from mgjax.clips.retarget.turns import carried
from mgjax.core import quaternion
from mgjax.core.body.rest import NewRest, standing_rest
from mgjax.core.errors import MotionError
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton


@dataclass(frozen=True, kw_only=True)
class Retargeted:
    """How a clip was put on another skeleton.

    Attributes:
        clip: its name.
        joints: of its own skeleton.
        scale: of its paths: the leg length of the target by that of its own skeleton.
        frames: of the motion.
        foot_slide_before_m, foot_slide_after_m: travel of planted feet over the floor, both
            together, m per frame; of the source scaled, and of what is written.
        limits_before, limits_after: frames in which a joint is beyond the limits of
            :func:`mgjax.clips.retarget.measure.outside_limits`, of the source and the result.
        end_error_m: mean distance of wrists, ankles and head to where they are in the source,
            relative to the middle of the hips (where roots lie differs) and scaled, m.
        pelvis_lowered_m: how far the pelvis had to go down at most for feet out of reach, m.
    """

    clip: str
    joints: int
    scale: float
    frames: int
    foot_slide_before_m: float
    foot_slide_after_m: float
    limits_before: int
    limits_after: int
    end_error_m: float
    pelvis_lowered_m: float


def retarget(source: Skeleton, motion: Motion, target: Skeleton) -> Motion:
    """The motion on another skeleton; see :func:`carry`. What it shows of its own body is used.

    Raises:
        SkeletonError: a skeleton has no legs.
        MotionError: bones are not rigid.
    """
    if motion.joint_offsets is not None:
        raise MotionError("got bones of changing length, expected rigid bones")
    if (rest := standing_rest(source)) is not None:
        source, motion = rest.skeleton, rest.motion(motion)
    stands = standing_rest(target)
    onto = make_body(target if stands is None else stands.skeleton)
    moved, _ = carry(make_body(source, [motion]), onto, motion)
    return moved if stands is None else _undone(stands, moved)


def carry(source: Body, target: Body, motion: Motion, name: str = "") -> tuple[Motion, Retargeted]:
    """A motion of one body on another, and how that went.

    Joints with the same role turn alike in anatomical axes (:mod:`mgjax.clips.retarget.axes`).
    Paths over the floor are scaled by the length of the legs, and so is the speed of the root.
    Feet are put where the source's are, scaled, and stand still while they are planted.
    """
    places, turns = (
        np.asarray(x)
        for x in forward(
            source.skeleton,
            np.asarray(motion.root_translation, np.float64),
            np.asarray(motion.local_rotations, np.float64),
        )
    )
    scale = scale_of(source, target, places)
    local = carried(source, target, turns)
    root, local = stand(source, target, scale, places, turns, local, motion.frame_rate)
    moved = replace(
        motion, root_translation=root.astype(np.float32), local_rotations=local.astype(np.float32)
    )
    return moved, _judged(source, target, scale, places, turns, moved, name)


def _judged(
    source: Body,
    target: Body,
    scale: Scale,
    places: np.ndarray,
    turns: np.ndarray,
    moved: Motion,
    name: str,
) -> Retargeted:
    root = np.asarray(moved.root_translation, np.float64)
    new, new_turns = (
        np.asarray(x)
        for x in forward(target.skeleton, root, np.asarray(moved.local_rotations, np.float64))
    )
    on = planted_feet(source, scale, places, moved.frame_rate)
    feet = [[b.roles[f"{s}_{scale.point}"] for s in ("left", "right")] for b in (source, target)]
    both = [role for role in ENDS if role in source.roles and role in target.roles]
    ends = [[body.roles[role] for role in both] for body in (source, target)]
    hips = [[body.roles[f"{s}_hip"] for s in ("left", "right")] for body in (source, target)]
    middle, new_middle = places[:, hips[0]].mean(axis=1), new[:, hips[1]].mean(axis=1)
    return Retargeted(
        clip=name,
        joints=source.skeleton.num_joints,
        scale=scale.factor,
        frames=moved.num_frames,
        foot_slide_before_m=scale.factor * foot_slide(places[:, feet[0]], on),
        foot_slide_after_m=foot_slide(new[:, feet[1]], on),
        limits_before=int(outside_limits(source, places, turns).sum()),
        limits_after=int(outside_limits(target, new, new_turns).sum()),
        end_error_m=path_error(
            (places[:, ends[0]] - middle[:, None]) * scale.factor,
            new[:, ends[1]] - new_middle[:, None],
        ),
        pelvis_lowered_m=float(np.max(scale.place(middle)[:, 1] - new_middle[:, 1])),
    )


def _undone(rest: NewRest, motion: Motion) -> Motion:
    """A motion of the standing rest pose, for the rest pose that the skeleton came with."""
    parents = np.maximum(np.array(rest.skeleton.parents), 0)
    above = rest.turns[parents].copy()
    above[0] = [1.0, 0.0, 0.0, 0.0]
    local = np.asarray(motion.local_rotations, np.float64)
    turned = quaternion.multiply(
        quaternion.multiply(quaternion.conjugate(above), local), rest.turns
    )
    return replace(motion, local_rotations=np.asarray(turned, np.float32))
