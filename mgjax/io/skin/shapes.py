"""The shapes of a body: capsules along its bones; a person has a head, hands, feet and calves."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mgjax.core.body.roles import SIDES, find_roles
from mgjax.core.skeleton import Skeleton, rest_positions
from mgjax.io.skin.bones import Capsule, body_capsules
from mgjax.io.skin.field import NOWHERE, TRUNK, Shape

_LEG_M = 0.82
_UP = np.array([0.0, 1.0, 0.0])
_SOLE_M = 0.026
"""The sole lies so far below the ball of the foot."""
_HEAD_M, _TILT = 0.19, 0.7
"""From the head's joint to the crown; a head's bone leans by no more than this cosine."""
_FOOT_M, _HAND_M, _FINGERS_M = 0.13, 0.085, 0.085
"""From ankle to ball, from wrist to knuckles, and fingers, where the skeleton does not say."""


def body_shapes(skeleton: Skeleton, *, person: bool) -> list[Shape]:
    """What the surface of a body goes around, in the rest pose whose root is at the origin.

    Args:
        skeleton: any; the rest pose of a person stands, with its left to +X.
        person: it has arms and legs, and gets a person's head, hands and feet.
    """
    capsules = body_capsules(skeleton)
    if not person:
        return _linked(skeleton, [(capsule, False) for capsule in capsules])
    roles = find_roles(skeleton)
    below = {name: _below(skeleton, roles[name]) for name in roles if name != "root"}
    limbs: set[int] = set()
    replaced: set[int] = set()
    for name, joints in below.items():
        if name.endswith(("_hip", "_shoulder")):
            limbs |= joints
        if name.endswith(("_wrist", "_ankle")) or name == "head":
            limbs |= joints
            replaced |= joints
    kept = [(c, c.joint not in limbs) for c in capsules if c.joint not in replaced]
    shapes = _linked(skeleton, kept)
    person_ = _Person(skeleton, roles, [c for c in capsules if c.joint == roles.get("head")])
    shapes += person_.trunk()
    for side in SIDES:
        for part in (person_.leg, person_.arm):
            shapes += part(side, shapes)
    return shapes + person_.head(len(shapes))


def _below(skeleton: Skeleton, top: int) -> set[int]:
    found = {top}
    for joint in range(top + 1, skeleton.num_joints):
        if skeleton.parents[joint] in found:
            found.add(joint)
    return found


def _linked(skeleton: Skeleton, capsules: list[tuple[Capsule, bool]]) -> list[Shape]:
    """Shapes of capsules, of which some belong to the trunk, each joined to the one it hangs on."""
    ordered = sorted(capsules, key=lambda item: (not item[1], item[0].joint))
    shapes: list[Shape] = []
    by_joint: dict[int, list[int]] = {}
    for capsule, trunk in ordered:
        onto = NOWHERE
        joint = skeleton.parents[capsule.joint]
        while joint >= 0 and joint not in by_joint:
            joint = skeleton.parents[joint]
        if not trunk and joint >= 0:
            near = min(
                by_joint[joint],
                key=lambda i: float(np.linalg.norm(shapes[i].capsule.end - capsule.start)),
            )
            onto = TRUNK if shapes[near].trunk else near
        elif not trunk and capsule.joint in by_joint:
            onto = by_joint[capsule.joint][0]
        elif not trunk and any(shape.trunk for shape in shapes):
            onto = TRUNK
        by_joint.setdefault(capsule.joint, []).append(len(shapes))
        shapes.append(Shape(capsule=capsule, trunk=trunk, onto=onto))
    return shapes


@dataclass(frozen=True)
class _Person:
    """What capsules along bones lack of a person."""

    skeleton: Skeleton
    roles: dict[str, int]
    skull: list[Capsule]

    @property
    def places(self) -> np.ndarray:
        return rest_positions(self.skeleton)

    @property
    def scale(self) -> float:
        legs = [
            np.linalg.norm(self.place(f"{s}_hip") - self.place(f"{s}_knee"))
            + np.linalg.norm(self.place(f"{s}_knee") - self.place(f"{s}_ankle"))
            for s in SIDES
        ]
        return max(float(np.mean(legs)), 0.05) / _LEG_M

    @property
    def left(self) -> np.ndarray:
        across = self.place("left_hip") - self.place("right_hip")
        across[1] = 0.0
        return across / max(float(np.linalg.norm(across)), 1e-9)

    @property
    def ahead(self) -> np.ndarray:
        return np.cross(self.left, _UP)

    def place(self, role: str) -> np.ndarray:
        return np.array(self.places[self.roles[role]])

    def ball(
        self, joint: int, start: np.ndarray, end: np.ndarray, radii: tuple[float, float],
        *, width: float = 1.0, depth: float = 1.0, side: np.ndarray | None = None,
    ) -> Capsule:  # fmt: skip
        """A capsule whose radii are those of a usual body."""
        a, b = (self.scale * radius for radius in radii)
        across = self.left if side is None else side
        return Capsule(
            joint=joint, start=start, end=end, radii=(a, b), side=across, width=width, depth=depth
        )

    def trunk(self) -> list[Shape]:
        """What sits on the pelvis behind."""
        s, shapes = self.scale, []
        hips = (self.place("left_hip") + self.place("right_hip")) / 2
        for side in SIDES:
            out = self.place(f"{side}_hip") - hips
            seat = hips + 0.75 * out - s * (0.035 * self.ahead + 0.035 * _UP)
            capsule = self.ball(0, seat, seat + 0.01 * s * _UP, (0.086, 0.084))
            shapes.append(Shape(capsule=capsule, trunk=True))
        return shapes

    def leg(self, side: str, shapes: list[Shape]) -> list[Shape]:
        """The calf and the foot."""
        knee, ankle = self.roles[f"{side}_knee"], self.roles[f"{side}_ankle"]
        k, a = self.places[knee], self.places[ankle]
        s, shin = self.scale, a - k
        onto = self.last(shapes, knee)
        back = -self.ahead + shin * (self.ahead @ shin) / max(float(shin @ shin), 1e-9)
        calf = self.ball(
            knee, k + 0.16 * shin + 0.016 * s * back, k + 0.42 * shin + 0.016 * s * back,
            (0.047, 0.043),
        )  # fmt: skip
        ball, toe = self.foot(side)
        along = ball - a
        along[1] = 0.0
        along = along / max(float(np.linalg.norm(along)), 1e-9)
        across = np.cross(_UP, along)
        floor = min(float(ball[1]), float(a[1])) - _SOLE_M * s
        heel, front = a - 0.028 * s * along, ball.copy()
        heel[1], front[1] = floor + 0.034 * s, floor + 0.026 * s
        tip = front + 0.055 * s * along
        tip[1] = floor + 0.018 * s
        instep = a + 0.45 * (ball - a)
        number = len(shapes)
        parts = [
            (self.ball(ankle, a, instep, (0.039, 0.034), side=across), onto),
            (self.ball(ankle, heel, front, (0.037, 0.042), side=across, width=1.02), number + 1),
            (self.ball(toe, front, tip, (0.042, 0.034), side=across, depth=0.8), number + 2),
        ]
        foot = [Shape(capsule=c, onto=o, floor=floor) for c, o in parts]
        return [Shape(capsule=calf, onto=onto), *foot]

    def foot(self, side: str) -> tuple[np.ndarray, int]:
        """The ball of the foot, and the joint that toes turn with."""
        ankle = self.roles[f"{side}_ankle"]
        a, s = self.places[ankle], self.scale
        toe = self.roles.get(f"{side}_toe")
        if toe is not None:
            ball = np.array(self.places[toe])
            flat = np.hypot(*(ball - a)[[0, 2]])
            if flat > 0.05 * s and ball[1] < a[1] + 0.02 * s:
                return ball, toe
        ball = a + _FOOT_M * s * self.ahead
        ball[1] = a[1] - 0.05 * s
        return ball, ankle if toe is None else toe

    def arm(self, side: str, shapes: list[Shape]) -> list[Shape]:
        """A hand as a mitten with a thumb."""
        elbow, wrist = self.roles[f"{side}_elbow"], self.roles[f"{side}_wrist"]
        w, s = self.places[wrist], self.scale
        along = w - self.places[elbow]
        knuckles = self.roles.get(f"{side}_hand")
        length = _HAND_M * s
        if knuckles is not None:
            bone = self.places[knuckles] - w
            far = float(np.linalg.norm(bone))
            if 0.03 * s < far < 0.16 * s and bone @ along > 0.5 * far * np.linalg.norm(along):
                along, length = bone, far
        along = along / max(float(np.linalg.norm(along)), 1e-9)
        thumb = self.ahead - along * (self.ahead @ along)
        thumb = thumb / max(float(np.linalg.norm(thumb)), 1e-9)
        end = w + length * along
        tip = end + _FINGERS_M * s * along
        root, point = w + 0.025 * s * (along + thumb), w + s * (0.07 * along + 0.066 * thumb)
        number = len(shapes)
        fingers = wrist if knuckles is None else knuckles
        onto = self.last(shapes, elbow)
        parts = [
            (self.ball(wrist, w, end, (0.027, 0.030), width=1.3, depth=0.6, side=thumb), onto),
            (self.ball(fingers, end, tip, (0.030, 0.022), width=1.3, depth=0.55, side=thumb),
             number),
            (self.ball(wrist, root, point, (0.016, 0.013)), number),
        ]  # fmt: skip
        return [Shape(capsule=c, onto=o) for c, o in parts]

    def last(self, shapes: list[Shape], joint: int) -> int:
        """The shape at whose end a limb goes on: of a joint, or of one above it."""
        while joint >= 0:
            found = [i for i, shape in enumerate(shapes) if shape.capsule.joint == joint]
            if found:
                return TRUNK if shapes[found[0]].trunk else found[0]
            joint = self.skeleton.parents[joint]
        return NOWHERE

    def head(self, number: int) -> list[Shape]:
        """Skull, jaw and nose, above the capsule that the skeleton's head has."""
        if not self.skull:
            return []
        joint, s, old = self.skull[0].joint, self.scale, self.skull[0]
        axis = old.end - old.start
        axis = axis / max(float(np.linalg.norm(axis)), 1e-9)
        top = old.end + old.radii[1] * axis
        if axis[1] < _TILT:  # the end of the head is set to anything: it is where the neck ends
            axis, top = _UP, self.places[joint] + _HEAD_M * s * _UP
        ahead = self.ahead - axis * (self.ahead @ axis)
        ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
        middle = top - 0.098 * s * axis
        low = middle - 0.082 * s * axis
        nose = middle + s * (0.088 * ahead - 0.03 * axis)
        parts = [
            (self.ball(joint, middle - 0.014 * s * ahead, middle + 0.008 * s * ahead,
                       (0.088, 0.084), width=0.88, depth=1.08), TRUNK),
            (self.ball(joint, low + 0.022 * s * ahead, low + s * (0.058 * ahead - 0.012 * axis),
                       (0.056, 0.038), width=1.02, depth=1.0), number),
            (self.ball(joint, nose, nose + s * (0.012 * ahead - 0.022 * axis),
                       (0.013, 0.017)), number),
        ]  # fmt: skip
        return [replace(Shape(capsule=c), onto=o) for c, o in parts]
