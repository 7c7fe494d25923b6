"""The body that does not react: its clip goes on."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.body.spheres import BodySpheres, sphere_centres
from mgjax.core import planar
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.graph.walk import Walk, frames_at, place_edges


def edges_onward(graph: MotionGraph) -> Int[np.ndarray, " N"]:
    """The edge by which each node's clip goes on; where it does not, the first that leaves it."""
    onward = graph.out_edges[graph.out_first[:-1]]
    source = graph.edge_source[graph.out_edges]
    of_clip = graph.edge_clip[graph.out_edges] != NO_CLIP
    # The first of them, if there are several.
    onward[source[of_clip][::-1]] = graph.out_edges[of_clip][::-1]
    return onward


def walk_onward(
    graph: MotionGraph, onward: Int[np.ndarray, " N"], node: int, seconds: float
) -> Walk:
    """What is played from a node on without a reaction, for so many seconds or a little longer.

    Args:
        graph: the graph.
        onward: of :func:`edges_onward`.
        node: where the character stands.
        seconds: at natural speed.
    """
    edges = [int(onward[node])]
    frames = int(graph.edge_frames[edges[0]])
    while frames < seconds * graph.frame_rate:
        edges.append(int(onward[graph.edge_target[edges[-1]]]))
        frames += int(graph.edge_frames[edges[-1]])
    return Walk(edges=np.array(edges), scales=np.ones(len(edges)))


def spheres_onward(
    graph: MotionGraph,
    onward: Int[np.ndarray, " N"],
    spheres: BodySpheres,
    node: int,
    times: Float[np.ndarray, " K"],
) -> Float[np.ndarray, "K S 3"]:
    """Spheres of the body that does not react, in the planar frame of its node, m.

    They move straight from frame to frame, as those of the tables do.
    """
    walk = walk_onward(graph, onward, node, float(times[-1]))
    played = frames_at(graph, walk, times)
    placed = place_edges(graph, walk.edges)
    centres = [
        planar.apply(placed[edges][:, None], sphere_centres(spheres, graph.positions[frames]))
        for frames, edges in ((played.low, played.edge_low), (played.high, played.edge_high))
    ]
    share = played.share[:, None, None]
    return np.asarray(centres[0] * (1 - share) + centres[1] * share)
