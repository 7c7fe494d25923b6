"""Which capsules make a body: one along each bone, as thick as that part of a person is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.core.body.roles import find_role
from mgjax.core.skeleton import Skeleton, rest_positions

# Radii at both ends of a bone, m, for a body whose legs are 0.82 m long from hip to ankle.
_LIMBS = {
    "hip": (0.088, 0.056),
    "knee": (0.056, 0.040),
    "ankle": (0.040, 0.034),
    "toe": (0.034, 0.024),
    "shoulder": (0.053, 0.040),
    "elbow": (0.040, 0.029),
    "wrist": (0.029, 0.025),
}
_TRUNK = ((0.0, 0.105), (0.35, 0.100), (0.75, 0.118), (1.0, 0.070))
"""Radius along the trunk from the root (0) to the neck (1)."""
_TRUNK_WIDTH, _TRUNK_DEPTH = 1.30, 0.85
"""A trunk is wider than it is deep."""
_NECK, _HEAD, _GIRDLE, _PELVIS = (0.054, 0.050), (0.074, 0.090), (0.064, 0.053), (0.098, 0.088)
_YOKE, _YOKE_SHARE, _YOKE_DROP = (0.080, 0.080), 0.5, 0.045
"""The upper chest lies across, this share of the way to the shoulders and this far below them."""
_CHIN = -0.25
"""The head's lower ball lies this share of the way from the joint up to the upper one."""
_LEG_M = 0.82
_SLENDER = 0.16
"""Radius over length of a bone whose part is unknown."""
_HAND_SLENDER = 0.28
"""Likewise of a bone of a hand; fingers are thinner than its table says."""
_SHORTEST_M = 0.004


@dataclass(frozen=True, kw_only=True)
class Capsule:
    """Two balls and what lies between them, in the rest pose.

    Attributes:
        joint: the joint that it moves with.
        start, end: centres of the balls, m.
        radii: of the balls, m.
        side: direction in which it is ``width`` times as wide, and square to it ``depth`` times.
    """

    joint: int
    start: Float[np.ndarray, "3"]
    end: Float[np.ndarray, "3"]
    radii: tuple[float, float]
    side: Float[np.ndarray, "3"]
    width: float = 1.0
    depth: float = 1.0

    def frame(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Unit vectors along the axis, sideways and in the third direction, right-handed."""
        axis = self.end - self.start
        length = np.linalg.norm(axis)
        axis = axis / length if length > 1e-9 else np.array([0.0, 1.0, 0.0])
        across = self.side - axis * (self.side @ axis)
        if np.linalg.norm(across) < 0.1:
            across = np.eye(3)[int(np.argmin(np.abs(axis)))]
            across = across - axis * (across @ axis)
        across = across / np.linalg.norm(across)
        return axis, across, np.cross(axis, across)


def body_capsules(skeleton: Skeleton) -> list[Capsule]:
    """Capsules along all bones in the rest pose whose root stands at the origin.

    Joints whose names tell their role get the thickness of that part of a body; bones of which
    nothing is known are slender. There is always at least a ball at the root.
    """
    places = rest_positions(skeleton)
    plan = _Plan(skeleton, places)
    capsules: list[Capsule] = []
    for joint, parent in enumerate(skeleton.parents):
        length = float(np.linalg.norm(places[joint] - places[parent])) if parent >= 0 else 0.0
        if parent < 0 or length < _SHORTEST_M:
            continue
        shape = plan.shape(parent, joint, length)
        if shape is not None:
            radii, flat = shape
            start, end = places[parent], places[joint]
            if parent == plan.head:
                start, end = plan.skull(start, end)
            capsules.append(
                Capsule(
                    joint=parent,
                    start=start,
                    end=end,
                    radii=radii,
                    side=plan.side,
                    width=_TRUNK_WIDTH if flat else 1.0,
                    depth=_TRUNK_DEPTH if flat else 1.0,
                )
            )
    capsules += plan.stubs() + plan.yoke()
    if not capsules:
        radii = (_PELVIS[0], _PELVIS[0])
        capsules = [Capsule(joint=0, start=places[0], end=places[0], radii=radii, side=plan.side)]
    return capsules


class _Plan:
    """What each bone of a skeleton is a part of."""

    def __init__(self, skeleton: Skeleton, places: np.ndarray) -> None:
        self.skeleton, self.places = skeleton, places
        self.limbs: dict[int, str] = {}
        sided: dict[str, list[int]] = {}
        for part in _LIMBS:
            for side in ("left", "right"):
                joint = find_role(skeleton, f"{side}_{part}")
                if joint is not None:
                    self.limbs[joint] = part
                    sided.setdefault(part, []).append(joint)
        self.neck, self.head = find_role(skeleton, "neck"), find_role(skeleton, "head")
        top = self.neck if self.neck is not None else self.head
        self.trunk = self._chain(top if top is not None else find_role(skeleton, "chest"))
        self.throat = set(self._chain(self.head)) - set(self.trunk[:-1])
        self.shoulders = sided.get("shoulder", [])
        self.scale = self._scale()
        self.side = self._side(sided)
        self.leads = {name: self._all_above(sided.get(name, [])) for name in ("hip", "shoulder")}

    def shape(self, start: int, end: int, length: float) -> tuple[tuple[float, float], bool] | None:
        """Radii of the bone between two joints and whether it is flat, or None for no capsule."""
        scale = self.scale
        limb = self._limb(start)
        if limb is not None:
            a, b = (scale * r for r in _LIMBS[limb])
            if limb == "wrist" or (limb == "toe" and self.limbs.get(start) != "toe"):
                a, b = (min(r, _HAND_SLENDER * length) for r in (a, b))
            return (a, b), False
        if self.head is not None and self._below(start, self.head):
            if (start, end) != (self.head, self._crown()):
                return None  # eyes, jaw and hair lie in or on the head
            return (scale * _HEAD[0], scale * _HEAD[1]), False
        if start in self.trunk and end in self.trunk:
            return (self._trunk_radius(start), self._trunk_radius(end)), True
        if start in self.throat and end in self.throat:
            return (scale * _NECK[0], scale * _NECK[1]), False
        if end in self.leads["hip"]:
            return (scale * _PELVIS[0], scale * _PELVIS[1]), False
        if end in self.leads["shoulder"]:
            return (scale * _GIRDLE[0], scale * _GIRDLE[1]), False
        radius = _SLENDER * length
        return (radius, 0.8 * radius), False

    def skull(self, start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Centres of the head's balls, so that it ends little above the bone."""
        bone = end - start
        length = float(np.linalg.norm(bone))
        top = max(length - 0.75 * self.scale * _HEAD[1], 0.2 * length) / length
        return start + _CHIN * top * bone, start + top * bone

    def yoke(self) -> list[Capsule]:
        """The upper chest, which no bone goes along."""
        if len(self.shoulders) != 2:
            return []
        left, right = (self.places[joint] for joint in self.shoulders)
        chains = [self._chain(shoulder) for shoulder in self.shoulders]
        joint = max(joint for joint in chains[0] if joint in chains[1])
        middle = (left + right) / 2
        up = self.places[self.trunk[-1]] - self.places[0] if self.trunk else np.zeros(3)
        up = up / max(float(np.linalg.norm(up)), 1e-9)
        middle = middle - self.scale * _YOKE_DROP * up
        reach = _YOKE_SHARE * (left - right) / 2
        a, b = (self.scale * radius for radius in _YOKE)
        return [
            Capsule(
                joint=joint, start=middle - reach, end=middle + reach, radii=(a, b), side=self.side
            )
        ]

    def stubs(self) -> list[Capsule]:
        """Heads and hands of skeletons that end at the joint where these begin."""
        found: list[Capsule] = []
        parts = [(self.head, 0.11, _HEAD)] + [
            (joint, 0.09, _LIMBS["wrist"]) for joint, p in self.limbs.items() if p == "wrist"
        ]
        for joint, length, radii in parts:
            if joint is None:
                continue
            if (self._crown() if joint == self.head else self._longest_child(joint)) is not None:
                continue
            along = self._arriving(joint) * length * self.scale
            place = self.places[joint]
            a, b = (self.scale * r for r in radii)
            found.append(
                Capsule(joint=joint, start=place, end=place + along, radii=(a, b), side=self.side)
            )
        return found

    def _arriving(self, joint: int) -> np.ndarray:
        """Direction of the last bone that leads to a joint."""
        below = joint
        while (above := self.skeleton.parents[below]) >= 0:
            bone = self.places[joint] - self.places[above]
            length = float(np.linalg.norm(bone))
            if length > _SHORTEST_M:
                return bone / length
            below = above
        return np.array([0.0, 1.0, 0.0])

    def _crown(self) -> int | None:
        """The end of the head, if it goes on as the neck does; files often set it to anything."""
        end = None if self.head is None else self._longest_child(self.head)
        if self.head is None or end is None:
            return None
        bone = self.places[end] - self.places[self.head]
        onward = float(bone @ self._arriving(self.head)) > 0.5 * float(np.linalg.norm(bone))
        return end if onward else None

    def _longest_child(self, joint: int) -> int | None:
        """The child with the longest bone, or None if there is no bone at all."""
        bones = {
            child: float(np.linalg.norm(self.places[child] - self.places[joint]))
            for child, parent in enumerate(self.skeleton.parents)
            if parent == joint
        }
        bones = {child: length for child, length in bones.items() if length > 0.03 * self.scale}
        return max(bones, key=lambda child: bones[child], default=None)

    def _chain(self, joint: int | None) -> list[int]:
        """The joints from the root down to one, or none."""
        chain: list[int] = []
        while joint is not None and joint >= 0:
            chain.append(joint)
            joint = self.skeleton.parents[joint]
        return chain[::-1]

    def _all_above(self, joints: list[int]) -> set[int]:
        return {above for joint in joints for above in self._chain(joint)}

    def _below(self, joint: int, top: int) -> bool:
        return top in self._chain(joint)

    def _limb(self, joint: int) -> str | None:
        chain = reversed(self._chain(joint))
        return next((self.limbs[j] for j in chain if j in self.limbs), None)

    def _length(self, joint: int) -> float:
        """Length of the bones from the root to a joint."""
        chain = self._chain(joint)
        return float(np.linalg.norm(np.diff(self.places[chain], axis=0), axis=1).sum())

    def _scale(self) -> float:
        """Size of the body: its legs', over those of a usual one."""
        legs = [
            self._length(ankle) - self._length(hip)
            for side in ("left", "right")
            if (hip := find_role(self.skeleton, f"{side}_hip")) is not None
            and (ankle := find_role(self.skeleton, f"{side}_ankle")) is not None
        ]
        return max(float(np.mean(legs)), 0.05) / _LEG_M if legs else 1.0

    def _side(self, sided: dict[str, list[int]]) -> np.ndarray:
        """To the left, from the right hip (or shoulder) to the left one."""
        for pair in (sided.get("hip", []), sided.get("shoulder", [])):
            if len(pair) == 2:
                across = self.places[pair[0]] - self.places[pair[1]]
                if np.linalg.norm(across) > _SHORTEST_M:
                    return across / np.linalg.norm(across)
        return np.array([1.0, 0.0, 0.0])

    def _trunk_radius(self, joint: int) -> float:
        whole = max(self._length(self.trunk[-1]), 1e-9)
        where = [at for at, _ in _TRUNK], [radius for _, radius in _TRUNK]
        return self.scale * float(np.interp(self._length(joint) / whole, *where))
