"""Whether motion of one skeleton can be played on another as it is."""

from __future__ import annotations

import numpy as np

from mgjax.core.body.roles import SIDES, find_roles
from mgjax.core.skeleton import Skeleton, first_difference, rest_positions

_SAME_M = 1e-3
"""Skeletons whose joints differ by no more in their parents' frames are one."""
_SAME_DEG = 40.0
"""Limbs that point elsewhere by more in the rest pose do not understand each other's rotations."""


def same_build(one: Skeleton, other: Skeleton) -> bool:
    """Whether two skeletons have one hierarchy, rest pose and size; ends of bones may differ."""
    if first_difference(one, other) is not None:
        return False
    inner = [j for j in range(1, one.num_joints) if j not in one.end_joints]
    away = np.asarray(one.offsets)[inner] - np.asarray(other.offsets)[inner]
    return bool(np.abs(away).max(initial=0.0) <= _SAME_M)


def difference(reference: Skeleton, other: Skeleton) -> str | None:
    """Why rotations of ``other`` cannot be copied to ``reference``, or None where they can.

    The hierarchy differs, or an arm or leg points elsewhere in the rest pose.
    """
    found = first_difference(reference, other)
    if found is not None:
        return found
    roles, places = find_roles(reference), [rest_positions(s) for s in (reference, other)]
    for side in SIDES:
        for a, b in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist")):
            top, end = roles.get(f"{side}_{a}"), roles.get(f"{side}_{b}")
            if top is None or end is None:
                continue
            ways = [p[end] - p[top] for p in places]
            length = float(np.prod([np.linalg.norm(way) for way in ways]))
            cosine = float(ways[0] @ ways[1]) / max(length, 1e-12)
            if length > 0 and cosine < np.cos(np.radians(_SAME_DEG)):
                angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
                return (
                    f"joint {other.names[end]!r} {angle:.0f}° away in the rest pose, seen from"
                    f" {other.names[top]!r}, from where the reference has it"
                )
    return None
