"""``mgjax demo``: the embedded clips, several balls, one motion."""

from __future__ import annotations

import webbrowser
from typing import Any

import numpy as np

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.checks.written import walk_motion
from mgjax.avoidance.choice.selection import select
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.cli.arguments import Demo
from mgjax.cli.avoid import describe, selection_json
from mgjax.cli.report import emit, to_json
from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.errors import ConfigError
from mgjax.core.motion import Motion
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, make_walk
from mgjax.io.bvh.write import save_bvh
from mgjax.io.output import output_folder
from mgjax.pictures.throws import Throw, scene_picture
from mgjax.stage.html import save_html
from mgjax.stage.serve.view import has_display
from mgjax.stage.show.throws import Thrown, throws_show, world_balls

HEIGHTS_M = (1.45, 0.5, 1.1, 1.55, 0.8)
"""Heights at which the balls pass, in turn: head, knees, belly."""

THRESHOLD_M = 0.05
"""Largest distance of a transition. The automatic threshold keeps every label of these clips with
a handful of transitions, and then an avoidance part is hardly ever near."""


def run(command: Demo) -> None:
    """Throws balls one after another; each is known when the motion before it is over."""
    if not 1 <= command.balls <= 100:
        raise ConfigError(f"got {command.balls} balls, expected 1 … 100")
    if command.seed < 0:
        raise ConfigError(f"got seed {command.seed}, expected 0 or more")
    with output_folder(command.out) as folder:
        clips, labels = synthetic_clips(seed=command.seed)
        graph = build_graph(clips, labels=labels, config=GraphConfig(threshold_m=THRESHOLD_M))
        throws, walk = throw_balls(graph, command.balls, command.seed)
        motion = walk_motion(graph, walk, float(walk.starts(graph)[-1]))
        save_bvh(folder / "motion.bvh", graph.skeleton, motion)
        result: dict[str, Any] = {
            "graph": {k: v for k, v in graph.report.items() if k != "seconds"},
            "balls": _balls_json(graph, motion, throws),
            "avoided": sum(t.selection.status == "avoided" for t in throws),
        }
        (folder / "result.json").write_text(to_json(result) + "\n")
        scene_picture(folder / "scene.png", graph, throws)
        show = throws_show(graph, motion, thrown(graph, throws), title="mgjax demo")
        save_html(folder / "index.html", show)
    lines = [f"ball {i}: {describe(graph, t.selection)}" for i, t in enumerate(throws, 1)]
    lines.append(f"{result['avoided']} of {command.balls} avoided; written to {command.out}")
    lines.append("throw balls yourself: mgjax view")
    emit(result, lines, as_json=command.json)
    if not command.no_browser and not command.json and has_display():
        webbrowser.open((command.out / "index.html").resolve().as_uri())


def thrown(graph: MotionGraph, throws: list[Throw]) -> list[Thrown]:
    """The throws with the second of the motion that is "now" for each."""
    found: list[Thrown] = []
    now = 0.0
    for throw in throws:
        found.append(Thrown(now=now, attack=throw.attack, selection=throw.selection))
        now += float(throw.selection.walk.starts(graph)[-1])
    return found


def _balls_json(graph: MotionGraph, motion: Motion, throws: list[Throw]) -> list[dict[str, Any]]:
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
        for throw in thrown(graph, throws)
    ]


def throw_balls(graph: MotionGraph, balls: int, seed: int) -> tuple[list[Throw], Walk]:
    """Throws ``balls`` balls from random sides at 10 m/s; the motions follow one another."""
    rng = np.random.default_rng(seed)
    # The motions follow one another where each walk ends, at natural speed in this form only; and
    # it is their walks that are joined, so none may be changed.
    config = AvoidanceConfig(warp="linear", refine="off")
    node = int(rng.integers(graph.num_nodes))
    throws: list[Throw] = []
    walks: list[Walk] = []
    for number in range(balls):
        side = rng.uniform(0, 2 * np.pi)
        attack = ball_from(float(side), graph.body_scale * HEIGHTS_M[number % len(HEIGHTS_M)])
        selection = select(graph, node, attack, config=config, seed=seed + number)
        throws.append(Throw(attack=attack, selection=selection))
        walks.append(selection.walk)
        node = int(graph.edge_target[selection.walk.edges[-1]])
    edges = np.concatenate([walk.edges for walk in walks])
    return throws, make_walk(graph, edges, np.concatenate([walk.scales for walk in walks]))
