"""A show as one small picture, where nothing can play: poses one after another, balls, lines."""

from __future__ import annotations

import io
import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from PIL import Image

from mgjax.core import quaternion
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton, rest_positions
from mgjax.stage.show.types import Actor, Body, Frames, Show

PALETTE = {
    "blue": "#0072B2",
    "orange": "#E69F00",
    "green": "#009E73",
    "purple": "#CC79A7",
    "red": "#D55E00",
    "yellow": "#F0E442",
    "sky": "#56B4E9",
    "grey": "#8A8F94",
}
_SIZE = (4.8, 2.7)
_SHARE = 0.88
"""Of the picture's height; words stand over it."""
_COLOURS = 48
_YAW, _PITCH = math.radians(-35), math.radians(14)
LIGHT = np.array([0.35, 0.75, 0.56])
_SHARES = (0.0, 0.5, 1.0)
"""Of the time, the poses that are drawn; the first ones faint."""


def still_png(show: Show) -> bytes:
    """A PNG of the show: each actor at three moments, where everything is, and its words."""
    figure = Figure(figsize=_SIZE, dpi=100)
    axes = figure.add_axes((0.0, 0.0, 1.0, _SHARE))
    seen = [np.zeros((1, 2))]
    for line in show.lines:
        flat = seen_from_the_side(line.points)[:, :2]
        axes.plot(*flat.T, color=PALETTE[line.colour], linewidth=0.6 * line.width, zorder=1)
        seen.append(flat)
    for actor in show.actors:
        seen += _draw_actor(axes, show, actor)
    for ball in show.balls:
        flat = seen_from_the_side(ball.places)[:, :2]
        axes.plot(*flat.T, color=PALETTE[ball.colour], linewidth=0.8, alpha=0.7, zorder=900)
    for thing in show.things:
        ends = [thing.place] if thing.end is None else [thing.place, thing.end]
        flat = seen_from_the_side(np.array(ends, float))[:, :2]
        axes.plot(*flat.T, "o-", color=PALETTE[thing.colour], markersize=3, zorder=800)
        seen.append(flat)
    places = np.concatenate(seen)
    _frame(axes, places)
    text = f"{show.title}: {show.words}" if show.words else show.title
    figure.text(0.02, 0.93, text[:90], fontsize=7.5, color="#1d2329")
    return _small(figure)


def _frame(axes: Axes, places: np.ndarray) -> None:
    """Limits around all places, with one scale for both directions."""
    middle = (places.max(axis=0) + places.min(axis=0)) / 2
    half = np.ptp(places, axis=0) / 2 + 0.15
    wide = _SIZE[0] / (_SIZE[1] * _SHARE)
    tall = max(float(half[1]), float(half[0]) / wide)
    axes.set_xlim(middle[0] - tall * wide, middle[0] + tall * wide)
    axes.set_ylim(middle[1] - tall, middle[1] + tall)
    axes.set_axis_off()


def _small(figure: Figure) -> bytes:
    """The picture with few colours: a fifth of the bytes."""
    whole = io.BytesIO()
    figure.savefig(whole, format="png", facecolor="white")
    small = io.BytesIO()
    with Image.open(whole) as image:
        image.convert("RGB").quantize(_COLOURS).save(small, format="png", optimize=True)
    return small.getvalue()


def _draw_actor(axes: Axes, show: Show, actor: Actor) -> list[np.ndarray]:
    body = show.bodies[actor.body]
    count = len(actor.frames.root)
    frames = sorted({round(share * (count - 1)) for share in _SHARES})
    seen: list[np.ndarray] = []
    for order, frame in enumerate(frames):
        places = skinned(body, actor.frames, frame)
        flat = seen_from_the_side(places)
        share = 1.0 if frame == frames[-1] and actor.look == "solid" else 0.35
        _draw_surface(axes, flat, body.mesh.triangles.astype(int), actor.colour, share, 10 + order)
        seen.append(flat[:, :2])
    return seen


def _draw_surface(
    axes: Axes, places: np.ndarray, triangles: np.ndarray, colour: str, share: float, order: int
) -> None:
    corners = places[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-12
    front = np.flatnonzero(normals[:, 2] > 0)
    front = front[np.argsort(corners[front, :, 2].mean(axis=1))]
    shade = 0.45 + 0.55 * np.clip(normals[front] @ LIGHT, 0, 1)
    hue = np.array([int(PALETTE[colour][i : i + 2], 16) / 255 for i in (1, 3, 5)])
    paint = 1 - share * (1 - shade[:, None] * hue)
    axes.add_collection(
        PolyCollection(
            corners[front, :, :2].tolist(), facecolors=paint, edgecolors=paint, linewidths=0.3,
            zorder=order,
        )
    )  # fmt: skip


def skinned(body: Body, frames: Frames, frame: int) -> np.ndarray:
    """The places of a body's surface in one frame, m. [V,3]"""
    turns = frames.rotations[: frame + 1]
    turns = turns.sum(axis=0, dtype=np.int16) if frames.delta else turns[-1]
    local = np.asarray(quaternion.normalise(turns.astype(np.float64) / 32767))
    return placed_surface(body, np.asarray(frames.root[frame], np.float64), local)


def placed_surface(body: Body, root: np.ndarray, local: np.ndarray) -> np.ndarray:
    """The places of a body's surface, m, in a pose of local rotations. [3], [J,4] -> [V,3]"""
    skeleton = Skeleton(
        names=tuple(body.names),
        parents=tuple(int(p) for p in body.parents),
        offsets=np.asarray(body.offsets, np.float64),
    )
    places, world = forward(skeleton, root, local)
    matrices = np.stack([quaternion.rotate(world, axis) for axis in np.eye(3)], axis=-1)
    shifts = places - np.einsum("jab,jb->ja", matrices, rest_positions(skeleton))
    mesh = body.mesh
    weights = mesh.weights.astype(np.float64)[..., None] / 255
    joints = mesh.joints.astype(int)
    blended = (weights[..., None] * matrices[joints]).sum(axis=1)
    rest = mesh.places.astype(np.float64) * mesh.unit
    return np.einsum("vab,vb->va", blended, rest) + (weights * shifts[joints]).sum(axis=1)


def seen_from_the_side(places: np.ndarray) -> np.ndarray:
    """Places as the picture sees them: to the right, up, towards the eye. [N,3]"""
    c, s = math.cos(_YAW), math.sin(_YAW)
    x, y, z = (np.asarray(places, np.float64)[:, i] for i in range(3))
    right, near = c * x - s * z, s * x + c * z
    c, s = math.cos(_PITCH), math.sin(_PITCH)
    return np.stack([right, c * y - s * near, s * y + c * near], axis=-1)
