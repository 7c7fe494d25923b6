"""One closed surface around any skeleton, with up to four joints for each vertex."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int, Integer

from mgjax.core import quaternion
from mgjax.core.skeleton import Skeleton, rest_positions
from mgjax.io.skin.bones import Capsule
from mgjax.io.skin.field import Shape, body_distance
from mgjax.io.skin.shapes import body_shapes
from mgjax.io.skin.spread import spread_pose
from mgjax.io.skin.surface_nets import surface_nets
from mgjax.io.skin.weights import skin_weights

MOST_VERTICES = 4000
_WANTED = 3500
_BLEND = 2.2
"""Surfaces this many steps of the grid apart flow into one another."""
_THINNEST = 0.72
"""No shape is thinner than this many steps: the grid would not see it."""
_FAR_TURN = 0.82
"""Cosine of half the angle (70°) between two joints, beyond which blending turns folds a body."""
_CELLS = 2_000_000
_USUAL_STEP_M = 0.023


@dataclass(frozen=True, kw_only=True)
class WeldedMesh:
    """A closed surface in the rest pose whose root stands at the origin.

    Attributes:
        vertices: m. [V,3]
        normals: unit, outward. [V,3]
        joints: that each vertex moves with. [V,4]
        weights: their shares times 255, which add up to 255. [V,4]
        triangles: counter-clockwise from outside; each edge belongs to two of them. [T,3]
    """

    vertices: Float[np.ndarray, "V 3"]
    normals: Float[np.ndarray, "V 3"]
    joints: Int[np.ndarray, "V 4"]
    weights: Integer[np.ndarray, "V 4"]
    triangles: Int[np.ndarray, "T 3"]


def welded_mesh(skeleton: Skeleton) -> WeldedMesh:
    """The skin of a body of at most :data:`MOST_VERTICES`.

    It is made in a pose in which arms and legs are apart, so that only what belongs together grows
    together, and brought back by the inverse of linear blend skinning.
    """
    pose = spread_pose(skeleton)
    shapes = body_shapes(pose.skeleton, person=pose.person)
    step = _step(shapes)
    while True:
        thick = [_thick(shape, _THINNEST * step) for shape in shapes]
        vertices, triangles = _surface(thick, step)
        if len(vertices) <= MOST_VERTICES:
            break
        step *= max(1.02, float(np.sqrt(len(vertices) / _WANTED)))
    vertices = _project(thick, vertices, step)
    normals = _slope(thick, vertices, _BLEND * step, 0.25 * step)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-12
    joints, weights = skin_weights(pose.skeleton, thick, vertices, triangles, step / _USUAL_STEP_M)
    places, stood = rest_positions(skeleton), rest_positions(pose.skeleton)
    vertices, normals = _unskin(vertices, normals, joints, weights, pose.turns, places, stood)
    return WeldedMesh(
        vertices=vertices.astype(np.float32),
        normals=normals.astype(np.float32),
        joints=joints,
        weights=weights,
        triangles=triangles,
    )


def _step(shapes: Sequence[Shape]) -> float:
    """The grid's step for a surface of the wanted number of vertices, at most a twentieth off."""
    area = 0.0
    for shape in shapes:
        c = shape.capsule
        length = float(np.linalg.norm(c.end - c.start))
        radius = float(np.mean(c.radii)) * (c.width + c.depth) / 2
        area += 2 * np.pi * radius * length + 2 * np.pi * radius**2
    return float(np.sqrt(0.8 * area / _WANTED))


def _thick(shape: Shape, least: float) -> Shape:
    c = shape.capsule
    flat = min(c.width, c.depth)
    radii = tuple(max(radius, least / max(flat, 0.5)) for radius in c.radii)
    return replace(shape, capsule=replace(c, radii=radii))


def _box(capsules: Sequence[Capsule], margin: float) -> tuple[np.ndarray, np.ndarray]:
    ends = np.array([place for c in capsules for place in (c.start, c.end)])
    thick = np.repeat([max(c.radii) * max(c.width, c.depth, 1.0) for c in capsules], 2)[:, None]
    return (ends - thick).min(axis=0) - margin, (ends + thick).max(axis=0) + margin


def _surface(shapes: Sequence[Shape], step: float) -> tuple[np.ndarray, np.ndarray]:
    low, high = _box([shape.capsule for shape in shapes], 3 * step)
    step = max(step, float(np.cbrt((high - low).prod() / _CELLS)))
    axes = [np.arange(a, b + step, step) for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    field = body_distance(shapes, points, _BLEND * step)
    vertices, triangles = surface_nets(field.reshape([len(axis) for axis in axes]))
    return low + vertices * step, triangles


def _slope(shapes: Sequence[Shape], points: np.ndarray, blend: float, by: float) -> np.ndarray:
    """The field's gradient, by central differences."""
    steps = by * np.concatenate([np.eye(3), -np.eye(3)])
    around = (points + steps[:, None]).reshape(-1, 3)
    values = body_distance(shapes, around, blend).reshape(6, -1)
    return ((values[:3] - values[3:]) / (2 * by)).T


def _project(shapes: Sequence[Shape], vertices: np.ndarray, step: float) -> np.ndarray:
    """Vertices of a grid moved onto the surface, by at most half a step of it."""
    start = vertices
    for _ in range(2):
        values = body_distance(shapes, vertices, _BLEND * step)
        slope = _slope(shapes, vertices, _BLEND * step, 0.1 * step)
        move = values / np.maximum(np.einsum("vx,vx->v", slope, slope), 0.25)
        vertices = vertices - move[:, None] * slope
    off = vertices - start
    far = np.linalg.norm(off, axis=1, keepdims=True)
    return start + off * np.minimum(1.0, 0.5 * step / np.maximum(far, 1e-12))


def _turns_far(joints: np.ndarray, weights: np.ndarray, turns: np.ndarray) -> bool:
    """Whether joints of one vertex turn so differently that their mean is no turn any more."""
    cosine = np.abs(np.einsum("vax,vx->va", turns[joints], turns[joints[:, 0]]))
    return bool((cosine[weights > 0] < _FAR_TURN).any())


def _unskin(
    vertices: np.ndarray,
    normals: np.ndarray,
    joints: np.ndarray,
    weights: np.ndarray,
    turns: np.ndarray,
    places: np.ndarray,
    stood: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Where each vertex was before its joints turned by ``turns`` from ``places`` to ``stood``.

    Of a rest pose that is far from the spread one each vertex goes with its first joint alone.
    """
    if _turns_far(joints, weights, turns):
        joints, weights = joints[:, :1], np.full((len(joints), 1), 255)
    matrices = np.stack([quaternion.rotate(turns, axis) for axis in np.eye(3)], axis=-1)
    shifts = stood - np.einsum("jab,jb->ja", matrices, places)
    share = weights.astype(np.float64)[..., None] / 255
    blended = (share[..., None] * matrices[joints]).sum(axis=1)
    moved = vertices - (share * shifts[joints]).sum(axis=1)
    back = np.linalg.solve(blended, moved[..., None])[..., 0]
    turned = np.einsum("vab,va->vb", blended, normals)
    return back, turned / (np.linalg.norm(turned, axis=1, keepdims=True) + 1e-12)
