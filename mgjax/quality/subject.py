"""Whose motion is measured: the joints, capsules and size of a body, found once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.core.arrays import Array
from mgjax.core.body.capsules import CapsulePairs, Capsules, capsule_pairs, make_capsules
from mgjax.core.body.height import body_scale
from mgjax.core.body.roles import SIDES, find_role, require_roles
from mgjax.core.contacts import foot_joints
from mgjax.core.errors import SkeletonError
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.pytree import register

_TRUNK = ("torso", "pelvis", "head", "neck", "thigh")
_FORE = ("forearm", "hand")


@register()
@dataclass(frozen=True, kw_only=True, eq=False)
class Subject:
    """What the measures need to know of a skeleton.

    Attributes:
        scale: of the body; see :func:`mgjax.core.body.height.body_scale`.
        feet: left and right toe, left and right ankle; none where the body has no feet. [4 or 0]
        joints: those that turn. [n]
        pairs: capsules that should not meet; none where the body has no arms and no legs. [P]
    """

    scale: Float[Array, ""]
    feet: Int[Array, " K"]
    joints: Int[Array, " n"]
    pairs: CapsulePairs


def subject_of(skeleton: Skeleton) -> tuple[Subject, tuple[str, ...]]:
    """The joints to measure, and what cannot be measured on this skeleton, in words.

    The ball of a foot stands for a toe that is not there; see
    :func:`mgjax.core.contacts.foot_joints`.
    """
    notes: list[str] = []
    try:
        ankles = require_roles(skeleton, [f"{side}_ankle" for side in SIDES])
        feet = [*foot_joints(skeleton), *ankles]
    except SkeletonError:
        feet = []
        notes.append("no feet were found: nothing is said of them")
    else:
        if any(find_role(skeleton, f"{side}_toe") is None for side in SIDES):
            notes.append("no joint of the toes: the end of the foot, or the ankle, stands for it")
    capsules = make_capsules(skeleton)
    pairs = limb_pairs(skeleton, capsules)
    arms = {arm for arm in capsules.arms if arm}
    if not pairs:
        notes.append("no limbs were found: nothing is said of limbs in the body")
    elif len(arms) < 2:
        notes.append(f"{len(arms)} of 2 arms were found: limbs in the body are those found")
    ends = set(skeleton.end_joints)
    return (
        Subject(
            scale=np.array(body_scale(skeleton), np.float32),
            feet=np.array(feet, np.int32),
            joints=np.array([j for j in range(skeleton.num_joints) if j not in ends], np.int32),
            pairs=capsule_pairs(capsules, pairs),
        ),
        tuple(notes),
    )


def limb_pairs(skeleton: Skeleton, capsules: Capsules) -> list[tuple[int, int]]:
    """Capsules that should not meet, by their numbers.

    Forearms and hands with the trunk, the thighs and the other arm's; the bones of one leg with
    those of the other, but not thigh with thigh, which touch where they begin.
    """
    leg = _legs(skeleton, capsules)
    pairs: list[tuple[int, int]] = []
    for i, (part, arm) in enumerate(zip(capsules.parts, capsules.arms, strict=True)):
        for j, (other, second) in enumerate(zip(capsules.parts, capsules.arms, strict=True)):
            both_arms = other in _FORE and i < j and arm != second
            arms = part in _FORE and (other in _TRUNK or both_arms)
            thighs = part == other == "thigh"
            if arms or ((leg[i], leg[j]) == (0, 1) and not thighs):
                pairs.append((i, j))
    return pairs


def _legs(skeleton: Skeleton, capsules: Capsules) -> list[int]:
    """The leg that each capsule belongs to from its hip on: 0, 1, or -1 for none."""
    hips = [find_role(skeleton, f"{side}_hip") for side in SIDES]
    above = [-1] * skeleton.num_joints
    for joint, parent in enumerate(skeleton.parents):
        above[joint] = hips.index(joint) if joint in hips else above[parent] if parent >= 0 else -1
    return [above[joint] for joint in capsules.joints[:, 0].tolist()]
