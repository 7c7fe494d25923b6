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
    edge = onward.item(node)
    edges, frames, wanted = [edge], graph.edge_frames.item(edge), seconds * graph.frame_rate
    while frames < wanted:
        edge = onward.item(graph.edge_target.item(edge))
        edges.append(edge)
        frames += graph.edge_frames.item(edge)
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
    # Both frames of each moment at once: these are small arrays, and calls cost most.
    frames = np.concatenate([played.low, played.high])
    edges = np.concatenate([played.edge_low, played.edge_high])
    joints = graph.positions[frames]
    centres = np.asarray(planar.apply(placed[edges][:, None], sphere_centres(spheres, joints)))
    low, high = centres[: len(times)], centres[len(times) :]
    share = played.share[:, None, None]
    return low * (1 - share) + high * share
