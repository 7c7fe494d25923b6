"""From glTF's poses to ours: rest poses with rotations and scales to one without.

A node of glTF has a rest rotation and a scale; a joint of ours has neither: in the rest pose all
rotations are the identity and offsets lie in world directions. With global rest rotations R₀ and
global rotations R(f), ours are G(f) = R(f)·R₀⁻¹, hence locally, with parent p and local rotations
r, r₀: R₀ₚ·r(f)·r₀⁻¹·R₀ₚ⁻¹; the offset is R₀ₚ·S·t with the scale S of all nodes above.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.io.gltf.animation import Tracks, evaluate
from mgjax.io.gltf.nodes import Node


@dataclass(frozen=True, kw_only=True)
class Poses:
    """The skeleton's joints over time, in our terms.

    Attributes:
        root: place of the root in the world, m.
        rotations: local, wxyz.
        offsets: each joint's place in its parent's frame, m.
        rest_offsets: those of the rest pose; the root's is its place in the world.
    """

    root: Float[np.ndarray, "F 3"]
    rotations: Float[np.ndarray, "F J 4"]
    offsets: Float[np.ndarray, "F J 3"]
    rest_offsets: Float[np.ndarray, "J 3"]


@dataclass(frozen=True, kw_only=True)
class _Above:
    """The transforms of a node's children's frame: of all nodes down to it, over time.

    Attributes:
        place: in the world, m.
        linear: rotation and scale of all nodes, as they multiply.
        turn: rotations alone.
        scale: the factor of all nodes' scales, or None where one is uneven or changes.
    """

    place: Float[np.ndarray, "F 3"]
    linear: Float[np.ndarray, "F 3 3"]
    turn: Float[np.ndarray, "F 4"]
    scale: float | None

    @staticmethod
    def world(frames: int) -> _Above:
        return _Above(
            place=np.zeros((frames, 3)),
            linear=np.broadcast_to(np.eye(3), (frames, 3, 3)),
            turn=np.broadcast_to([1.0, 0, 0, 0], (frames, 4)),
            scale=1.0,
        )

    def below(self, translation: np.ndarray, rotation: np.ndarray, scale: np.ndarray) -> _Above:
        local = matrices(rotation) * scale[:, None, :]
        factor = float(scale[0, 0])
        even = factor > 0 and bool((np.abs(scale - factor) <= 1e-6 * factor).all())
        return _Above(
            place=self.place + np.einsum("fij,fj->fi", self.linear, translation),
            linear=self.linear @ local,
            turn=np.asarray(quaternion.multiply(self.turn, rotation)),
            scale=self.scale * factor if even and self.scale is not None else None,
        )


def matrices(q: np.ndarray) -> np.ndarray:
    """[F,3,3] rotation matrices of unit quaternions [F,4]."""
    columns = [quaternion.rotate(q, axis[None]) for axis in np.eye(3)]
    return np.stack(columns, axis=-1)


def convert(
    nodes: list[Node], above_root: list[int], order: list[int], tracks: Tracks, times: np.ndarray
) -> Poses:
    """Poses at the given times.

    Args:
        nodes: of the file.
        above_root: those above the skeleton's root, from the topmost down; they are folded into
            its place, its rotation and the length of all bones.
        order: nodes of the skeleton, a parent before its children.
        tracks: of any of these nodes.
        times: s. [F]
    """
    frames, joints = len(times), len(order)
    moving = _Above.world(frames)
    rest = _Above.world(1)
    for node in above_root:
        moving = moving.below(*_local(nodes[node], node, tracks, times))
        rest = rest.below(*_local(nodes[node], node, {}, times[:1]))
    slot = {node: joint for joint, node in enumerate(order)}
    moved: list[_Above] = []
    rested: list[_Above] = []
    rotations = np.zeros((frames, joints, 4))
    offsets = np.zeros((frames, joints, 3))
    rest_offsets = np.zeros((joints, 3))
    for joint, node in enumerate(order):
        parent = slot.get(nodes[node].parent)
        up, up_rest = (moving, rest) if parent is None else (moved[parent], rested[parent])
        local = _local(nodes[node], node, tracks, times)
        local_rest = _local(nodes[node], node, {}, times[:1])
        moved.append(up.below(*local))
        rested.append(up_rest.below(*local_rest))
        turn = quaternion.multiply(local[1], quaternion.conjugate(local_rest[1]))
        turn = quaternion.multiply(up_rest.turn, turn)
        rotations[:, joint] = quaternion.multiply(turn, quaternion.conjugate(up_rest.turn))
        rest_offsets[joint] = _offsets(up_rest, up_rest, rested[joint], local_rest[0])[0]
        offsets[:, joint] = _offsets(up, up_rest, moved[joint], local[0])
    world = quaternion.multiply(moved[0].turn, quaternion.conjugate(rested[0].turn))
    rotations[:, 0] = world
    rest_offsets[0] = rested[0].place[0]
    return Poses(
        root=moved[0].place, rotations=rotations, offsets=offsets, rest_offsets=rest_offsets
    )


def _offsets(up: _Above, up_rest: _Above, joint: _Above, translation: np.ndarray) -> np.ndarray:
    """[F,3] places of a joint in its parent's frame, which has turned by R·R₀⁻¹ from the world's.

    With an even scale this is R₀·S·t, which keeps every digit of t; otherwise the place in the
    world is turned back.
    """
    if up.scale is not None:
        return np.asarray(quaternion.rotate(up_rest.turn, up.scale * translation))
    undo = quaternion.multiply(up_rest.turn, quaternion.conjugate(up.turn))
    return np.asarray(quaternion.rotate(undo, joint.place - up.place))


def _local(
    node: Node, index: int, tracks: Tracks, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Translation, rotation and scale of a node at the given times."""
    values: list[np.ndarray] = []
    for path in ("translation", "rotation", "scale"):
        track = tracks.get((index, path))
        if track is None:
            rest = np.asarray(getattr(node, path))
            values.append(np.broadcast_to(rest, (len(times), len(rest))))
        else:
            values.append(evaluate(track, path, times))
    return values[0], values[1], values[2]
