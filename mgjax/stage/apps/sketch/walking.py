"""The graph that sketches are walked on, and the programs that are compiled before the first."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mgjax.clips.folder import load_clips
from mgjax.clips.synthetic_turns import synthetic_turns
from mgjax.clips.synthetic_walks import synthetic_walks
from mgjax.core.body.height import body_height
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.files import load_graph
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import make_walk, sample_walk
from mgjax.hybrid.paths.search import follow
from mgjax.hybrid.paths.sketch import make_sketch
from mgjax.hybrid.prepared import Prepared
from mgjax.hybrid.reaching.targets import make_target
from mgjax.hybrid.reaching.walk import reach
from mgjax.stage.apps.sketch.edits import BAR_RADIUS_M
from mgjax.stage.apps.sketch.solve import QUICK
from mgjax.stage.serve.session import Progress

TURNS_DEG = (45, -45, 90, -90, 180, -180)
_EMBEDDED = GraphConfig(threshold_m=0.1, neighbourhood=3)
_CAPTURE = GraphConfig(neighbourhood=5)
"""Of minima within 1/6 s only the lowest: the exact search has a third fewer ways at every step."""


def walking_graph(graph: Path | None, clips: Path | None) -> MotionGraph:
    """The graph of a folder, else of the clips of a folder, else of procedural walks and turns.

    Raises:
        FileFormatError, GraphError: of what the folders hold.
    """
    if graph is not None:
        return load_graph(graph)
    if clips is not None:
        return build_graph(load_clips(clips)[0], config=_CAPTURE)
    return build_graph(synthetic_walks() + synthetic_turns(TURNS_DEG, frame_rate=30.0),
                       config=_EMBEDDED)  # fmt: skip


def height_of(skeleton: Skeleton) -> float:
    """The body's height, m, or what is usual where the skeleton does not show it."""
    return body_height(skeleton) or 1.7


def standing_pose(graph: MotionGraph) -> Motion:
    """The first pose of the graph, over the origin."""
    edge = int(graph.out_edges[0])
    return sample_walk(graph, make_walk(graph, [edge]), np.zeros(1), start=np.zeros(3))


def warm(graph: MotionGraph, prepared: Prepared, progress: Progress, share: float) -> None:
    """Walks a short path, around an obstacle too, reaches and ducks, so that the first is quick.

    Args:
        graph, prepared: what is to be warm.
        progress: told what is done, from ``share`` to 1.
    """
    points = [[0.0, 0.0], [0.0, 1.5], [0.0, 3.0]]
    progress(share, "a first walk")
    sketch = make_sketch(points)
    walked = follow(graph, sketch, config=QUICK, prepared=prepared)
    follow(graph, sketch, prepared=prepared)
    follow(graph, make_sketch(points, obstacles=[(2.0, 1.5, 0.2)]), config=QUICK, prepared=prepared)
    x, z = walked.track.places[len(walked.track.places) // 2].tolist()
    progress(0.5 * (1 + share), "a first reach")
    height = height_of(graph.skeleton)
    for limb in ("right_hand", "left_hand"):
        target = make_target(limb, place=[x, 0.7 * height, z + 0.3], when="passing")
        reach(graph, sketch, (target,), path=QUICK, walked=walked, prepared=prepared)
    progress(0.2 * share + 0.8, "a first duck")
    left, right = ([x + side, 0.8 * height, z] for side in (-1.0, 1.0))
    bar = make_target("head", bar=(left, right, BAR_RADIUS_M))
    reach(graph, sketch, (bar,), path=QUICK, walked=walked, prepared=prepared)


def warm_head(graph: MotionGraph, prepared: Prepared) -> None:
    """Compiles the reach of a head, which takes longest and is asked for least."""
    sketch = make_sketch([[0.0, 0.0], [0.0, 1.5], [0.0, 3.0]])
    place = [0.0, 0.8 * height_of(graph.skeleton), 1.5]
    target = make_target("head", place=place, when="passing")
    reach(graph, sketch, (target,), path=QUICK, prepared=prepared)
