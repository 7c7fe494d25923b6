"""Limbs: the chains of joints from the root to the hands and to the head."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Literal

import numpy as np

from mgjax.core.body.roles import find_role
from mgjax.core.errors import SkeletonError
from mgjax.core.skeleton import Skeleton


class LimbKind(Enum):
    """What a limb is made of, and so how it moves and what it may touch."""

    ARM = "arm"
    HEAD = "head"


@dataclass(frozen=True, kw_only=True)
class LimbType:
    """A limb of any body: all that is said of a limb by its name stands here.

    Attributes:
        name: of the limb, as targets give it.
        kind: arm or head.
        side: of the body; "" for the middle.
        sign: +1 on the left, where the body's own x grows, −1 on the right, 0 in the middle.
        ends: roles of the joint at its end; the first that a skeleton has.
        colour: in pictures.
    """

    name: str
    kind: LimbKind
    side: Literal["left", "right", ""]
    sign: float
    ends: tuple[str, ...]
    colour: str

    def role(self, part: str) -> str:
        """The role of one of its joints, such as ``left_elbow`` for ``"elbow"``."""
        return f"{self.side}_{part}" if self.side else part


def _arm(side: Literal["left", "right"], sign: float, colour: str) -> LimbType:
    """An arm ends where its fingers begin, or at the wrist of a skeleton without fingers."""
    return LimbType(
        name=f"{side}_hand",
        kind=LimbKind.ARM,
        side=side,
        sign=sign,
        ends=(f"{side}_hand", f"{side}_wrist"),
        colour=colour,
    )


ARMS = (_arm("right", -1.0, "#e67e22"), _arm("left", 1.0, "#8e44ad"))
"""Right hand → root, left hand → root (Kalouache & Cherif, Fig. 5)."""

HEAD = LimbType(
    name="head", kind=LimbKind.HEAD, side="", sign=0.0, ends=("head",), colour="#16a085"
)
"""Root → head (Kalouache & Cherif, Fig. 5)."""

LIMB_TYPES = {kind.name: kind for kind in (*ARMS, HEAD)}
"""All limbs by name."""

LIMBS = tuple(LIMB_TYPES)
"""Names of the limbs that can reach: right hand, left hand and head."""


@dataclass(frozen=True, kw_only=True)
class Limb:
    """One chain of a skeleton.

    The pelvis belongs to the legs: the root is not turned, and the chain's fixed base is the first
    joint below it. Where that joint has no offset, as in CMU's skeletons, it is where the root is.

    Attributes:
        name: one of :data:`LIMBS`.
        joints: indices from the base to the end, each the parent of the next.
        reach_m: sum of the bone lengths, m.
    """

    name: str
    joints: tuple[int, ...]
    reach_m: float

    @property
    def type(self) -> LimbType:
        """What is known of the limb by its name."""
        return LIMB_TYPES[self.name]

    @property
    def is_arm(self) -> bool:
        """Whether it ends in a hand."""
        return self.type.kind is LimbKind.ARM


def find_limb(skeleton: Skeleton, name: str) -> Limb:
    """The chain that ends in ``right_hand``, ``left_hand`` or ``head``.

    A hand ends where its fingers begin, or at the wrist of a skeleton without fingers; the head
    at its joint.

    Raises:
        SkeletonError: an unknown limb, or a skeleton without it.
    """
    if name not in LIMB_TYPES:
        raise SkeletonError(f"limb is {name!r}, expected one of {', '.join(LIMBS)}")
    joints = _chain(skeleton, LIMB_TYPES[name])
    if not joints:
        raise SkeletonError(f"found no joint for {name!r} among {', '.join(skeleton.names)}")
    if len(joints) == 1:
        raise SkeletonError(f"the {name!r} of the skeleton hangs on its root, expected a chain")
    lengths = np.linalg.norm(np.asarray(skeleton.offsets, np.float64)[list(joints[1:])], axis=-1)
    return Limb(name=name, joints=joints, reach_m=float(lengths.sum()))


def orientation_locked(skeleton: Skeleton, limbs: Sequence[Limb]) -> tuple[int, ...]:
    """Joints that keep their orientation in the world while ``limbs`` move.

    A reaching hand turns the torso, and with it the other arm and the head. Where these have no
    target, the joints at which they branch off keep their world orientation: the arm goes on
    swinging and the eyes look on as captured, carried along by the torso. So does the head at the
    end of its own chain. All other joints, such as fingers, follow the joint they hang on.
    """
    moved = {joint for limb in limbs for joint in limb.joints}
    named = {limb.name for limb in limbs}
    locked = {limb.joints[-1] for limb in limbs if not limb.is_arm}
    for name, limb_type in LIMB_TYPES.items():
        if name not in named:
            other = _chain(skeleton, limb_type)
            locked |= {j for j in other if j not in moved and skeleton.parents[j] in moved}
    return tuple(sorted(locked))


steady_joints = orientation_locked
"""Public name of :func:`orientation_locked`."""


def _chain(skeleton: Skeleton, limb_type: LimbType) -> tuple[int, ...]:
    """Joints from below the root to the end of a limb; none where the skeleton has no such end."""
    candidates = (find_role(skeleton, role) for role in limb_type.ends)
    joint = next((j for j in candidates if j is not None), 0)
    joints: list[int] = []
    while joint > 0:
        joints.insert(0, joint)
        joint = skeleton.parents[joint]
    return tuple(joints)
