"""Capsules as one mesh of triangles, each vertex with the joint that it moves with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.core import quaternion
from mgjax.core.body.rest import standing_rest
from mgjax.core.skeleton import Skeleton, rest_positions
from mgjax.io.skin.bones import Capsule, body_capsules

_AROUND, _CAP = 16, 5
"""Vertices around a capsule, and rings from a pole to where the straight part begins."""
COLOUR = (0.30, 0.47, 0.62)
"""Linear red, green and blue of the body."""


@dataclass(frozen=True, kw_only=True)
class BodyMesh:
    """A closed surface for each bone, in the rest pose whose root stands at the origin.

    Attributes:
        vertices: m. [V,3]
        normals: unit, outward. [V,3]
        joints: the one joint that each vertex moves with. [V]
        triangles: vertices, counter-clockwise as seen from outside. [T,3]
    """

    vertices: Float[np.ndarray, "V 3"]
    normals: Float[np.ndarray, "V 3"]
    joints: Int[np.ndarray, " V"]
    triangles: Int[np.ndarray, "T 3"]


def body_mesh(skeleton: Skeleton) -> BodyMesh:
    """The body of a skeleton; see :func:`mgjax.io.skin.bones.body_capsules`.

    A rest pose that does not stand tells nothing of front, side and breadth: then the body is made
    in one that does, and each capsule turned back with its joint.
    """
    standing = standing_rest(skeleton)
    capsules = body_capsules(skeleton if standing is None else standing.skeleton)
    surfaces = [_surface(capsule) for capsule in capsules]
    triangles = _triangles()
    size = len(surfaces[0][0])
    joints = np.repeat([capsule.joint for capsule in capsules], size).astype(np.int32)
    vertices = np.concatenate([vertices for vertices, _ in surfaces])
    normals = np.concatenate([normals for _, normals in surfaces])
    if standing is not None:
        back = quaternion.conjugate(standing.turns)[joints]
        places, stood = rest_positions(skeleton), rest_positions(standing.skeleton)
        vertices = places[joints] + quaternion.rotate(back, vertices - stood[joints])
        normals = np.asarray(quaternion.rotate(back, normals))
    return BodyMesh(
        vertices=vertices.astype(np.float32),
        normals=normals.astype(np.float32),
        joints=joints,
        triangles=np.concatenate([triangles + size * i for i in range(len(capsules))]),
    )


def _surface(capsule: Capsule) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and normals: the first pole, rings from there on, the last pole.

    The surface between two balls touches both where its normal has one elevation over the plane
    square to the axis: sin e = (r₀ − r₁) / length.
    """
    axis, across, over = capsule.frame()
    length = float(np.linalg.norm(capsule.end - capsule.start))
    first, last = capsule.radii
    ratio = (first - last) / length if length > 1e-9 else 0.0
    meet = float(np.arcsin(np.clip(ratio, -0.95, 0.95)))
    start = np.linspace(-np.pi / 2, meet, _CAP + 1)[1:]
    end = np.linspace(meet, np.pi / 2, _CAP + 1)[:-1]
    elevation = np.concatenate([[-np.pi / 2], start, end, [np.pi / 2]])
    radius = np.where(np.arange(len(elevation)) <= _CAP, first, last)
    along = radius * np.sin(elevation) + np.where(np.arange(len(elevation)) <= _CAP, 0, length)
    out = radius * np.cos(elevation)
    angle = 2 * np.pi * np.arange(_AROUND) / _AROUND
    u, v = np.cos(angle), np.sin(angle)
    ring = capsule.width * u[:, None] * across + capsule.depth * v[:, None] * over
    vertices = capsule.start + along[:, None, None] * axis + out[:, None, None] * ring
    sideways = u[:, None] * across / capsule.width + v[:, None] * over / capsule.depth
    normals = np.sin(elevation)[:, None, None] * axis + np.cos(elevation)[:, None, None] * sideways
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)

    def flat(values: np.ndarray) -> np.ndarray:
        return np.concatenate([values[0, :1], values[1:-1].reshape(-1, 3), values[-1, :1]])

    return flat(vertices), flat(normals)


def _triangles() -> np.ndarray:
    """Of one surface."""
    rings = 2 * _CAP
    here = np.arange(_AROUND)
    there = (here + 1) % _AROUND
    last = 1 + rings * _AROUND
    parts = [np.stack([np.zeros_like(here), 1 + there, 1 + here], axis=1)]
    for ring in range(rings - 1):
        low, high = 1 + ring * _AROUND, 1 + (ring + 1) * _AROUND
        parts.append(np.stack([low + here, low + there, high + there], axis=1))
        parts.append(np.stack([low + here, high + there, high + here], axis=1))
    top = 1 + (rings - 1) * _AROUND
    parts.append(np.stack([top + here, top + there, np.full_like(here, last)], axis=1))
    return np.concatenate(parts)
