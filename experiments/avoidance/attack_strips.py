"""Film strips of answers: the body and the ball around the moment at which they are nearest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from experiments.quality.strips import surface
from mgjax.avoidance.attacks.attack import Attack
from mgjax.core.motion import Motion, sample
from mgjax.core.skeleton import Skeleton
from mgjax.runs.experiment import Results
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.still import skinned

MOMENTS_S = (-0.42, -0.3, -0.2, -0.1, -0.04, 0.0, 0.12, 0.3, 0.58)
"""From the moment that matters."""
APART_M = 1.25
_BODY, _MET, _BALL = "#4b5563", "#c0392b", "#d97706"
_TURN = np.radians(25)


@dataclass(frozen=True, kw_only=True, eq=False)
class Strip:
    """An answer that is drawn.

    Attributes:
        title: above it.
        skeleton, motion: the body.
        attack: what comes.
        time: the moment that matters, s.
        sphere: of the attack that is looked at.
    """

    title: str
    skeleton: Skeleton
    motion: Motion
    attack: Attack
    time: float
    sphere: int = 0


def drawn_results(
    rows: list[dict[str, Any]],
    drawn: Sequence[Strip],
    wanted: int,
    line: Callable[[dict[str, Any]], str],
) -> Results:
    """Rows as metrics and lines, and some of the answers as a figure ``strips``."""
    chosen = [drawn[k] for k in spread(len(drawn), wanted)]
    return Results(
        metrics={"rows": rows, "drawn": [strip.title for strip in chosen]},
        figures={"strips": lambda: strips_figure(chosen)},
        lines=tuple(line(row) for row in rows),
    )


def strips_figure(strips: Sequence[Strip]) -> Figure:
    """Each answer in a row; the red body is that of the moment that matters."""
    rows = max(len(strips), 1)
    figure = Figure(figsize=(15, 2.9 * rows), layout="constrained")
    for axes, strip in zip(figure.subplots(rows, squeeze=False)[:, 0], strips, strict=False):
        _bodies(axes, strip)
    return figure


def spread(count: int, wanted: int) -> list[int]:
    """Numbers spread evenly over all."""
    if not count:
        return []
    return sorted(set(np.linspace(0, count - 1, min(wanted, count)).round().astype(int).tolist()))


def _bodies(axes: Axes, strip: Strip) -> None:
    """Seen a little from ahead of the ball, which comes from the left."""
    motion = strip.motion
    rate = motion.frame_rate
    moments = strip.time + np.array(MOMENTS_S)
    shown = np.clip(moments, 0, (motion.num_frames - 1) / rate)
    poses = sample(motion, shown * rate)
    body, played = body_of(strip.skeleton), frames_of(poses, rate=rate)
    triangles = body.mesh.triangles.astype(int)
    middle = np.asarray(sample(motion, np.array([strip.time * rate])).root_translation)[0]
    across, towards = _eye(strip.attack, strip.sphere, strip.time)
    balls = strip.attack.at(moments)[:, strip.sphere]
    radius = float(strip.attack.radii[strip.sphere])
    for slot, time in enumerate(moments.tolist()):
        places = skinned(body, played, slot) - middle * [1, 0, 1]
        flat = np.stack([places @ across + APART_M * slot, places[:, 1], places @ towards], axis=-1)
        met = MOMENTS_S[slot] == 0
        surface(axes, flat, triangles, _MET if met else _BODY, 10 * slot)
        ball = balls[slot] - middle * [1, 0, 1]
        if MOMENTS_S[slot] <= 0 and abs(ball @ across) < APART_M:
            at = (float(ball @ across) + APART_M * slot, float(ball[1]))
            front = float(ball @ towards) > float(flat[:, 2].mean())
            order = 10 * slot + (15 if front else 5)
            axes.add_patch(Circle(at, radius, color=_BALL, alpha=0.85, zorder=order))
        axes.text(
            APART_M * slot, -0.16, f"{1000 * (time - strip.time):+.0f} ms", fontsize=7, ha="center"
        )
    axes.axhline(0, color="#999999", linewidth=0.6)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(strip.title, fontsize=9, loc="left")
    axes.autoscale_view()


def _eye(attack: Attack, sphere: int, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors of the floor: to the right of the picture, and towards the eye."""
    step = np.diff(attack.at(np.array([time - 0.05, time]))[:, sphere], axis=0)[0] * [1, 0, 1]
    way = step / max(float(np.linalg.norm(step)), 1e-9)
    side = np.cross(way, [0.0, 1.0, 0.0])
    across = np.cos(_TURN) * way + np.sin(_TURN) * side
    return across, np.cross(across, [0.0, 1.0, 0.0])
