"""Limbs: the chains of joints from the root to the hands and to the head."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mgjax.core.errors import SkeletonError
from mgjax.core.skeleton import Skeleton, find_role

LIMBS = ("right_hand", "left_hand", "head")
"""Right hand → root, left hand → root, root → head (Kalouache & Cherif, Fig. 5)."""


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


def find_limb(skeleton: Skeleton, name: str) -> Limb:
    """The chain that ends in ``right_hand``, ``left_hand`` or ``head``.

    A hand ends where its fingers begin, or at the wrist of a skeleton without fingers; the head
    at its joint.

    Raises:
        SkeletonError: an unknown limb, or a skeleton without it.
    """
    if name not in LIMBS:
        raise SkeletonError(f"limb is {name!r}, expected one of {', '.join(LIMBS)}")
    joints = _chain(skeleton, name)
    if not joints:
        raise SkeletonError(f"found no joint for {name!r} among {', '.join(skeleton.names)}")
    if len(joints) == 1:
        raise SkeletonError(f"the {name!r} of the skeleton hangs on its root, expected a chain")
    lengths = np.linalg.norm(np.asarray(skeleton.offsets, np.float64)[list(joints[1:])], axis=-1)
    return Limb(name=name, joints=joints, reach_m=float(lengths.sum()))


def steady_joints(skeleton: Skeleton, limbs: Sequence[Limb]) -> tuple[int, ...]:
    """Joints that keep their orientation in the world while ``limbs`` move.

    A reaching hand turns the torso, and with it the other arm and the head. Where these have no
    target, the joints at which they branch off keep their world orientation: the arm goes on
    swinging and the eyes look on as captured, carried along by the torso. So does the head at the
    end of its own chain. All other joints, such as fingers, follow the joint they hang on.
    """
    moved = {joint for limb in limbs for joint in limb.joints}
    named = {limb.name for limb in limbs}
    steady = {limb.joints[-1] for limb in limbs if limb.name == "head"}
    for name in LIMBS:
        if name not in named:
            other = _chain(skeleton, name)
            steady |= {j for j in other if j not in moved and skeleton.parents[j] in moved}
    return tuple(sorted(steady))


def _chain(skeleton: Skeleton, name: str) -> tuple[int, ...]:
    """Joints from below the root to the end of a limb; none where the skeleton has no such end."""
    roles = (name,) if name == "head" else (name, name.replace("hand", "wrist"))
    found = (find_role(skeleton, role) for role in roles)
    joint = next((j for j in found if j is not None), 0)
    joints: list[int] = []
    while joint > 0:
        joints.insert(0, joint)
        joint = skeleton.parents[joint]
    return tuple(joints)
