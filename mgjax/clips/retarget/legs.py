"""Feet of a retargeted body: on the floor, where the source's are, by a pelvis and two legs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from mgjax.clips.retarget.body import Body
from mgjax.clips.retarget.plants import held_still
from mgjax.core import quaternion, two_bone
from mgjax.core.body.height import body_scale
from mgjax.core.body.roles import SIDES
from mgjax.core.contacts import planted
from mgjax.core.kinematics import forward

PLANT_HEIGHT_M = 0.03
"""How far an adult's planted foot may be over where it is when it stands."""
_BENT = 0.985
"""Share of its length to which a leg may be stretched, or as far as the source's leg is."""
_STRAIGHT = 0.9995
_NEAR_FLOOR_M = 0.1
"""The pelvis of an adult goes down for feet that are no higher than this."""
_EVEN_S = 0.1
"""Over such times the pelvis goes down."""
_HINGE = 0.15
"""How much the hinge of the knee counts against the bend that is seen (a sine)."""
_PREBENT = 0.35
"""Angle, rad, to which a knee is bent before it is solved: its direction is then known."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scale:
    """How places of the source become places of the target.

    Attributes:
        factor: lengths of the target's legs by those of the source's.
        point: the part of the foot that is kept in place: ``toe``, or ``ankle`` without toes.
        low: its height when it stands, source and target, m.
    """

    factor: float
    point: str
    low: tuple[float, float]

    def place(self, places: Float[np.ndarray, "*b 3"]) -> Float[np.ndarray, "*b 3"]:
        """Places of the target for those of the source: scaled over the floor."""
        scaled = places * self.factor
        scaled[..., 1] = (places[..., 1] - self.low[0]) * self.factor + self.low[1]
        return scaled


def scale_of(source: Body, target: Body, places: Float[np.ndarray, "F S 3"]) -> Scale:
    """The scale from one body to another; heights that were not seen are those of ``places``."""
    toes = all(f"{s}_toe" in b.roles for s in SIDES for b in (source, target))
    point = "toe" if toes else "ankle"
    factor = target.leg_length(point) / source.leg_length(point)
    low = source.heights.get(point)
    if low is None:
        feet = [source.roles[f"{side}_{point}"] for side in SIDES]
        low = float(np.quantile(places[:, feet, 1].min(axis=1), 0.05))
    return Scale(factor=factor, point=point, low=(low, target.heights.get(point, low * factor)))


def planted_feet(
    source: Body, scale: Scale, places: Float[np.ndarray, "F S 3"], frame_rate: float
) -> Bool[np.ndarray, "F 2"]:
    """In which frames the source's left and right foot stand."""
    feet = [source.roles[f"{side}_{scale.point}"] for side in SIDES]
    size = body_scale(source.skeleton)
    height = max(scale.low[0], 0.0) / size + PLANT_HEIGHT_M
    return np.asarray(planted(places[:, feet], frame_rate, scale=size, height=height))


def stand(
    source: Body,
    target: Body,
    scale: Scale,
    places: Float[np.ndarray, "F S 3"],
    turns: Float[np.ndarray, "F S 4"],
    local: Float[np.ndarray, "F J 4"],
    frame_rate: float,
) -> tuple[Float[np.ndarray, "F 3"], Float[np.ndarray, "F J 4"]]:
    """Puts the target's feet where the source's are, and its pelvis over them.

    The middle of the hips goes where the source's goes, scaled; lower where a foot near the floor
    would be out of reach, as far as the source bends its legs. Then two-bone inverse kinematics
    puts the feet in place; they keep their orientation, and knees bend about their hinges.

    Args:
        source, target, scale: the bodies.
        places, turns: of the source's joints in the world.
        local: rotations of the target's joints. The legs' are changed.
        frame_rate: frames per second.

    Returns:
        Place of the root and local rotations.
    """
    skeleton = target.skeleton
    there, world = (np.asarray(x) for x in forward(skeleton, np.zeros((len(local), 3)), local))
    hips = [target.roles[f"{side}_hip"] for side in SIDES]
    middle = places[:, [source.roles["left_hip"], source.roles["right_hip"]]].mean(axis=1)
    root = scale.place(middle) - there[:, hips].mean(axis=1)
    on = planted_feet(source, scale, places, frame_rate)
    size = body_scale(skeleton)
    goals, reach, needs = [], [], []
    for side, name in enumerate(SIDES):
        hip, ankle, foot = (target.roles[f"{name}_{p}"] for p in ("hip", "ankle", scale.point))
        path = scale.place(places[:, source.roles[f"{name}_{scale.point}"]])
        path = held_still(path, on[:, side], frame_rate, size)
        goals.append(path - (there[:, foot] - there[:, ankle]))
        reach.append(_reach(source, target, name, places))
        near = np.clip(1 - (path[:, 1] - scale.low[1]) / (size * _NEAR_FLOOR_M), 0.0, 1.0)
        needs.append(near * _too_high(root + there[:, hip], goals[-1], reach[-1]))
    root[:, 1] -= _evened(np.maximum(*needs), frame_rate)
    local = local.copy()
    for name, goal, allowed in zip(SIDES, goals, reach, strict=True):
        hip = f"{name}_hip"
        hinge = quaternion.rotate(turns[:, source.roles[hip]], source.hinge(hip)[None])
        chain = tuple(target.roles[f"{name}_{part}"] for part in ("hip", "knee", "ankle"))
        leg = [there[:, j] + root for j in chain]
        new = _solved(leg, goal, allowed, np.asarray(hinge), world, chain, skeleton.parents)
        for joint, turn in zip(chain, new, strict=True):
            local[:, joint] = turn
    return root, np.asarray(quaternion.normalise(local))


def _reach(source: Body, target: Body, side: str, places: np.ndarray) -> np.ndarray:
    """[F] largest distance from hip to ankle of the target, m: as stretched as the source."""
    hip, knee, ankle = (places[:, source.roles[f"{side}_{p}"]] for p in ("hip", "knee", "ankle"))
    bones = np.linalg.norm(knee - hip, axis=-1) + np.linalg.norm(ankle - knee, axis=-1)
    share = np.linalg.norm(ankle - hip, axis=-1) / np.maximum(bones, 1e-9)
    own = leg_bones(target, side)
    return np.clip(share, _BENT, _STRAIGHT) * own


def leg_bones(body: Body, side: str) -> float:
    """Distance from hip to knee and from knee to ankle, m."""
    total = 0.0
    offsets = np.asarray(body.skeleton.offsets, np.float64)
    for top, joint in (("hip", "knee"), ("knee", "ankle")):
        way, at = np.zeros(3), body.roles[f"{side}_{joint}"]
        while at != body.roles[f"{side}_{top}"]:
            way += offsets[at]
            at = body.skeleton.parents[at]
        total += float(np.linalg.norm(way))
    return total


def _too_high(hip: np.ndarray, ankle: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """[F] how far a hip has to go down until an ankle is within reach, m."""
    away = hip - ankle
    flat = np.minimum(away[:, 0] ** 2 + away[:, 2] ** 2, 0.9 * reach**2)
    return np.maximum(away[:, 1] - np.sqrt(reach**2 - flat), 0.0)


def _evened(drop: np.ndarray, frame_rate: float) -> np.ndarray:
    """At least the drop that is needed, nearly everywhere, without jerks."""
    width = max(1, round(_EVEN_S * frame_rate))
    widest = maximum_filter1d(drop, 2 * width + 1, mode="nearest")
    return np.asarray(gaussian_filter1d(widest, 0.5 * width, mode="nearest", truncate=2.0))


def _solved(
    leg: list[np.ndarray],
    goal: np.ndarray,
    reach: np.ndarray,
    hinge: np.ndarray,
    world: np.ndarray,
    chain: tuple[int, ...],
    parents: tuple[int, ...],
) -> tuple[np.ndarray, ...]:
    """Local rotations of hip, knee and ankle that put the ankle at a goal within reach.

    The knee bends in the plane of the pose, drawn to that of its hinge the more the straighter it
    is: noise of a straight leg cannot turn it round.
    """
    hip, knee, ankle = leg
    thigh, shin = _unit(knee - hip), ankle - knee
    length = np.linalg.norm(shin, axis=-1, keepdims=True)
    across = np.cross(thigh, shin / length) + _HINGE * hinge
    across = _unit(across - (across * thigh).sum(-1, keepdims=True) * thigh)
    bend = np.asarray(quaternion.from_axis_angle(across, np.full(len(hip), _PREBENT)))
    bent = np.asarray(quaternion.rotate(bend, thigh)) * length
    to_bent = np.asarray(quaternion.from_two_vectors(shin, bent))
    away = goal - hip
    distance = np.linalg.norm(away, axis=-1, keepdims=True)
    goal = hip + away * np.minimum(1.0, reach[:, None] / np.maximum(distance, 1e-9))
    hip_turn, knee_turn = two_bone.solve(hip, knee, knee + bent, goal, across)
    above = [world[:, parents[j]] for j in chain]
    turns = [world[:, j] for j in chain]
    new = two_bone.local_rotations(
        hip_turn,
        quaternion.multiply(knee_turn, to_bent),
        (above[0], above[1], above[2]),
        (turns[0], turns[1], turns[2]),
    )
    return tuple(np.asarray(q) for q in new)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-9)
