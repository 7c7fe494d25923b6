"""Graphs made by hand, and random throws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.body.edge_tables import EdgeTables
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.clips.synthetic import synthetic_skeleton
from mgjax.core.kinematics import planar_frames
from mgjax.core.motion import Motion
from mgjax.core.timing.time_warp import TimeWarp
from mgjax.graph.transition import frame_positions
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, sample_walk

TARGET_RATE = 30.0


def make_graph(
    links: list[tuple[int, int, int]],
    parts: list[tuple[int, int, int]],
    *,
    seed: int = 0,
    sway: float = 0.03,
) -> MotionGraph:
    """A graph with the given edges, each with smooth random motion and a random exit of its own.

    Args:
        links: (source, target, frames) of each edge.
        parts: (edge, first frame, stop frame) of each avoidance part, counted within its edge.
        seed: of the motion.
        sway: how far joints turn from frame to frame, rad.
    """
    rng = np.random.default_rng(seed)
    skeleton = synthetic_skeleton()
    source, target, frames = (np.array(column) for column in zip(*links, strict=True))
    nodes = int(max(source.max(), target.max())) + 1
    lengths = frames + 1
    starts = np.cumsum(lengths) - lengths
    count = int(lengths.sum())
    turns = np.cumsum(rng.normal(scale=sway, size=(count, skeleton.num_joints, 3)), axis=0)
    rotations = np.concatenate([np.ones((*turns.shape[:2], 1)), 0.5 * np.sin(turns)], axis=-1)
    rotations[:, list(skeleton.end_joints)] = (1, 0, 0, 0)
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    root = np.cumsum(rng.normal(scale=0.01, size=(count, 3)), axis=0) * (1, 0.1, 1) + (0, 1, 0)
    root, rotations = root.astype(np.float32), rotations.astype(np.float32)
    order = np.argsort(source, kind="stable")
    first_frames = starts[[int(np.argmax(source == n)) for n in range(nodes)]]
    positions = frame_positions(skeleton, root, rotations)
    exits = rng.uniform(-1, 1, size=(len(links), 3)).astype(np.float32)
    edges, begins, stops = (np.array([p[i] for p in parts], np.int64) for i in range(3))
    return MotionGraph(
        skeleton=skeleton,
        frame_rate=TARGET_RATE,
        window=10,
        root_translation=root,
        local_rotations=rotations,
        clip_names=("made",),
        clip_starts=np.array([0]),
        clip_stops=np.array([count]),
        node_frame=first_frames,
        node_clip=np.zeros(nodes, np.int64),
        node_plane=np.asarray(planar_frames(skeleton, positions[first_frames]), np.float32),
        edge_source=source,
        edge_target=target,
        edge_starts=starts,
        edge_stops=starts + frames,
        edge_clip=np.zeros(len(links), np.int64),
        edge_exit=exits,
        edge_distance=np.zeros(len(links), np.float32),
        out_first=np.concatenate([[0], np.cumsum(np.bincount(source, minlength=nodes))]),
        out_edges=order,
        label_edge=edges,
        label_starts=starts[edges] + begins,
        label_stops=starts[edges] + stops,
        label_kind=("duck",) * len(parts),
        label_direction=("",) * len(parts),
        label_genuine=np.ones(len(parts), bool),
        report={},
    )


def random_graph(seed: int, *, nodes: int = 5, edges: int = 11, parts: int = 6) -> MotionGraph:
    """A random small graph in which every node can be left; also with parallel edges and loops."""
    rng = np.random.default_rng(seed)
    links = [(n, int(rng.integers(nodes)), int(rng.integers(4, 25))) for n in range(nodes)]
    links += [
        (int(rng.integers(nodes)), int(rng.integers(nodes)), int(rng.integers(1, 25)))
        for _ in range(edges - nodes)
    ]
    found: list[tuple[int, int, int]] = []
    for _ in range(parts):
        edge = int(rng.integers(len(links)))
        begin = int(rng.integers(0, links[edge][2]))
        found.append((edge, begin, int(rng.integers(begin + 1, links[edge][2] + 1))))
    return make_graph(links, found, seed=seed)


def throw(
    rng: np.random.Generator,
    *,
    speed: float = 10.0,
    arrives: float = 1.2,
    height: float | None = None,
    **more: bool,
) -> Attack:
    """A ball from 5 m away, from any side, at the vertical above the character."""
    side = rng.uniform(0, 2 * np.pi)
    drawn = rng.uniform(0.5, 1.7)
    return ball_from(
        side, drawn if height is None else height, speed=speed, arrives=arrives, **more
    )


def with_knots(attack: Attack, count: int) -> Attack:
    """The same attack with evenly spaced knots."""
    times = np.linspace(attack.start, attack.end, count)
    return replace(attack, times=times, centres=attack.at(times))


def captured_motion(
    graph: MotionGraph, walk: Walk, seconds: float, warp: TimeWarp | None = None
) -> Motion:
    """The motion of a walk as captured, at the rate at which it is written: its feet not kept."""
    times = np.arange(max(int(np.ceil(seconds * EXPORT_RATE - 1e-6)) + 1, 2)) / EXPORT_RATE
    if warp is None:
        return sample_walk(graph, walk, times)
    plain = Walk(edges=walk.edges, scales=np.ones(len(walk.edges)))
    return replace(sample_walk(graph, plain, warp.at(times)), frame_rate=EXPORT_RATE)


def natural_times(tables: EdgeTables, candidates: Candidates) -> np.ndarray:
    """t_avoid of each candidate at natural speed, s from the beginning of its walk. [C]"""
    column = np.arange(candidates.edges.shape[1])
    before = column[None] < candidates.length[:, None] - 1
    seconds = np.where(before, tables.seconds[np.maximum(candidates.edges, 0)], 0.0)
    return seconds.sum(axis=1) + tables.part_centre[candidates.part]
