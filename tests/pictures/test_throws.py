from __future__ import annotations

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.choice.selection import select
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.clips.synthetic import synthetic_clips
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import MotionGraph
from mgjax.pictures.throws import Throw, scene_picture


@pytest.fixture(scope="module")
def graph() -> MotionGraph:
    clips, labels = synthetic_clips()
    used = [clip for clip in clips if clip.name in ("duck", "sway")]
    labels = {clip.name: labels[clip.name] for clip in used}
    return build_graph(used, labels=labels, config=GraphConfig(threshold_m=0.05))


def throw(graph: MotionGraph, node: int, x: float, *, gravity: bool = False) -> Throw:
    attack = ball_attack(
        np.array([x, 1.4, 5.0]),
        np.array([x, 1.4, 0.0]),
        speed=10.0,
        arrives=1.2,
        gravity=gravity,
    )
    chosen = select(graph, node, attack, config=AvoidanceConfig(checks=4))
    return Throw(attack=attack, selection=chosen)


def test_picture_of_every_status(graph: MotionGraph, tmp_path: Path) -> None:
    throws: dict[str, Throw] = {}
    for node in range(0, graph.num_nodes, 7):
        found = throw(graph, node, 0.0, gravity=node % 2 == 1)
        throws.setdefault(found.selection.status, found)
        if len(throws) == 3:
            break
    throws.setdefault("no_candidate", throw(graph, 0, 8.0))  # passes far away
    assert "avoided" in throws
    for name, found in throws.items():
        path = tmp_path / f"{name}.png"
        scene_picture(path, graph, [found])  # a warning is an error here
        image = matplotlib.image.imread(path)
        assert image.shape[0] > 300
        assert image.shape[1] > 800
        assert len(np.unique(image[..., :3].reshape(-1, 3), axis=0)) > 50
    several = tmp_path / "several.png"
    scene_picture(several, graph, list(throws.values()))
    one = matplotlib.image.imread(tmp_path / "avoided.png").shape[0]
    assert matplotlib.image.imread(several).shape[0] > 1.8 * one


def test_ball_from_straight_above(graph: MotionGraph, tmp_path: Path) -> None:
    attack = ball_attack(
        np.array([0.0, 4.0, 0.0]), np.array([0.0, 1.0, 0.0]), speed=6.0, arrives=0.8
    )
    chosen = select(graph, 0, attack, config=AvoidanceConfig(checks=4))
    scene_picture(tmp_path / "a.png", graph, [Throw(attack=attack, selection=chosen)])
    assert (tmp_path / "a.png").stat().st_size > 10_000
