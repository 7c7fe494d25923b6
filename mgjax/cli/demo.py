"""``mgjax demo``: the embedded clips, several balls, one motion."""

from __future__ import annotations

import webbrowser
from dataclasses import replace
from typing import Any

import numpy as np

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.transform import in_frame
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.selection import select
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.play.several_attacks import played_clearance
from mgjax.avoidance.play.timeline import Piece, Timeline
from mgjax.avoidance.rates import CLEAR_M, EXPORT_RATE
from mgjax.cli.arguments import Demo
from mgjax.cli.avoid import describe, selection_json
from mgjax.cli.report import emit, seams_json, to_json
from mgjax.clips.synthetic import synthetic_clips
from mgjax.core import planar
from mgjax.core.errors import ConfigError
from mgjax.core.motion import Motion
from mgjax.graph.build import build_graph
from mgjax.graph.config import EMBEDDED
from mgjax.graph.feet.course import turned
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk
from mgjax.io.bvh.write import save_bvh
from mgjax.io.output import output_folder
from mgjax.pictures.throws import Throw, scene_picture
from mgjax.stage.html import save_html
from mgjax.stage.serve.view import has_display
from mgjax.stage.show.throws import Thrown, throws_show, world_balls

HEIGHTS_M = (1.45, 0.5, 1.1, 1.55, 0.8)
"""Heights at which the balls pass, in turn: head, knees, belly."""


def run(command: Demo) -> None:
    """Throws balls one after another; each is known when the motion before it is over."""
    if not 1 <= command.balls <= 100:
        raise ConfigError(f"got {command.balls} balls, expected 1 … 100")
    if command.seed < 0:
        raise ConfigError(f"got seed {command.seed}, expected 0 or more")
    with output_folder(command.out) as folder:
        clips, labels = synthetic_clips(seed=command.seed)
        graph = build_graph(clips, labels=labels, config=EMBEDDED)
        throws, motion, walk = throw_balls(graph, command.balls, command.seed)
        starts = walk.starts(graph)
        save_bvh(folder / "motion.bvh", graph.skeleton, motion)
        result: dict[str, Any] = {
            "graph": {k: v for k, v in graph.report.items() if k != "seconds"},
            "balls": _balls_json(graph, motion, throws),
            "seams": seams_json(graph, walk.edges, starts, float(starts[-1])),
            "avoided": sum(t.selection.status == "avoided" for t in throws),
        }
        (folder / "result.json").write_text(to_json(result) + "\n")
        pictured = [Throw(attack=t.attack, selection=t.selection) for t in throws]
        scene_picture(folder / "scene.png", graph, pictured)
        show = throws_show(graph, motion, throws, title="mgjax demo")
        save_html(folder / "index.html", show)
    lines = [f"ball {i}: {describe(graph, t.selection)}" for i, t in enumerate(throws, 1)]
    lines.append(f"{result['avoided']} of {command.balls} avoided; written to {command.out}")
    lines.append("throw balls yourself: mgjax view")
    emit(result, lines, as_json=command.json)
    if not command.no_browser and not command.json and has_display():
        webbrowser.open((command.out / "index.html").resolve().as_uri())


def _balls_json(graph: MotionGraph, motion: Motion, throws: list[Thrown]) -> list[dict[str, Any]]:
    """Each answer, with the second of the motion that is its "now", and the ball's flight."""
    return [
        {
            "now_s": throw.now,
            "flight": [
                {
                    "radius_m": ball.radius,
                    "times_s": ball.times.tolist(),
                    "places_m": ball.places.tolist(),
                }
                for ball in world_balls(graph, motion, throw, "ball")
            ],
            **selection_json(graph, throw.selection),
        }
        for throw in throws
    ]


def throw_balls(graph: MotionGraph, balls: int, seed: int) -> tuple[list[Thrown], Motion, Walk]:
    """Throws ``balls`` balls from random sides at 10 m/s; the motions follow one another.

    What came of each is said of the one motion that they make, and checked on it.
    """
    rng = np.random.default_rng(seed)
    # The motions follow one another where each walk ends, at natural speed in this form only; and
    # it is their walks that are joined, so none may be changed.
    config = AvoidanceConfig(warp="linear", refine="off")
    line = Timeline(graph, int(rng.integers(graph.num_nodes)))
    throws: list[Thrown] = []
    for number in range(balls):
        side = rng.uniform(0, 2 * np.pi)
        attack = ball_from(float(side), graph.body_scale * HEIGHTS_M[number % len(HEIGHTS_M)])
        place, now = line.frame_at_end(), line.end
        feet = turned(line.feet_at_end(), -float(place[0]))
        selection = select(graph, line.node, attack, config=config, seed=seed + number, begin=feet)
        throws.append(Thrown(now=now, attack=attack, selection=selection, place=place))
        for edge, scale in zip(selection.walk.edges, selection.walk.scales, strict=True):
            line.append(int(edge), float(scale))
    times = np.arange(int(np.ceil(line.end * EXPORT_RATE - 1e-6)) + 1) / EXPORT_RATE
    motion = replace(line.sample(times), frame_rate=EXPORT_RATE)
    piece = line.between(0.0, line.end, feet=True)
    return [_checked(graph, piece, throw) for throw in throws], motion, line.walk()


def _checked(graph: MotionGraph, piece: Piece, throw: Thrown) -> Thrown:
    """A throw with what came of it in the whole motion."""
    chosen = throw.selection
    if chosen.part is None or throw.place is None:
        return throw
    inverse = np.asarray(planar.inverse(throw.place))
    attack = in_frame(throw.attack, inverse, -throw.now)
    gap = played_clearance(graph, piece, attack, throw.now)
    status = Status.AVOIDED if gap >= CLEAR_M else Status.HIT
    return replace(throw, selection=replace(chosen, status=status, clearance_m=gap))
