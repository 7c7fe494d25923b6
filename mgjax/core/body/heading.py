"""The two joints whose line across says where a body looks."""

from __future__ import annotations

import numpy as np

from mgjax.core.body.mirrored import mirror_joints
from mgjax.core.body.roles import find_role
from mgjax.core.errors import SkeletonError
from mgjax.core.skeleton import Skeleton


def across_joints(skeleton: Skeleton) -> tuple[int, int]:
    """Left and right joint whose line lies across the body: the hips.

    What has no hips (an animal, a prop) has a pair of joints with a side in their names, the one
    nearest to the root; else its root and its farthest joint: any line that turns with it will do.

    Raises:
        SkeletonError: there is one joint only, or all are at one place.
    """
    left, right = find_role(skeleton, "left_hip"), find_role(skeleton, "right_hip")
    if left is not None and right is not None:
        return left, right
    pairs = [(j, twin) for j, twin in enumerate(mirror_joints(skeleton)) if j < twin]
    if pairs:
        return pairs[0]
    lengths = np.linalg.norm(np.asarray(skeleton.offsets, dtype=np.float64), axis=1)
    lengths[0] = 0.0
    for joint, parent in enumerate(skeleton.parents):
        lengths[joint] += lengths[parent] if parent >= 0 else 0.0
    farthest = int(np.argmax(lengths))
    if lengths[farthest] <= 0:
        raise SkeletonError(got=f"{skeleton.num_joints} joints at one place", expected="bones")
    return farthest, 0
