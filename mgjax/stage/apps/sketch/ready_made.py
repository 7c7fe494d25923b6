"""Ready-made paths: one click, and somebody walks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.hybrid.reaching.targets import make_target
from mgjax.stage.apps.sketch.drawing import Drawing, Path
from mgjax.stage.apps.sketch.edits import replace_path, with_targets

NAMES = ("line", "s_curve", "circle", "square", "eight", "reaches")
"""``reaches`` is an S-curve with something for a hand and a bar to duck under."""


def ready_made(drawing: Drawing, name: str, height: float) -> Drawing:
    """The drawing with one of :data:`NAMES` instead of its path, without obstacles.

    Targets go as well; those of ``reaches`` are for a body of that height, m.
    """
    bare = replace(drawing, obstacles=(), goals=(), smooth=name not in ("line", "square"))
    made = replace_path(bare, _path(name))
    if name != "reaches":
        return made
    side, over = round(0.72 * height, 3), round(0.81 * height, 3)
    return with_targets(
        made,
        [
            make_target("right_hand", place=[0.35, side, 1.6], when="passing"),
            make_target("head", bar=([-0.8, over, 3.1], [0.8, over, 3.1], 0.03)),
        ],
    )


def _path(name: str) -> Path:
    turn = np.linspace(0, 2 * np.pi, 25)[:-1]
    if name == "line":
        return Path(points=np.array([[0.0, 0.0], [0.0, 3.0], [0.0, 6.0]]))
    if name in ("s_curve", "reaches"):
        bend = [[0.0, 0.0], [0.9, 1.5], [0.0, 3.0], [-0.9, 4.5], [0.0, 6.0]]
        return Path(points=np.array(bend), spline=True)
    if name == "circle":
        ring = np.stack([1.8 - 1.8 * np.cos(turn), 1.8 * np.sin(turn)], axis=1)
        return Path(points=np.round(ring, 3), spline=True, closed=True)
    if name == "square":
        corners = [[0.0, 0.0], [0.0, 2.4], [2.4, 2.4], [2.4, 0.0]]
        return Path(points=np.array(corners), closed=True)
    eight = np.stack([1.5 * np.sin(2 * turn), 2.4 * np.sin(turn)], axis=1)
    return Path(points=np.round(eight, 3), spline=True, closed=True)
