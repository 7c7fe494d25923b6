"""Film strips of seams: the body at some moments, and where its toes are from above."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from mgjax.core.contacts import foot_joints
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, sample
from mgjax.core.skeleton import Skeleton
from mgjax.quality.feet import CONTACT_M
from mgjax.stage.show.motion import motion_show
from mgjax.stage.still import skinned

MOMENTS = 9
APART_M = 0.8
_SEAM, _CLIP, _FEET = "#c0392b", "#4b5563", ("#2563eb", "#d97706")
_LIGHT = np.array([0.4, 0.7, 0.6])


@dataclass(frozen=True, kw_only=True, eq=False)
class Strip:
    """A seam that is drawn, with what is wrong with it."""

    title: str
    motion: Motion
    seam_s: tuple[float, float]


def strips_figure(skeleton: Skeleton, strips: Sequence[Strip]) -> Figure:
    """Each seam in a row: red bodies are blended; dots are toes in contact, a frame each."""
    figure = Figure(figsize=(15, 2.9 * max(len(strips), 1)), layout="constrained")
    grid = figure.subplots(
        max(len(strips), 1), 2, squeeze=False, gridspec_kw={"width_ratios": (4.2, 1)}
    )
    for (bodies, feet), strip in zip(grid, strips, strict=True):
        _bodies(bodies, skeleton, strip)
        _toes(feet, skeleton, strip)
    return figure


def _bodies(axes: Axes, skeleton: Skeleton, strip: Strip) -> None:
    """From the side of the way it goes, one pose beside the other."""
    frames = np.linspace(0, strip.motion.num_frames - 1, MOMENTS)
    poses = sample(strip.motion, frames)
    show = motion_show(skeleton, poses)
    body, played = show.bodies[0], show.actors[0].frames
    triangles = body.mesh.triangles.astype(int)
    middle = np.asarray(strip.motion.root_translation)[strip.motion.num_frames // 2]
    heading = _heading(strip.motion)
    for slot in range(MOMENTS):
        places = skinned(body, played, slot) - middle * [1, 0, 1]
        along = places @ heading
        towards = places @ np.cross(heading, [0, 1, 0])
        flat = np.stack([along + APART_M * slot, places[:, 1], towards], axis=-1)
        time = frames[slot] / strip.motion.frame_rate
        blended = strip.seam_s[0] < time < strip.seam_s[1]
        surface(axes, flat, triangles, _SEAM if blended else _CLIP, slot)
        axes.text(flat[:, 0].mean(), -0.16, f"{time:.2f} s", fontsize=7, ha="center")
    axes.axhline(0, color="#999999", linewidth=0.6)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(strip.title, fontsize=9, loc="left")
    axes.autoscale_view()


def _heading(motion: Motion) -> np.ndarray:
    """Unit vector on the floor along which the root moves most."""
    root = np.asarray(motion.root_translation, np.float64)[:, ::2]
    axis = np.linalg.svd(root - root.mean(axis=0))[2][0]
    axis = axis if axis @ (root[-1] - root[0]) >= 0 else -axis
    return np.array([axis[0], 0.0, axis[1]])


def surface(axes: Axes, places: np.ndarray, triangles: np.ndarray, colour: str, order: int) -> None:
    """A skinned body, as x, y and depth towards the eye, lit from above."""
    corners = places[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-12
    # The mesh may be seen mirrored: of each triangle the side that is towards the eye is lit.
    depth = corners[:, :, 2].mean(axis=1)
    nearest = np.argsort(depth)
    shade = 0.4 + 0.6 * np.abs(normals[nearest] @ _LIGHT)
    hue = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    paint = np.clip(shade[:, None] * (0.35 + 0.65 * hue), 0, 1)
    axes.add_collection(
        PolyCollection(
            corners[nearest, :, :2].tolist(),
            facecolors=paint,
            edgecolors=paint,
            linewidths=0.2,
            zorder=10 + order,
        )
    )


def _toes(axes: Axes, skeleton: Skeleton, strip: Strip) -> None:
    """From above, cm; large where they touch the floor, red rings in the seam."""
    places = np.asarray(global_positions(skeleton, strip.motion))[:, list(foot_joints(skeleton))]
    places = places - places.mean(axis=(0, 1)) * [1, 0, 1]
    times = np.arange(len(places)) / strip.motion.frame_rate
    inside = (times >= strip.seam_s[0]) & (times <= strip.seam_s[1])
    for side in range(2):
        flat = 100 * places[:, side, ::2]
        low = places[:, side, 1] < CONTACT_M
        axes.plot(*flat.T, color=_FEET[side], linewidth=0.6)
        axes.plot(*flat[low].T, ".", color=_FEET[side], markersize=4)
        axes.plot(*flat[low & inside].T, "o", color=_SEAM, markersize=5, fillstyle="none")
    axes.set_aspect("equal", adjustable="datalim")
    axes.tick_params(labelsize=6)
    axes.set_title("toes from above, cm", fontsize=7)
