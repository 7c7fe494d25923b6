"""A body to be retargeted: which joint is which, what its axes mean, and how long its legs are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from mgjax.clips.retarget.axes import ANATOMY, anatomical_axes, loose_joints
from mgjax.clips.retarget.shown import look_at
from mgjax.core import quaternion
from mgjax.core.body.height import tree_of
from mgjax.core.body.roles import SIDES, find_roles, require_roles
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton, rest_positions

NEEDED = tuple(f"{side}_{part}" for side in SIDES for part in ("hip", "knee", "ankle"))


@dataclass(frozen=True, kw_only=True, eq=False)
class Body:
    """A skeleton with a standing rest pose, and what its joints mean.

    Attributes:
        skeleton: its bones.
        roles: which joint is which.
        pelvis: the joint on which legs and trunk hang.
        known: by joint, the rotation from anatomical axes to those of the joint, wxyz.
        thigh_and_shin: from hip to ankle along the bones, mean of both legs, m.
        heights: of ``toe`` and ``ankle`` over the floor when they stand, m, where it was seen.
    """

    skeleton: Skeleton
    roles: dict[str, int]
    pelvis: int
    known: dict[int, np.ndarray]
    thigh_and_shin: float
    heights: dict[str, float]

    def axes(self, joint: int) -> np.ndarray:
        """Rotation from anatomical axes to a joint's; without own ones those of what it is on."""
        while joint not in self.known:
            joint = self.skeleton.parents[joint] if joint else self.pelvis
        return self.known[joint]

    def hinge(self, role: str) -> np.ndarray:
        """The axis about which the limb that begins at a role bends, in the axes of that joint."""
        return np.asarray(quaternion.rotate(self.axes(self.roles[role]), ANATOMY[role][1]))

    def leg_length(self, point: str) -> float:
        """From the hips straight down to the ankles or the balls (``toe``) of the feet, m."""
        if point == "ankle":
            return self.thigh_and_shin
        rest = rest_positions(self.skeleton)
        drops: list[float] = []
        for side in SIDES:
            ankle, toe = self.roles[f"{side}_ankle"], self.roles[f"{side}_toe"]
            flat = np.asarray(quaternion.conjugate(self.axes(ankle)))
            drops.append(-float(quaternion.rotate(flat, rest[toe] - rest[ankle])[1]))
        return self.thigh_and_shin + float(np.mean(drops))


def make_body(skeleton: Skeleton, motions: Iterable[Motion] = ()) -> Body:
    """A body from its skeleton, with a rest pose that stands, and motions of it.

    Raises:
        SkeletonError: it has no legs; the joint that is missing is named.
    """
    require_roles(skeleton, NEEDED)
    roles, tree = find_roles(skeleton), tree_of(skeleton)
    carried = [roles["left_hip"], roles["right_hip"]]
    pelvis = tree.common([*carried, roles["chest"]] if "chest" in roles else carried)
    shown = look_at(skeleton, roles, motions, loose_joints(tree, roles, pelvis))
    legs = [tree.distance(roles[f"{s}_hip"], roles[f"{s}_ankle"]) for s in SIDES]
    return Body(
        skeleton=skeleton,
        roles=roles,
        pelvis=pelvis,
        known=anatomical_axes(skeleton, tree, roles, pelvis, shown),
        thigh_and_shin=float(np.mean(legs)),
        heights=shown.heights,
    )
