"""What motions show of the skeleton that they move: axes of knees and elbows, flat feet, soles.

Where a rest pose says nothing (all bones along one axis, feet that point down), motion does: a knee
bends about its axis, and a foot that stands is flat.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from mgjax.core import quaternion
from mgjax.core.body.height import body_scale
from mgjax.core.body.roles import SIDES
from mgjax.core.contacts import PLANT_SPEED_M_S
from mgjax.core.kinematics import forward, joint_velocities
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton, rest_positions

LIMBS = {
    f"{side}_{joints[0]}": tuple(f"{side}_{part}" for part in joints)
    for side in SIDES
    for joints in (("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist"))
}
"""The three joints of each limb, by the first."""
_BENT = np.sin(np.radians(15.0))
"""A limb that is straighter says nothing of the axis about which it bends."""
_FRAMES = 10
"""As many frames at least must show what is believed."""
_AGREE = 0.8
"""Length of the mean of the axes seen, above which the joint is a hinge."""
_LOW_M = 0.03
"""An adult's foot that stands is no higher over its lowest place (5 % of the frames are lower)."""


@dataclass(frozen=True, kw_only=True)
class Shown:
    """What motions show; a role that is missing was not seen well enough.

    Attributes:
        hinges: unit axis about which knee or elbow bends, in the frame of the role's joint: of
            ``left_hip`` that of the thigh, of ``left_knee`` that of the shin.
        flat: rotation of a foot that stands flat and points along +Z, by ``left_ankle``,
            ``left_toe``, …
        against: by joint, its mean rotation against another.
        heights: height of balls of the feet (``toe``) and of ankles when they stand, m.
    """

    hinges: dict[str, np.ndarray] = field(default_factory=dict)
    flat: dict[str, np.ndarray] = field(default_factory=dict)
    against: dict[int, np.ndarray] = field(default_factory=dict)
    heights: dict[str, float] = field(default_factory=dict)


def look_at(
    skeleton: Skeleton,
    roles: dict[str, int],
    motions: Iterable[Motion],
    pairs: Mapping[int, int] | None = None,
) -> Shown:
    """Gathers what all motions of one skeleton show together.

    ``pairs``: the joints of :attr:`Shown.against`, with the joints against which they turn.
    """
    axes: dict[str, list[tuple[np.ndarray, float, int]]] = {}
    feet: dict[str, list[np.ndarray]] = {}
    against: dict[int, list[np.ndarray]] = {}
    heights: dict[str, list[float]] = {}
    for motion in motions:
        places, turns = (
            np.asarray(x)
            for x in forward(
                skeleton,
                np.asarray(motion.root_translation, np.float64),
                np.asarray(motion.local_rotations, np.float64),
            )
        )
        for limb in LIMBS.values():
            if roles.keys() >= set(limb):
                for role, seen in zip(limb, _axes(places, turns, roles, limb), strict=False):
                    axes.setdefault(role, []).append(seen)
        for joint, other in (pairs or {}).items():
            turn = np.asarray(quaternion.multiply(_inverse(turns[:, other]), turns[:, joint]))
            against.setdefault(joint, []).append(turn)
        for point in ("toe", "ankle"):
            joints = [roles[f"{s}_{point}"] for s in SIDES if f"{s}_{point}" in roles]
            if joints:
                low = np.quantile(places[:, joints, 1].min(axis=1), 0.05)
                heights.setdefault(point, []).append(float(low))
        for side in SIDES:
            _see_foot(skeleton, roles, side, places, turns, motion.frame_rate, feet)
    return Shown(
        hinges={role: axis for role, seen in axes.items() if (axis := _agreed(seen)) is not None},
        flat={role: mean_turn(np.concatenate(q)) for role, q in feet.items() if _enough(q)},
        against={j: mean_turn(np.concatenate(q)) for j, q in against.items() if _enough(q)},
        heights={point: float(np.median(low)) for point, low in heights.items()},
    )


def mean_turn(turns: np.ndarray) -> np.ndarray:
    """The mean of quaternions [F,4]: the main axis of their outer products."""
    return np.linalg.eigh(turns.T @ turns)[1][:, -1]


def tip(skeleton: Skeleton, roles: dict[str, int], role: str) -> int | None:
    """The joint towards which the bone of an ankle or toe points, or None."""
    joint = roles.get(role)
    if joint is None:
        return None
    if role.endswith("ankle") and (toe := roles.get(role.replace("ankle", "toe"))) is not None:
        return toe
    offsets = np.asarray(skeleton.offsets)
    below = [j for j, p in enumerate(skeleton.parents) if p == joint]
    return next((j for j in below if np.linalg.norm(offsets[j]) > 1e-3), None)


def _axes(
    places: np.ndarray, turns: np.ndarray, roles: dict[str, int], limb: tuple[str, ...]
) -> list[tuple[np.ndarray, float, int]]:
    """Sum of the normals of the bent limb in the frames of its two bones, their length, frames."""
    a, b, c = (places[:, roles[role]] for role in limb)
    normals = np.cross(_unit(b - a), _unit(c - b))
    bent = np.linalg.norm(normals, axis=1)
    rows = bent > _BENT
    return [
        (
            np.asarray(quaternion.rotate(_inverse(turns[rows, roles[role]]), normals[rows])).sum(0),
            float(bent[rows].sum()),
            int(rows.sum()),
        )
        for role in limb[:2]
    ]


def _agreed(seen: list[tuple[np.ndarray, float, int]]) -> np.ndarray | None:
    total, length = sum((s for s, _, _ in seen), np.zeros(3)), sum(n for _, n, _ in seen)
    if sum(count for _, _, count in seen) < _FRAMES or np.linalg.norm(total) < _AGREE * length:
        return None
    return total / np.linalg.norm(total)


def _see_foot(
    skeleton: Skeleton,
    roles: dict[str, int],
    side: str,
    places: np.ndarray,
    turns: np.ndarray,
    frame_rate: float,
    feet: dict[str, list[np.ndarray]],
) -> None:
    """Adds the rotations of one foot while it stands flat, without its direction on the floor."""
    ankle = roles.get(f"{side}_ankle")
    if ankle is None:
        return
    path = places[:, ankle]
    speed = np.linalg.norm(np.asarray(joint_velocities(path[:, None], frame_rate))[:, 0], axis=-1)
    scale = body_scale(skeleton)
    low = np.quantile(path[:, 1], 0.05) + scale * _LOW_M
    stands = (speed < scale * PLANT_SPEED_M_S) & (path[:, 1] < low)
    if not stands.any():
        return
    rest = rest_positions(skeleton)
    for role in (f"{side}_ankle", f"{side}_toe"):
        end = tip(skeleton, roles, role)
        if end is None:
            continue
        turn = turns[stands, roles[role]]
        bone = np.asarray(quaternion.rotate(turn, (rest[end] - rest[roles[role]])[None]))
        feet.setdefault(role, []).append(
            np.asarray(quaternion.multiply(_inverse(heading(bone)), turn))
        )


def heading(direction: np.ndarray) -> np.ndarray:
    """Turn about +Y that brings +Z to where a direction [..., 3] points on the floor."""
    return np.asarray(quaternion.from_yaw(np.arctan2(direction[..., 0], direction[..., 2])))


def _enough(turns: list[np.ndarray]) -> bool:
    return sum(len(q) for q in turns) >= _FRAMES


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-9)


def _inverse(q: np.ndarray) -> np.ndarray:
    return np.asarray(quaternion.conjugate(q))
