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


def bodies_onward(
    graph: MotionGraph,
    onward: Int[np.ndarray, " N"],
    spheres: BodySpheres,
    nodes: Int[np.ndarray, " B"],
    times: Float[np.ndarray, "B K"],
) -> Float[np.ndarray, "B 3 K S"]:
    """What :func:`spheres_onward` says, at many nodes or times at once, components before moments.

    A node's walk is laid out once, however many bodies begin there.

    Args:
        graph, onward, spheres: see :func:`spheres_onward`.
        nodes: where each body begins.
        times: ascending, s.
    """
    wanted = times[:, -1] * graph.frame_rate
    own, of_node = np.unique(nodes, return_inverse=True)
    longest = np.zeros(len(own))
    np.maximum.at(longest, of_node, wanted)
    rows, frames = [onward[own]], graph.edge_frames[onward[own]]
    ends = [frames]
    while (ends[-1] < longest).any():
        rows.append(onward[graph.edge_target[rows[-1]]])
        ends.append(ends[-1] + graph.edge_frames[rows[-1]])
    edges = np.stack(rows)
    seconds = np.cumsum(graph.edge_frames[edges] / graph.frame_rate, axis=0)
    begins = np.concatenate([np.zeros((1, len(own))), seconds])[:, of_node]
    count = 1 + (np.stack(ends)[:, of_node] < wanted).sum(axis=0)
    body = np.arange(len(nodes))
    within = np.minimum(np.maximum(times, 0.0), begins[count, body][:, None])
    index = np.full(times.shape, -1)
    for begin in begins:
        index += begin[:, None] <= within
    index = np.minimum(index, count[:, None] - 1)
    column = of_node[:, None]
    edge = edges[index, column]
    steps = graph.edge_frames[edge]
    local = (within - begins[index, body[:, None]]) * graph.frame_rate
    local = np.minimum(np.maximum(local, 0.0), steps)
    step = np.minimum(local.astype(np.int64), steps - 1)
    crosses = (step == steps - 1) & (index + 1 < count[:, None])
    after = np.minimum(index + crosses, count[:, None] - 1)
    low = graph.edge_starts[edge] + step
    high = np.where(crosses, graph.edge_starts[edges[after, column]], low + 1)
    placed = _placed(graph, edges)
    share = (local - step)[:, None, :, None]
    bodies = _placed_spheres(graph, spheres, low, placed[:, index, column]) * (1 - share)
    bodies += _placed_spheres(graph, spheres, high, placed[:, after, column]) * share
    return bodies


def _placed(graph: MotionGraph, edges: Int[np.ndarray, "M N"]) -> Float[np.ndarray, "3 M N"]:
    """What :func:`~mgjax.graph.walk.place_edges` says of many walks."""
    here = np.asarray(planar.inverse(graph.node_plane[graph.edge_source[edges[0]]].astype(float)))
    places = [here]
    for row in edges[:-1]:
        here = np.asarray(planar.compose(here, graph.edge_exit[row].astype(float)))
        places.append(here)
    return np.moveaxis(np.stack(places), 2, 0)


def _placed_spheres(
    graph: MotionGraph,
    spheres: BodySpheres,
    frames: Int[np.ndarray, "B K"],
    place: Float[np.ndarray, "3 B K"],
) -> Float[np.ndarray, "B 3 K S"]:
    """The spheres of frames, each frame at a place of its own."""
    used, row = np.unique(frames, return_inverse=True)
    centres = np.moveaxis(np.asarray(sphere_centres(spheres, graph.positions[used])), 2, 0)
    x, y, z = centres[:, row.reshape(frames.shape)]
    turn, to_x, to_z = place[..., None]
    c, s = np.cos(turn), np.sin(turn)
    return np.stack([x * c + z * s + to_x, y, z * c - x * s + to_z], axis=1)
