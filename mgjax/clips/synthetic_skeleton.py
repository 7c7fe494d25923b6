"""The body of the procedural motion set: skeleton, and a pose from named channels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.core import kinematics, planar, quaternion, two_bone
from mgjax.core.arrays import Array
from mgjax.core.skeleton import Skeleton

Put = Callable[[str, Array], None]
"""Sets the local rotation of a joint by name."""
SIDES = ("l", "r")
THIGH_M, SHIN_M = 0.43, 0.42
BALL_FROM_ANKLE = np.array([0.0, -0.055, 0.125])
"""From the ankle to the ball of the foot with the sole flat, m."""
BALL_HEIGHT_M = 0.02
"""The joint lies inside the foot, this far above the sole."""
HIP_M = (0.09, -0.09, 0.0)
"""The left hip from the root, m."""
BALLS = tuple(np.array([side * 0.115, BALL_HEIGHT_M, 0.085]) for side in (1, -1))
"""Neutral places of the balls of the left and the right foot, from under the root, m."""
ROOT_HEIGHT_M = 0.99
"""The root's height in the neutral stance; the knees are a little bent."""

# Joint, parent, offset in m. T-pose with the legs straight down; "@" is a side, written for the
# left one (+X). Joints stand where the CMU bone of that name begins.
_SPINE = (
    ("lowerback", "root", (0.0, 0.0, 0.0)),
    ("upperback", "lowerback", (0.0, 0.12, -0.01)),
    ("thorax", "upperback", (0.0, 0.12, 0.0)),
    ("lowerneck", "thorax", (0.0, 0.125, 0.0)),
    ("upperneck", "lowerneck", (0.0, 0.09, 0.015)),
    ("head", "upperneck", (0.0, 0.09, 0.01)),
    ("head_end", "head", (0.0, 0.14, 0.0)),
)
_LEG = (
    ("@hipjoint", "root", (0.0, 0.0, 0.0)),
    ("@femur", "@hipjoint", HIP_M),
    ("@tibia", "@femur", (0.0, -THIGH_M, 0.0)),
    ("@foot", "@tibia", (0.0, -SHIN_M, 0.0)),
    ("@toes", "@foot", tuple(BALL_FROM_ANKLE.tolist())),
    ("@toes_end", "@toes", (0.0, 0.0, 0.065)),
)
_ARM = (
    ("@clavicle", "thorax", (0.0, 0.125, 0.0)),
    ("@humerus", "@clavicle", (0.18, 0.02, -0.02)),
    ("@radius", "@humerus", (0.29, 0.0, 0.0)),
    ("@wrist", "@radius", (0.17, 0.0, 0.0)),
    ("@hand", "@wrist", (0.09, 0.0, 0.0)),
    ("@fingers", "@hand", (0.05, 0.0, 0.0)),
    ("@fingers_end", "@fingers", (0.05, 0.0, 0.0)),
    ("@thumb", "@wrist", (0.09, 0.0, 0.0)),
    ("@thumb_end", "@thumb", (0.035, 0.0, 0.035)),
)

# How the three spine joints share twist (Y), forward bend (X) and sideways lean (Z): the lumbar
# spine hardly twists, the rib cage bends least.
_SPINE_SHARES = ((0.15, 0.4, 0.3), (0.35, 0.35, 0.35), (0.5, 0.25, 0.35))
_HEAD_STEADY = 0.7
"""Share of the torso's tilt and twist that the neck takes back, so that the eyes stay level."""

CHANNELS = (
    *("side", "up", "fore", "yaw", "pitch", "roll"),  # pelvis: m to its left, up, forward; rad
    *("twist", "bend", "lean"),  # spine: to the left, forward, to the left
    *("look", "nod", "tilt"),  # head: to the left, down, to the left
    *("flex_l", "open_l", "turn_l", "elbow_l"),  # arm: forward, away from the body, inward; elbow
    *("flex_r", "open_r", "turn_r", "elbow_r"),
    *("heel_l", "heel_r", "knees"),  # heels off the floor; knees outward
)
"""What a gesture can move. Lengths in m, angles in rad, positive towards the side named."""


@dataclass(frozen=True, kw_only=True)
class Foot:
    """One foot over time.

    Attributes:
        ball: place of the ball of the foot, m.
        yaw: direction of the foot, rad.
        pitch: heel above ball, rad; negative on the heel.
        toe_pitch: the toes' own, so that they lie flat while the heel rises.
    """

    ball: Float[Array, "F 3"]
    yaw: Float[Array, " F"]
    pitch: Float[Array, " F"]
    toe_pitch: Float[Array, " F"]

    def ankle(self) -> Float[Array, "F 3"]:
        """Place of the ankle, m."""
        return self.ball - quaternion.rotate(self.rotation(), BALL_FROM_ANKLE)

    def rotation(self) -> Float[Array, "F 4"]:
        """World rotation of the foot."""
        return quaternion.from_euler(np.stack([self.yaw, self.pitch], axis=-1), "YX")


def ball_place(place: Array, foot: int, narrow: float = 0.0) -> Array:
    """[3] the ball of the left (0) or right foot (1) of a body that stands at a planar transform.

    ``narrow`` is how much nearer to the middle than neutral the foot stands, m.
    """
    inward = np.array([narrow if foot else -narrow, 0.0, 0.0])
    return planar.apply(place, BALLS[foot] + inward)


def synthetic_skeleton() -> Skeleton:
    """A symmetric body of 1.7 m with the joint names and hierarchy of the CMU skeletons."""
    rows: list[tuple[str, str, tuple[float, ...]]] = []
    for part, side in ((_LEG, "l"), (_LEG, "r"), (_SPINE, ""), (_ARM, "l"), (_ARM, "r")):
        for name, parent, (x, y, z) in part:
            place = (-x if side == "r" else x, y, z)
            rows.append((name.replace("@", side), parent.replace("@", side), place))
    names = ("root", *(name for name, _, _ in rows))
    return Skeleton(
        names=names,
        parents=(-1, *(names.index(parent) for _, parent, _ in rows)),
        offsets=np.array([(0.0, 0.0, 0.0), *(place for _, _, place in rows)], dtype=np.float32),
        end_joints=tuple(j for j, name in enumerate(names) if name.endswith("_end")),
    )


def pose(
    skeleton: Skeleton,
    root: Float[Array, "F 3"],
    heading: Float[Array, " F"],
    gaze: Float[Array, " F"],
    channels: Mapping[str, Float[Array, " F"]],
    feet: tuple[Foot, Foot],
) -> Float[Array, "F J 4"]:
    """Local rotations of all joints.

    Args:
        skeleton: the one of :func:`synthetic_skeleton`.
        root: place of the root, m.
        heading: direction of the body on the floor, rad, before the pelvis' own ``yaw``.
        gaze: direction in which the head tends to look, rad.
        channels: one array for each of :data:`CHANNELS`.
        feet: left and right; the legs are solved so that the ankles meet them.
    """
    local = np.zeros((len(root), skeleton.num_joints, 4))
    local[..., 0] = 1.0

    def put(name: str, rotation: Array) -> None:
        local[:, skeleton.index(name)] = rotation

    c = channels
    put("root", _yxz(heading + c["yaw"], c["pitch"], -c["roll"]))
    _pose_torso(put, local[:, 0], gaze, c)
    for side in SIDES:
        _pose_arm(put, side, c)
    places, rotations = kinematics.forward(skeleton, root, local)
    for side, foot, sign in zip(SIDES, feet, (1, -1), strict=True):
        hip = skeleton.index(f"{side}femur")
        knee_yaw = 0.7 * foot.yaw + 0.3 * (heading + c["yaw"]) + sign * c["knees"]
        turns = _leg(places[:, hip], foot, knee_yaw)
        above = rotations[:, 0]
        for name, turn in zip(("femur", "tibia", "foot", "toes"), turns, strict=True):
            put(side + name, quaternion.multiply(quaternion.conjugate(above), turn))
            above = turn
    return local


def _pose_torso(put: Put, root: Array, gaze: Array, c: Mapping[str, Array]) -> None:
    chest = root
    for (name, _, _), (y, x, z) in zip(_SPINE[:3], _SPINE_SHARES, strict=True):
        turn = _yxz(y * c["twist"], x * c["bend"], -z * c["lean"])
        put(name, turn)
        chest = quaternion.multiply(chest, turn)
    steady = quaternion.slerp(chest, quaternion.from_yaw(gaze), np.array(_HEAD_STEADY))
    wanted = quaternion.multiply(steady, _yxz(c["look"], c["nod"], -c["tilt"]))
    turn = quaternion.multiply(quaternion.conjugate(chest), wanted)
    third = quaternion.slerp(np.array([1.0, 0.0, 0.0, 0.0]), turn, np.array(1 / 3))
    for name in ("lowerneck", "upperneck", "head"):
        put(name, third)


def _pose_arm(put: Put, side: str, c: Mapping[str, Array]) -> None:
    flex, away, turn, elbow = (c[f"{n}_{side}"] for n in ("flex", "open", "turn", "elbow"))
    # Arms hang: the shoulder takes back most of what the torso tilts, except into the ribs.
    flex = flex + 0.7 * (c["pitch"] + c["bend"])
    tilt = (c["roll"] + c["lean"]) * (1 if side == "l" else -1)
    away = away + 0.3 * (tilt + np.sqrt(tilt * tilt + 0.01) - 0.1)
    zero = np.zeros_like(flex)
    angles = {
        "clavicle": (zero, zero, 0.15 * away + 0.08 * flex),
        "radius": (zero, -elbow, zero),
        "wrist": (zero + 0.25, zero, zero),
        "fingers": (zero, zero, zero - 0.5),
    }
    mirror = np.array([1, 1, 1, 1] if side == "l" else [1, 1, -1, -1])
    upper = quaternion.from_euler(np.stack([-flex, away - 0.5 * np.pi, turn], axis=-1), "XZX")
    put(f"{side}humerus", upper * mirror)
    for name, xyz in angles.items():
        put(side + name, quaternion.from_euler(np.stack(xyz, axis=-1), "XYZ") * mirror)


def _leg(hip: Array, foot: Foot, knee_yaw: Array) -> tuple[Array, Array, Array, Array]:
    """World rotations of thigh, shin, foot and toes that put the ankle in its place."""
    # The solver starts from a leg bent by 60° in the plane in which the knee is to point.
    bent = np.full_like(knee_yaw, np.pi / 6)
    old = [quaternion.from_euler(np.stack([knee_yaw, a], axis=-1), "YX") for a in (-bent, bent)]
    knee = hip + quaternion.rotate(old[0], np.array([0.0, -THIGH_M, 0.0]))
    ankle = knee + quaternion.rotate(old[1], np.array([0.0, -SHIN_M, 0.0]))
    pole = quaternion.rotate(quaternion.from_yaw(knee_yaw), np.array([0.0, 0.0, 1.0]))
    hip_turn, knee_turn = two_bone.solve(hip, knee, ankle, foot.ankle(), pole)
    return (
        quaternion.multiply(hip_turn, old[0]),
        quaternion.multiply(hip_turn, quaternion.multiply(knee_turn, old[1])),
        foot.rotation(),
        quaternion.from_euler(np.stack([foot.yaw, foot.toe_pitch], axis=-1), "YX"),
    )


def _yxz(y: Array, x: Array, z: Array) -> Array:
    return quaternion.from_euler(np.stack([y, x, z], axis=-1), "YXZ")
