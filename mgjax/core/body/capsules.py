"""The body as capsules along its bones: distances to points and bars, and of an arm to the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from jaxtyping import Float, Int

from mgjax.core.arrays import Array, namespace
from mgjax.core.body.height import body_scale
from mgjax.core.body.roles import SIDES, find_role
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.pytree import register

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
KEPT_OUT = ("torso", "pelvis", "head", "neck")
"""Parts that they are kept away from."""

_Part: TypeAlias = tuple[str, str]
"""Name of a part, and the side of the arm that it belongs to."""
_PELVIS: _Part = ("pelvis", "")


@dataclass(frozen=True, kw_only=True, eq=False)
class Capsules:
    """The surface of a body, as capsules along its bones.

    Attributes:
        joints: the two joints at the ends of each. [B, 2]
        radii: m. [B]
        parts: a name of each, such as ``"torso"``.
        arms: the side of the arm that each belongs to from its shoulder on; "" for the rest.
    """

    joints: Int[np.ndarray, "B 2"]
    radii: Float[np.ndarray, " B"]
    parts: tuple[str, ...]
    arms: tuple[str, ...]

    def ends(
        self, positions: Float[Array, "*f J 3"]
    ) -> tuple[Float[Array, "*f B 3"], Float[Array, "*f B 3"]]:
        """Both ends of each capsule."""
        return positions[..., self.joints[:, 0], :], positions[..., self.joints[:, 1], :]


@register()
@dataclass(frozen=True, kw_only=True, eq=False)
class CapsulePairs:
    """Pairs of capsules.

    Attributes:
        joints: both ends of the first, both ends of the second. [P, 4]
        reach: sum of the two radii, m. [P]
    """

    joints: Int[Array, "P 4"]
    reach: Float[Array, " P"]


def make_capsules(skeleton: Skeleton) -> Capsules:
    """The capsules of a skeleton: one for each bone longer than 1 cm, by what its joints are.

    Both lengths are those of an adult. An arm or a head that is not there has none.
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
        joints=np.array([row[:2] for row in rows], np.int64).reshape(-1, 2),
        radii=scale * np.array([_RADII_M[row[2]] for row in rows]),
        parts=tuple(row[2] for row in rows),
        arms=tuple(row[3] for row in rows),
    )


def _bone_parts(skeleton: Skeleton) -> list[_Part]:
    """Part and limb of the bone that ends in each joint."""
    marks = _marked_joints(skeleton)
    head = _chain(skeleton, ("head",))
    parts: list[_Part] = [_PELVIS]
    hanging = [_PELVIS] * skeleton.num_joints
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            parts.append(hanging[parent])
            hanging[joint] = hanging[parent]
            if joint in head and hanging[parent] == _PELVIS:
                parts[joint] = ("torso", "")
        hanging[joint] = marks.get(joint, hanging[joint])
    return parts


def _chain(skeleton: Skeleton, ends: tuple[str, ...]) -> list[int]:
    """Joints from below the root to the first of these roles that the skeleton has; or none."""
    found = (find_role(skeleton, role) for role in ends)
    joint = next((j for j in found if j is not None), 0)
    joints: list[int] = []
    while joint > 0:
        joints.insert(0, joint)
        joint = skeleton.parents[joint]
    return joints


def _marked_joints(skeleton: Skeleton) -> dict[int, _Part]:
    """Part and side of what hangs on these joints."""
    marks: dict[int, _Part] = {}
    arms = {side: _chain(skeleton, (f"{side}_hand", f"{side}_wrist")) for side in SIDES[::-1]}
    head = _chain(skeleton, ("head",))
    both = [set(joints) for joints in (*arms.values(), head) if joints][:2]
    shared = set.intersection(*both) if len(both) == 2 else set()
    for side, joints in arms.items():
        marks |= dict.fromkeys((j for j in joints if j in shared), ("torso", ""))
        shoulder = find_role(skeleton, f"{side}_shoulder")
        shoulder = shoulder or (joints[-1] if joints else 0)
        before = [j for j in joints if j < shoulder and j not in marks]
        marks |= dict.fromkeys(before, ("shoulder", ""))
        for role, part, arm in (
            ("shoulder", "upper arm", side),
            ("elbow", "forearm", side),
            ("wrist", "hand", side),
            ("hip", "thigh", ""),
            ("knee", "shin", ""),
            ("ankle", "foot", ""),
        ):
            joint = find_role(skeleton, f"{side}_{role}")
            if joint is not None:
                marks[joint] = (part, arm)
    marks |= {j: ("neck", "") for j in head if j not in marks}
    if head:
        marks[head[-1]] = ("head", "")
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
    return (np.asarray(from_to) - capsules.radii).min(axis=1) - radius


def arm_clearance(
    capsules: Capsules, positions: Float[np.ndarray, "F J 3"], side: str
) -> Float[np.ndarray, " F"]:
    """Distance of an arm's forearm and hand to torso, pelvis and head, m; negative inside."""
    pairs = zip(capsules.parts, capsules.arms, strict=True)
    arm = [i for i, (part, x) in enumerate(pairs) if x == side and part in _FORE]
    rest = [i for i, part in enumerate(capsules.parts) if part in KEPT_OUT]
    chosen = capsule_pairs(capsules, [(i, j) for i in arm for j in rest])
    return np.asarray(pair_distances(chosen, positions)).min(axis=1)


def capsule_pairs(capsules: Capsules, pairs: Sequence[tuple[int, int]]) -> CapsulePairs:
    """Pairs of capsules by their numbers."""
    first, second = np.array(pairs, np.int64).reshape(-1, 2).T
    return CapsulePairs(
        joints=np.concatenate([capsules.joints[first], capsules.joints[second]], axis=1),
        reach=capsules.radii[first] + capsules.radii[second],
    )


def pair_distances(pairs: CapsulePairs, positions: Float[Array, "*f J 3"]) -> Float[Array, "*f P"]:
    """Distances of the surfaces of pairs of capsules, m; negative where they meet."""
    a, b, c, d = (positions[..., pairs.joints[:, i], :] for i in range(4))
    middle = segment_distance(a, b, c, d - c)
    reach = namespace(positions, pairs.reach).asarray(pairs.reach, dtype=middle.dtype)
    return middle - reach.reshape((1,) * (middle.ndim - 1) + (-1,))


def segment_distance(
    a: Float[Array, "*b 3"],
    b: Float[Array, "*b 3"],
    c: Float[Array, "*b 3"],
    axis: Float[Array, "*b 3"],
) -> Float[Array, "*b"]:
    """Distance of the segments a … b and c … c + axis, of lengths above 0.

    The nearest points lie inside both, or one of them is an end. Its gradient is finite, also
    where the segments meet.
    """
    xp = namespace(a, b, c, axis)
    s, t = nearest_shares(a, b, c, c + axis)
    between = a - c + s[..., None] * (b - a) - t[..., None] * axis
    return xp.sqrt(xp.maximum(xp.sum(between**2, axis=-1), 1e-20))


def nearest_shares(
    a: Float[Array, "*b 3"],
    b: Float[Array, "*b 3"],
    c: Float[Array, "*b 3"],
    d: Float[Array, "*b 3"],
) -> tuple[Float[Array, "*b"], Float[Array, "*b"]]:
    """Where the segments a … b and c … d, of lengths above 0, are nearest: shares of each."""
    xp = namespace(a, b, c, d)
    u, v, w = b - a, d - c, a - c
    uu, uv, vv = (xp.sum(x * y, axis=-1) for x, y in ((u, u), (u, v), (v, v)))
    uw, vw = (xp.sum(x * w, axis=-1) for x in (u, v))
    free = xp.maximum(uu * vv - uv * uv, 1e-12)
    s = xp.clip((uv * vw - vv * uw) / free, 0.0, 1.0)
    t = xp.clip((uv * s + vw) / vv, 0.0, 1.0)
    return xp.clip((uv * t - uw) / uu, 0.0, 1.0), t
