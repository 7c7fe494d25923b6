"""Which balls a graph avoids: the cylinder around the character that they come through."""

from __future__ import annotations

import numpy as np

from mgjax.avoidance.coverage.report import bearing
from mgjax.avoidance.coverage.shares import cells, outcomes, worst_cells
from mgjax.avoidance.coverage.throws import Coverage
from mgjax.core.body.roles import require_roles
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.planar import apply_pose, inverse
from mgjax.graph.types import MotionGraph
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Bar, Colour, Show, Thing

AROUND_M = 1.5
"""Radius of the cylinder."""
_BALL_M = 0.075
LEVELS: tuple[tuple[float, Colour, str], ...] = (
    (0.75, "blue", "blue: at least three quarters are avoided"),
    (0.5, "sky", "light blue: at least half"),
    (0.25, "yellow", "yellow: at least a quarter"),
    (0.0, "red", "red: fewer"),
)
"""From which share on a ball has which colour, and the words for it."""


def coverage_show(graph: MotionGraph, result: Coverage, *, title: str = "Coverage") -> Show:
    """A standing character with a ball for each direction and height, coloured by what is avoided.

    The character looks along +Z; a ball stands where those it stands for pass the cylinder.
    """
    masks = outcomes(result)
    share = cells(result, masks["avoided"])
    total = float(masks["avoided"].mean())
    worst = [
        f"{bearing(float(result.directions[d]))}, {result.heights[h]:g} m: {share[d, h]:.0%}"
        for d, h in worst_cells(result, 4)
    ]
    return Show(
        title=title,
        words=f"{total:.0%} of {len(result)} balls at {result.speed:g} m/s are avoided",
        seconds=0.0,
        bodies=[body_of(graph.skeleton)],
        actors=[Actor(id="body", body=0, frames=frames_of(_standing(graph)), colour="grey")],
        things=[
            _ball(result, int(direction), int(height), float(share[direction, height]))
            for direction, height in zip(*np.nonzero(~np.isnan(share)), strict=True)
        ],
        bars=[
            Bar(name=words, value=float(masks[name].mean()), colour=colour)
            for name, words, colour in _OUTCOMES
            if name != "parried" or masks[name].any()
        ],
        notes=[
            *(("a ball", words) for _, _, words in LEVELS),
            *(
                ("avoided by", f"{k}: {(result.kind == i).mean():.1%}")
                for i, k in enumerate(result.kinds)
            ),
            *(("worst served", text) for text in worst),
        ],
    )


_OUTCOMES: tuple[tuple[str, str, Colour], ...] = (
    ("avoided", "avoided", "blue"),
    ("hit", "hit", "red"),
    ("no_candidate", "no candidate", "grey"),
    ("parried", "parried", "orange"),
)


def _ball(result: Coverage, direction: int, height: int, share: float) -> Thing:
    angle = float(result.directions[direction])
    place = [AROUND_M * np.sin(angle), float(result.heights[height]), AROUND_M * np.cos(angle)]
    colour: Colour = next(colour for least, colour, _ in LEVELS if share >= least)
    return Thing(
        id=f"from{direction}at{height}",
        shape="sphere",
        place=[float(x) for x in place],
        radius=_BALL_M,
        colour=colour,
    )


def _standing(graph: MotionGraph) -> Motion:
    """The most upright pose at a node, looking along +Z."""
    frames = graph.node_frame
    places, _ = forward(
        graph.skeleton, graph.root_translation[frames], graph.local_rotations[frames]
    )
    places = np.asarray(places)
    wrists = list(require_roles(graph.skeleton, ("left_wrist", "right_wrist")))
    best = int(np.argmax((places[..., 1].max(axis=1)[:, None] - places[:, wrists, 1]).min(axis=1)))
    rotations = np.array(graph.local_rotations[frames[best]], dtype=np.float64)[None]
    root, turn = apply_pose(
        np.asarray(inverse(graph.node_plane[best].astype(np.float64))),
        np.asarray(graph.root_translation[frames[best]], np.float64)[None],
        rotations[:, 0],
    )
    rotations[:, 0] = turn
    return Motion(
        root_translation=np.asarray(root, np.float32),
        local_rotations=rotations.astype(np.float32),
        frame_rate=float(graph.frame_rate),
    )
