"""A body as it was found in a file: its joints in one pose, with the roles that were found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from mgjax.core.body.roles import find_roles
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, cut
from mgjax.core.skeleton import Skeleton, rest_positions

_LEFT, _RIGHT, _CENTRE, _OTHER = "#2563eb", "#d97706", "#111827", "#9ca3af"


def draw_body(path: str | Path, skeleton: Skeleton, motion: Motion) -> None:
    """Draws the middle frame from the front and from the side, and the rest pose from the front.

    Left is blue, right is orange; joints without a role are grey.
    """
    middle = motion.num_frames // 2
    pose = np.asarray(global_positions(skeleton, cut(motion, middle, middle + 1)))[0]
    rest = rest_positions(skeleton)
    figure = Figure(figsize=(15, 7), layout="constrained")
    views = (
        (f"frame {middle}, along z", pose, 0),
        (f"frame {middle}, along x", pose, 2),
        ("rest pose, along z", rest, 0),
    )
    for number, axes in enumerate(figure.subplots(1, 3)):
        title, places, across = views[number]
        _draw(axes, skeleton, places[:, [across, 1]], names=number == 0)
        axes.set_title(title)
    figure.savefig(path, dpi=110)


def _draw(axes, skeleton: Skeleton, flat: np.ndarray, *, names: bool) -> None:
    roles = {joint: role for role, joint in find_roles(skeleton).items()}
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            axes.plot(*flat[[parent, joint]].T, color=_colour(roles.get(joint, "")), linewidth=2)
    for joint, role in roles.items():
        axes.plot(*flat[joint], "o", color=_colour(role), markersize=5)
        if names:
            left = not role.startswith("right")
            axes.annotate(
                f"{role}: {skeleton.names[joint]}",
                flat[joint],
                xytext=(8 if left else -8, 0),
                textcoords="offset points",
                ha="left" if left else "right",
                va="center",
                fontsize=6,
            )
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.35 if names else 0.15, 0.05)
    axes.set_xlabel("m")


def _colour(role: str) -> str:
    for side, colour in (("left", _LEFT), ("right", _RIGHT)):
        if role.startswith(side):
            return colour
    return _CENTRE if role else _OTHER
