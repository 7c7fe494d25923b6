"""The body as capsules along its bones: distances to points and bars, and of an arm to the rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.core.skeleton import Skeleton, find_role
from mgjax.hybrid.ik.limbs import LIMBS, find_limb

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
"""Of an adult of 1.75 m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Body:
    """Capsules.

    Attributes:
        joints: the two joints at the ends of each. [B, 2]
        radii: m. [B]
        parts: a name of each, such as ``"torso"``.
        limbs: the limb that each belongs to from its shoulder on, or "". The head has none.
    """

    joints: Int[np.ndarray, "B 2"]
    radii: Float[np.ndarray, " B"]
    parts: tuple[str, ...]
    limbs: tuple[str, ...]

    def ends(self, positions: Float[np.ndarray, "F J 3"]) -> tuple[np.ndarray, np.ndarray]:
        """[F, B, 3] both ends of each capsule."""
        return positions[:, self.joints[:, 0]], positions[:, self.joints[:, 1]]


def body_of(skeleton: Skeleton) -> Body:
    """The capsules of a skeleton: one for each bone longer than 1 cm, by what its joints are."""
    lengths = np.linalg.norm(np.asarray(skeleton.offsets, np.float64), axis=-1)
    kinds = _kinds(skeleton)
    rows = [
        (parent, joint, *kinds[joint])
        for joint, parent in enumerate(skeleton.parents)
        if parent >= 0 and lengths[joint] > 0.01
    ]
    return Body(
        joints=np.array([row[:2] for row in rows]),
        radii=np.array([_RADII_M[row[2]] for row in rows]),
        parts=tuple(row[2] for row in rows),
        limbs=tuple(row[3] for row in rows),
    )


def _kinds(skeleton: Skeleton) -> list[tuple[str, str]]:
    """Part and limb of the bone that ends in each joint."""
    marks: dict[int, tuple[str, str]] = {}  # what hangs on these joints
    arms = [find_limb(skeleton, name) for name in LIMBS if name != "head"]
    for limb in arms:
        side = limb.name.split("_")[0]
        shared = [j for j in limb.joints if j in arms[0].joints and j in arms[1].joints]
        marks |= dict.fromkeys(shared, ("torso", ""))
        shoulder = find_role(skeleton, f"{side}_shoulder") or limb.joints[-1]
        before = [j for j in limb.joints if j < shoulder and j not in marks]
        marks |= dict.fromkeys(before, ("shoulder", ""))
        names = (("shoulder", "upper arm"), ("elbow", "forearm"), ("wrist", "hand"))
        marks |= {
            j: (part, limb.name)
            for role, part in names
            if (j := find_role(skeleton, f"{side}_{role}")) is not None
        }
        legs = (("hip", "thigh"), ("knee", "shin"), ("ankle", "foot"))
        marks |= {
            j: (part, "")
            for role, part in legs
            if (j := find_role(skeleton, f"{side}_{role}")) is not None
        }
    head = find_limb(skeleton, "head")
    marks |= {j: ("neck", "") for j in head.joints if j not in marks}
    marks[head.joints[-1]] = ("head", "")
    marks[0] = ("pelvis", "")
    kinds: list[tuple[str, str]] = [("pelvis", "")]
    hanging = [("pelvis", "")] * skeleton.num_joints
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            kinds.append(hanging[parent])
            hanging[joint] = hanging[parent]
            if joint in head.joints and hanging[parent][0] == "pelvis":
                kinds[joint] = ("torso", "")
        hanging[joint] = marks.get(joint, hanging[joint])
    return kinds


def to_points(
    body: Body, positions: Float[np.ndarray, "F J 3"], points: Float[np.ndarray, "F 3"]
) -> Float[np.ndarray, "F B"]:
    """Distance of a point in each frame to the surface of each capsule, m; negative inside."""
    a, b = body.ends(positions)
    way = b - a
    share = np.einsum("fbi,fbi->fb", points[:, None] - a, way) / (way * way).sum(axis=-1)
    near = a + np.clip(share, 0, 1)[..., None] * way
    return np.linalg.norm(points[:, None] - near, axis=-1) - body.radii


def to_bar(
    body: Body, positions: Float[np.ndarray, "F J 3"], ends: Float[np.ndarray, "2 3"], radius: float
) -> Float[np.ndarray, " F"]:
    """Distance of the whole body's surface to that of a bar in each frame, m; negative inside."""
    a, b = body.ends(positions)
    from_to = segment_distance(a, b, np.broadcast_to(ends[0], a.shape), ends[1] - ends[0] + 0 * a)
    return (from_to - body.radii).min(axis=1) - radius


def arm_clearance(
    body: Body, positions: Float[np.ndarray, "F J 3"], limb: str
) -> Float[np.ndarray, " F"]:
    """Distance of a limb's forearm and hand to torso, pelvis and head, m; negative inside."""
    pairs = zip(body.parts, body.limbs, strict=True)
    arm = [i for i, (part, x) in enumerate(pairs) if x == limb and part in ("forearm", "hand")]
    rest = [i for i, part in enumerate(body.parts) if part in ("torso", "pelvis", "head", "neck")]
    a, b = body.ends(positions)
    frames, shape = len(positions), (len(positions), len(arm), len(rest), 3)
    p, q = (np.broadcast_to(x[:, arm, None], shape) for x in (a, b))
    r, s = (np.broadcast_to(x[:, None, rest], shape) for x in (a, b))
    apart = segment_distance(p, q, r, s - r)
    apart = apart - body.radii[arm][:, None] - body.radii[rest]
    return apart.reshape(frames, -1).min(axis=1)


def segment_distance(
    a: Float[np.ndarray, "*b 3"],
    b: Float[np.ndarray, "*b 3"],
    c: Float[np.ndarray, "*b 3"],
    way: Float[np.ndarray, "*b 3"],
) -> Float[np.ndarray, "*b"]:
    """Distance of the segments a … b and c … c + way, of lengths above 0.

    The nearest points lie inside both, or one of them is an end.
    """
    u, v, w = b - a, way, a - c
    uu, uv, vv = ((x * y).sum(axis=-1) for x, y in ((u, u), (u, v), (v, v)))
    uw, vw = ((x * w).sum(axis=-1) for x in (u, v))
    free = np.maximum(uu * vv - uv * uv, 1e-12)
    s = np.clip((uv * vw - vv * uw) / free, 0.0, 1.0)
    t = np.clip((uv * s + vw) / vv, 0.0, 1.0)
    s = np.clip((uv * t - uw) / uu, 0.0, 1.0)
    return np.linalg.norm(w + s[..., None] * u - t[..., None] * v, axis=-1)
