"""A capture turned upright, put on its floor, with its sides told apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.core import quaternion
from mgjax.core.body.height import body_height, tree_of
from mgjax.core.body.limbs import Limbs
from mgjax.core.body.roles import ROLES
from mgjax.core.errors import ConfigError
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.reading.capture import Capture
from mgjax.io.reading.raw import Note
from mgjax.io.reading.read_as import ReadAs
from mgjax.io.reading.roots import FloorRoot
from mgjax.io.reading.upright import (
    FLOOR_SHARE,
    FoundUp,
    axis_vector,
    feet_heights,
    find_up,
    floor_level,
    forward_of,
    sides_swapped,
    turn_to_y,
)

SAMPLES = 64
"""Frames that are looked at: more change nothing, and reading stays quick."""


def stand(
    capture: Capture,
    above: FloorRoot | None,
    roles: dict[str, int],
    read_as: ReadAs,
    *,
    stated: bool,
) -> tuple[Capture, FloorRoot | None]:
    """Turned upright, with its floor at 0, and looking along +Z where a user said its front."""
    skeleton, motion, reading = capture.skeleton, capture.motion, capture.reading
    tree = tree_of(skeleton)
    height = reading.height_m or 0.0
    places = sampled(capture)
    up = find_up(tree, roles, places, height, "y" if stated and not read_as.up else read_as.up)
    notes = [*reading.notes, *up.notes]
    turn = turn_to_y(up.axis)
    places = places @ turn.T
    looks = forward_of(places, roles)
    front = _nearest_axis(looks[0])
    floor, note = _floor(feet_heights(tree, roles, places), height, read_as, stated=stated)
    notes += [Note("floor", note)] if note else []
    if sides_swapped(places, roles):
        text = "what is called left is on the right: mirrored, or the axes are left-handed"
        notes.append(Note("sides", text))
    heading = np.eye(3)
    if read_as.front is not None:
        heading = _heading(turn @ axis_vector(read_as.front), read_as)
        front = _nearest_axis(heading @ looks[0])
    total = heading @ turn
    if not np.allclose(total, np.eye(3)):
        skeleton, motion = _turned(skeleton, motion, turn, up, heading)
    shift = np.array([0.0, floor, 0.0], dtype=np.float32)
    motion = replace(motion, root_translation=motion.root_translation - shift)
    reading = replace(
        reading, up=up.axis, up_sure=up.cosine, floor_m=floor, front=front, notes=tuple(notes)
    )
    if above is not None:
        q = np.broadcast_to(quaternion.from_matrix(total), above.rotation.shape)
        above = replace(
            above,
            translation=above.translation @ total.T - shift,
            rotation=np.asarray(quaternion.multiply(q, above.rotation)),
        )
    return Capture(skeleton=skeleton, motion=motion, reading=reading), above


def sampled(capture: Capture) -> np.ndarray:
    """[T,J,3] joint places of frames spread over the motion, m."""
    skeleton, motion = capture.skeleton, capture.motion
    frames = np.unique(np.linspace(0, motion.num_frames - 1, SAMPLES).astype(int))
    offsets = motion.joint_offsets
    places, _ = forward(
        skeleton,
        np.asarray(motion.root_translation[frames], dtype=np.float64),
        np.asarray(motion.local_rotations[frames], dtype=np.float64),
        None if offsets is None else np.asarray(offsets[frames], dtype=np.float64),
    )
    return np.asarray(places)


def _floor(
    heights: np.ndarray, height: float, read_as: ReadAs, *, stated: bool
) -> tuple[float, str]:
    """Height of the floor to take off, m, and what is to be said of it."""
    if isinstance(read_as.floor, (int, float)):
        return float(read_as.floor), ""
    level = floor_level(heights)
    if stated or abs(level) <= FLOOR_SHARE * height:
        return 0.0, ""
    where = f"the floor is {abs(level):.2f} m {'low' if level < 0 else 'high'}"
    if read_as.floor == "keep":
        return 0.0, f"{where} and was left so"
    return level, f"{where}; it was moved to 0 (--floor=keep leaves it)"


def _nearest_axis(forward: np.ndarray) -> str:
    if np.hypot(forward[0], forward[2]) < 1e-6:
        return ""
    at = 0 if abs(forward[0]) > abs(forward[2]) else 2
    return ("" if forward[at] > 0 else "-") + "xyz"[at]


def _heading(front: np.ndarray, read_as: ReadAs) -> np.ndarray:
    """[3,3] turn about Y that brings ``front`` to +Z."""
    if abs(front[1]) > 0.5:
        raise ConfigError(f"front {read_as.front!r} is the axis that points up, expected another")
    return np.array([[front[2], 0, -front[0]], [0, 1, 0], [front[0], 0, front[2]]])


def _turned(
    skeleton: Skeleton, motion: Motion, turn: np.ndarray, up: FoundUp, heading: np.ndarray
) -> tuple[Skeleton, Motion]:
    """All places turned; the rest pose as well where it stood along the axis that was up."""
    total = heading @ turn
    rotations = np.asarray(motion.local_rotations, dtype=np.float64)
    offsets, moving = np.asarray(skeleton.offsets), motion.joint_offsets
    world = quaternion.from_matrix(total)
    if up.with_rest:
        q = quaternion.from_matrix(turn)
        back = quaternion.conjugate(q)
        rotations = np.asarray(quaternion.multiply(quaternion.multiply(q, rotations), back))
        offsets = (offsets @ turn.T).astype(np.float32)
        moving = None if moving is None else (moving @ turn.T).astype(np.float32)
        world = quaternion.from_matrix(heading)
    rotations = rotations.copy()
    rotations[:, 0] = np.asarray(
        quaternion.multiply(np.broadcast_to(world, rotations[:, 0].shape), rotations[:, 0])
    )
    root = np.asarray(motion.root_translation, dtype=np.float64) @ total.T
    return replace(skeleton, offsets=offsets), replace(
        motion,
        root_translation=root.astype(np.float32),
        local_rotations=rotations.astype(np.float32),
        joint_offsets=moving,
    )


def with_roles(
    capture: Capture, limbs: Limbs | None, roles: dict[str, int], read_as: ReadAs
) -> Capture:
    """Roles kept with the skeleton where they cannot be found again: said, or sides by place."""
    skeleton = capture.skeleton
    swapped = False
    if limbs is not None and not limbs.named_sides and "left_hip" in roles:
        swapped = sides_swapped(sampled(capture), roles)
        said = dict(read_as.roles)
        if swapped:
            roles = {
                role if role in said else _other_side(role): joint for role, joint in roles.items()
            }
    if not read_as.roles and not swapped:
        return capture
    pairs = tuple((role, roles[role]) for role in ROLES if role in roles)
    skeleton = replace(skeleton, roles=pairs)
    reading = replace(capture.reading, height_m=body_height(skeleton))
    if swapped:
        reading = replace(reading, notes=tuple(n for n in reading.notes if n.kind != "sides"))
    return replace(capture, skeleton=skeleton, reading=reading)


def _other_side(role: str) -> str:
    side, _, part = role.partition("_")
    return {"left": f"right_{part}", "right": f"left_{part}"}.get(side, role)
