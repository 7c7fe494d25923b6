"""Which axis of a file points up, where the floor is, and where the body looks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mgjax.core.body.tree import Tree
from mgjax.io.reading.raw import Note
from mgjax.io.reading.read_as import AXES

STANDS, LIES = 0.7, 0.35
"""Mean cosine between the body and an axis: above, it stands along it; below, it does not."""

FLOOR_SHARE = 0.15
"""A floor nearer to height 0 than this share of the body is left as it is."""


def axis_vector(axis: str) -> np.ndarray:
    """Unit vector of ``"x"`` … ``"-z"``."""
    vector = np.zeros(3)
    vector["xyz".index(axis[-1])] = -1.0 if axis[0] == "-" else 1.0
    return vector


@dataclass(frozen=True, kw_only=True)
class FoundUp:
    """The axis that points up.

    Attributes:
        axis: such as ``"z"``.
        cosine: mean cosine between the body, from the feet to the head, and that axis.
        with_rest: the rest pose stands along the axis as well, so that it is turned, too.
        notes: what is to be said.
    """

    axis: str
    cosine: float
    with_rest: bool
    notes: tuple[Note, ...] = ()


def find_up(
    tree: Tree, roles: dict[str, int], places: np.ndarray, height: float, said: str | None = None
) -> FoundUp:
    """The axis along which the body stands.

    Y is taken where the body stands along it or nothing speaks clearly for another axis. Another
    one is taken where the body stands along it, and either the rest pose does so too, or the feet
    are on a floor at 0; else the body lies, and a note says so.

    Args:
        tree, roles: the body.
        places: [T,J,3] joint places of some frames, in the axes of the file, m.
        height: of the body, m.
        said: the axis that a user named, or None.
    """
    body = _direction(places, roles)
    rest = _rest(tree)
    stands = _direction(rest[None], roles)[0]
    mean = body.mean(axis=0)
    cosines = {axis: float(mean @ axis_vector(axis)) for axis in AXES}
    if said is not None:
        with_rest = float(stands @ axis_vector(said)) > STANDS
        return FoundUp(axis=said, cosine=cosines[said], with_rest=with_rest and said != "y")
    best = max(cosines, key=lambda axis: cosines[axis])
    if best == "y" or cosines["y"] > 0.5:
        note = Note("lies", "the body hardly ever stands upright")
        notes = () if cosines["y"] >= LIES else (note,)
        return FoundUp(axis="y", cosine=cosines["y"], with_rest=False, notes=notes)
    clear = cosines[best] > STANDS and cosines["y"] < LIES
    with_rest = float(stands @ axis_vector(best)) > 0.8
    if clear and (with_rest or on_floor(feet_heights(tree, roles, places, best), height)):
        note = Note("up_axis", f"{best.upper()} points up in the file; the body was turned upright")
        return FoundUp(axis=best, cosine=cosines[best], with_rest=with_rest, notes=(note,))
    lies = "is upside down" if best == "-y" else f"lies along {best.upper()}"
    text = f"the body {lies}; if that axis points up, say so: --up={best}"
    note = Note("upside_down" if best == "-y" else "lies", text)
    return FoundUp(axis="y", cosine=cosines["y"], with_rest=False, notes=(note,))


def _rest(tree: Tree) -> np.ndarray:
    places = np.zeros_like(tree.offsets)
    for joint, parent in enumerate(tree.parents):
        if parent >= 0:
            places[joint] = places[parent] + tree.offsets[joint]
    return places


def _direction(places: np.ndarray, roles: dict[str, int]) -> np.ndarray:
    """[T,3] unit vectors from between the ankles to the head (or the chest)."""
    feet = 0.5 * (places[:, roles["left_ankle"]] + places[:, roles["right_ankle"]])
    up = places[:, roles.get("head", roles.get("chest", 0))] - feet
    return up / np.maximum(np.linalg.norm(up, axis=-1, keepdims=True), 1e-9)


def feet_heights(
    tree: Tree, roles: dict[str, int], places: np.ndarray, axis: str = "y"
) -> np.ndarray:
    """[T] height of the lowest point of both feet along an axis, ends of bones left out."""
    ends = set(tree.end_joints)
    feet = [j for side in ("left", "right") for j in tree.below(roles[f"{side}_ankle"])]
    feet = [j for j in feet if j not in ends and not tree.beside[j]] or feet
    return (places[:, feet] @ axis_vector(axis)).min(axis=1)


def on_floor(heights: np.ndarray, height: float) -> bool:
    """Whether the feet stand on a floor at 0, given their lowest points."""
    return bool(abs(floor_level(heights)) <= FLOOR_SHARE * height)


def floor_level(heights: np.ndarray) -> float:
    """Height of the floor on which the feet stand: low, but not the lowest sample."""
    return float(np.percentile(heights, 5, method="lower"))


def turn_to_y(axis: str) -> np.ndarray:
    """[3,3] rotation that brings an axis of the file to +Y; Z up keeps X."""
    rows = {
        "y": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        "-y": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
        "z": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
        "-z": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
        "x": ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
        "-x": ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    }
    return np.array(rows[axis], dtype=np.float64)


def on_four_legs(places: np.ndarray, roles: dict[str, int]) -> bool:
    """Whether what looks like a body stands on its hands as well, with its trunk level; up is Y.

    Someone who crawls on hands and knees has the hips no higher than a thigh; an animal that
    stands has them as high as a leg.
    """
    parts = ("hip", "knee", "ankle", "wrist")
    needed = {f"{side}_{part}" for side in ("left", "right") for part in parts} | {"chest"}
    if not needed <= roles.keys():
        return False
    hips, _, feet, hands = (
        0.5 * (places[:, roles[f"left_{part}"]] + places[:, roles[f"right_{part}"]])
        for part in parts
    )
    legs = _leg(places, roles)
    trunk = places[:, roles["chest"]] - hips
    level = np.abs(trunk[:, 1]) < 0.6 * np.linalg.norm(trunk, axis=-1)
    stands = hips[:, 1] - feet[:, 1] > 0.6 * legs
    on_hands = np.abs(hands[:, 1] - feet[:, 1]) < 0.25 * legs
    return bool(np.mean(level & stands & on_hands) > 0.8)


def _leg(places: np.ndarray, roles: dict[str, int]) -> float:
    """Length of the left leg from hip to ankle, m."""
    hip, knee, ankle = (places[0, roles[f"left_{part}"]] for part in ("hip", "knee", "ankle"))
    return float(np.linalg.norm(knee - hip) + np.linalg.norm(ankle - knee))


def forward_of(places: np.ndarray, roles: dict[str, int]) -> np.ndarray:
    """[T,3] where the body looks, by its knees and feet; up is Y. Not of unit length.

    A knee bends ahead, also of a leg that swings back with its foot behind it; where legs are
    straight, the feet decide.
    """
    forward = np.zeros((len(places), 3))
    for side in ("left", "right"):
        hip, knee, ankle = (places[:, roles[f"{side}_{p}"]] for p in ("hip", "knee", "ankle"))
        forward += 3 * (knee - 0.5 * (hip + ankle))
        if f"{side}_toe" in roles:
            forward += places[:, roles[f"{side}_toe"]] - ankle
    forward[:, 1] = 0
    return forward


def sides_swapped(places: np.ndarray, roles: dict[str, int]) -> bool:
    """Whether what is called left lies on the right in most frames; up is Y."""
    left = np.cross([0.0, 1.0, 0.0], forward_of(places, roles))
    across = places[:, roles["left_hip"]] - places[:, roles["right_hip"]]
    return bool(np.median(np.sum(left * across, axis=-1)) < 0)
