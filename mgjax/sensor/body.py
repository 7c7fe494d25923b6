"""The body behind a stream: which bones it has, how long they are, and how they stand now."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton
from mgjax.sensor.bone_table import BONES, NEEDED, PARENTS, nearest_above
from mgjax.sensor.bones import flip_places, flip_rotations, make_body
from mgjax.sensor.packets import Transform

LEARNING_FRAMES = 20
"""Which bones a sender has is learnt from so many frames."""
ROOT = -1
"""Stands for the model's root among the bones of a frame."""

Parts = Mapping[int, Transform]
"""What came of a frame, by the number of the bone."""


class HeldBody:
    """Holds each bone as it was last received.

    Bones that do not come in the first frames do not exist: the next one above is the parent, as
    in Unity. A place of exactly zero, which some senders give for all but the hips, means that of
    the embedded body. Scales and offsets for mixed reality are not read.

    Args:
        usual: local places of all bones in the T-pose of the embedded body, from
            :func:`mgjax.sensor.bones.usual_places`, m.

    Attributes:
        bones: of the body, as places in :data:`mgjax.sensor.bone_table.BONES`; none yet while
            it is unknown.
        skeleton: in the T-pose, or None.
    """

    def __init__(self, usual: Float[np.ndarray, "B 3"]) -> None:
        self._usual = usual
        self.bones: frozenset[int] = frozenset()
        self.skeleton: Skeleton | None = None
        self._places = usual.copy()
        self._rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(BONES), 1))
        self._root = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
        self._seen: set[int] = set()
        self._placed: set[int] = set()
        self._unsure = LEARNING_FRAMES

    def update(self, parts: Parts) -> None:
        """Takes what came of the next frame."""
        if parts:
            values = np.array(list(parts.values()))
            places, rotations = flip_places(values[:, :3]), flip_rotations(values[:, [6, 3, 4, 5]])
            for bone, place, rotation in zip(parts, places, rotations, strict=True):
                self._take(bone, place, rotation)
        if self.skeleton is None:
            self._unsure -= 1
            if self._unsure <= 0 and self._seen.issuperset(NEEDED):
                self._fix()

    def _take(self, bone: int, place: np.ndarray, rotation: np.ndarray) -> None:
        if bone == ROOT:
            self._root = place, rotation
            return
        self._rotations[bone] = rotation
        if bone == 0 or place.any():
            self._places[bone] = place
            self._placed.add(bone)
        self._seen.add(bone)

    def held(self, parts: Parts) -> int:
        """How many bones of the body did not come."""
        return len(self.bones - parts.keys())

    def pose(self, skeleton: Skeleton) -> tuple[Float[np.ndarray, "J 3"], Float[np.ndarray, "J 4"]]:
        """Where the joints of its skeleton are in the world, m, and their local rotations."""
        root_place, root_turn = self._root
        bones = sorted(self.bones)
        places, turns = self._places[bones], self._rotations[bones]
        turns[0] = quaternion.multiply(root_turn, turns[0])
        hips = root_place + quaternion.rotate(root_turn, places[0])
        return np.asarray(forward(skeleton, np.asarray(hips), turns, places)[0]), turns

    def _fix(self) -> None:
        """From now on the body has the bones that have come, and no others."""
        for bone in self._seen - self._placed:
            # The bones between it and its parent do not exist, but their lengths do.
            above, between = nearest_above(bone, self._seen), PARENTS[bone]
            while between != above:
                self._places[bone] += self._usual[between]
                between = PARENTS[between]
        self.bones = frozenset(self._seen)
        self.skeleton = make_body(self._places, self._seen)
