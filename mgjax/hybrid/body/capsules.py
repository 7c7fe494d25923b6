"""The body as capsules along its bones: distances to points and bars, and of an arm to the rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from jaxtyping import Float, Int

from mgjax.core.body.height import body_scale
from mgjax.core.body.roles import find_role
from mgjax.core.skeleton import Skeleton
from mgjax.hybrid.ik.limbs import ARMS, HEAD, LimbType, find_limb

_RADII_M = {
    "torso": 0.11,
    "shoulder": 0.05,
    "neck": 0.05,
    "head": 0.09,
    "upper arm": 0.045,
    "forearm": 0.04,
    "hand": 0.03,
    "pelvis": 0.10,
    "thigh": 0.075,
    "shin": 0.055,
    "foot": 0.04,
}
"""Radii of the parts of an adult."""
_FORE = ("forearm", "hand")
"""Parts of an arm that may come near the rest of the body."""
_REST = ("torso", "pelvis", "head", "neck")
"""Parts that they are kept away from."""

_Part: TypeAlias = tuple[str, LimbType | None]
"""Name of a part, and the limb that it belongs to."""
_PELVIS: _Part = ("pelvis", None)


@dataclass(frozen=True, kw_only=True, eq=False)
class Capsules:
    """The surface of a body, as capsules along its bones.

    Attributes:
        joints: the two joints at the ends of each. [B, 2]
        radii: m. [B]
        parts: a name of each, such as ``"torso"``.
        limbs: the arm that each belongs to from its shoulder on, or None. The head has none.
    """

    joints: Int[np.ndarray, "B 2"]
    radii: Float[np.ndarray, " B"]
    parts: tuple[str, ...]
    limbs: tuple[LimbType | None, ...]

    def ends(self, positions: Float[np.ndarray, "F J 3"]) -> tuple[np.ndarray, np.ndarray]:
        """[F, B, 3] both ends of each capsule."""
        return positions[:, self.joints[:, 0]], positions[:, self.joints[:, 1]]


def make_capsules(skeleton: Skeleton) -> Capsules:
    """The capsules of a skeleton: one for each bone longer than 1 cm, by what its joints are.

    Both lengths are those of an adult.
    """
    scale = body_scale(skeleton)
    lengths = np.linalg.norm(np.asarray(skeleton.offsets, np.float64), axis=-1)
    parts = _bone_parts(skeleton)
    rows = [
        (parent, joint, *parts[joint])
        for joint, parent in enumerate(skeleton.parents)
        if parent >= 0 and lengths[joint] > 0.01 * scale
    ]
    return Capsules(
        joints=np.array([row[:2] for row in rows]),
        radii=scale * np.array([_RADII_M[row[2]] for row in rows]),
        parts=tuple(row[2] for row in rows),
        limbs=tuple(row[3] for row in rows),
    )


def _bone_parts(skeleton: Skeleton) -> list[_Part]:
    """Part and limb of the bone that ends in each joint."""
    marks = _marked_joints(skeleton)
    head = find_limb(skeleton, HEAD.name)
    parts: list[_Part] = [_PELVIS]
    hanging = [_PELVIS] * skeleton.num_joints
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            parts.append(hanging[parent])
            hanging[joint] = hanging[parent]
            if joint in head.joints and hanging[parent] == _PELVIS:
                parts[joint] = ("torso", None)
        hanging[joint] = marks.get(joint, hanging[joint])
    return parts


def _marked_joints(skeleton: Skeleton) -> dict[int, _Part]:
    """Part and limb of what hangs on these joints."""
    marks: dict[int, _Part] = {}
    arms = [(arm, find_limb(skeleton, arm.name).joints) for arm in ARMS]
    shared = set(arms[0][1]) & set(arms[1][1])
    for arm, joints in arms:
        marks |= dict.fromkeys((j for j in joints if j in shared), ("torso", None))
        shoulder = find_role(skeleton, arm.role("shoulder")) or joints[-1]
        before = [j for j in joints if j < shoulder and j not in marks]
        marks |= dict.fromkeys(before, ("shoulder", None))
        for role, part, limb in (
            ("shoulder", "upper arm", arm),
            ("elbow", "forearm", arm),
            ("wrist", "hand", arm),
            ("hip", "thigh", None),
            ("knee", "shin", None),
            ("ankle", "foot", None),
        ):
            joint = find_role(skeleton, arm.role(role))
            if joint is not None:
                marks[joint] = (part, limb)
    head = find_limb(skeleton, HEAD.name)
    marks |= {j: ("neck", None) for j in head.joints if j not in marks}
    marks[head.joints[-1]] = ("head", None)
    marks[0] = _PELVIS
    return marks


def to_points(
    capsules: Capsules, positions: Float[np.ndarray, "F J 3"], points: Float[np.ndarray, "F 3"]
) -> Float[np.ndarray, "F B"]:
    """Distance of a point in each frame to the surface of each capsule, m; negative inside."""
    a, b = capsules.ends(positions)
    axis = b - a
    share = np.einsum("fbi,fbi->fb", points[:, None] - a, axis) / (axis * axis).sum(axis=-1)
    near = a + np.clip(share, 0, 1)[..., None] * axis
    return np.linalg.norm(points[:, None] - near, axis=-1) - capsules.radii


def to_bar(
    capsules: Capsules,
    positions: Float[np.ndarray, "F J 3"],
    ends: Float[np.ndarray, "2 3"],
    radius: float,
) -> Float[np.ndarray, " F"]:
    """Distance of the whole body's surface to that of a bar in each frame, m; negative inside."""
    a, b = capsules.ends(positions)
    from_to = segment_distance(a, b, np.broadcast_to(ends[0], a.shape), ends[1] - ends[0] + 0 * a)
    return (from_to - capsules.radii).min(axis=1) - radius


def arm_clearance(
    capsules: Capsules, positions: Float[np.ndarray, "F J 3"], limb: LimbType
) -> Float[np.ndarray, " F"]:
    """Distance of an arm's forearm and hand to torso, pelvis and head, m; negative inside."""
    pairs = zip(capsules.parts, capsules.limbs, strict=True)
    arm = [i for i, (part, x) in enumerate(pairs) if x == limb and part in _FORE]
    rest = [i for i, part in enumerate(capsules.parts) if part in _REST]
    a, b = capsules.ends(positions)
    frames, shape = len(positions), (len(positions), len(arm), len(rest), 3)
    p, q = (np.broadcast_to(x[:, arm, None], shape) for x in (a, b))
    r, s = (np.broadcast_to(x[:, None, rest], shape) for x in (a, b))
    distance = segment_distance(p, q, r, s - r)
    distance = distance - capsules.radii[arm][:, None] - capsules.radii[rest]
    return distance.reshape(frames, -1).min(axis=1)


def segment_distance(
    a: Float[np.ndarray, "*b 3"],
    b: Float[np.ndarray, "*b 3"],
    c: Float[np.ndarray, "*b 3"],
    axis: Float[np.ndarray, "*b 3"],
) -> Float[np.ndarray, "*b"]:
    """Distance of the segments a … b and c … c + axis, of lengths above 0.

    The nearest points lie inside both, or one of them is an end.
    """
    u, v, w = b - a, axis, a - c
    uu, uv, vv = ((x * y).sum(axis=-1) for x, y in ((u, u), (u, v), (v, v)))
    uw, vw = ((x * w).sum(axis=-1) for x in (u, v))
    free = np.maximum(uu * vv - uv * uv, 1e-12)
    s = np.clip((uv * vw - vv * uw) / free, 0.0, 1.0)
    t = np.clip((uv * s + vw) / vv, 0.0, 1.0)
    s = np.clip((uv * t - uw) / uu, 0.0, 1.0)
    return np.linalg.norm(w + s[..., None] * u - t[..., None] * v, axis=-1)
