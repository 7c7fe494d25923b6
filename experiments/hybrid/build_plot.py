"""Figures of the experiment on building, as in the paper."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from mgjax.clips.types import Clip
from mgjax.core import planar
from mgjax.core.body.height import body_scale
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import resample
from mgjax.graph.build import joint_weights
from mgjax.graph.config import GraphConfig
from mgjax.graph.distances.distance import distance_matrix
from mgjax.graph.distances.minima import find_minima
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.config import PathConfig, path_for_body
from mgjax.hybrid.macro.macro_edges import build_macro_edges
from mgjax.hybrid.paths.beam import run_beam
from mgjax.hybrid.paths.branch_and_bound import branch_and_bound
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.frontier import NO_RECORD, Search
from mgjax.hybrid.paths.kernel import make_request
from mgjax.hybrid.paths.result import PathResult, place_pieces
from mgjax.hybrid.paths.sketch import Sketch
from mgjax.pictures.walk import top_view


def error_figure(pair: tuple[Clip, Clip], config: GraphConfig) -> Figure:
    """The 2-D error function of two clips with its minima, and the weights of the joints."""
    clips = [resample(clip.motion, config.frame_rate) for clip in pair]
    skeleton = pair[0].skeleton
    a, b = (np.asarray(global_positions(skeleton, m), dtype=np.float32) for m in clips)
    window = round(config.window_s * config.frame_rate)
    weights = joint_weights(skeleton, config.weights)
    values = np.asarray(distance_matrix(a, b, window=window, weights=weights))
    both = np.concatenate([a, b])
    minima = find_minima(
        both,
        np.array([0, len(a)]),
        np.array([len(a), len(both)]),
        weights,
        window=window,
        neighbourhood=config.neighbourhood,
        threshold=body_scale(skeleton) * (config.threshold_m or config.max_threshold_m),
    )
    across = (minima.rows < len(a)) & (minima.columns >= len(a))
    figure = Figure(figsize=(12, 5.5), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1))
    image = left.imshow(values, cmap="gray_r", aspect="auto", interpolation="nearest")
    left.plot(minima.columns[across] - len(a), minima.rows[across], ".", color="#c0392b")
    figure.colorbar(image, ax=left, label="distance, m RMS")
    left.set(xlabel=f"window start in {pair[1].name}", ylabel=f"window start in {pair[0].name}")
    left.set_title(f"2-D error function, {int(across.sum())} minima below the threshold")
    counted = np.flatnonzero(weights)
    right.barh([skeleton.names[j] for j in counted], weights[counted], color="#1f6fb4")
    right.invert_yaxis()
    right.tick_params(labelsize=7)
    right.set_title("weights of the joints")
    return figure


def fewer_figure(sketch: Sketch, walks: dict[str, tuple[MotionGraph, PathResult]]) -> Figure:
    """The same path with all clips and with fewer."""
    figure = Figure(figsize=(6 * len(walks), 7), layout="constrained")
    for axes, (name, (graph, walked)) in zip(
        figure.subplots(1, len(walks)), walks.items(), strict=True
    ):
        top_view(axes, graph, sketch, walked)
        axes.set_title(
            f"{name}: {graph.report['clips']} clips, {walked.status}, mean"
            f" {100 * walked.mean_distance:.1f} cm, largest {100 * walked.largest_distance:.1f} cm",
            fontsize=9,
        )
    return figure


def unrolled_figure(graph: MotionGraph, sketch: Sketch, config: PathConfig) -> Figure:
    """The partial walks that one horizon of the exact search remembers, and the best of them."""
    curve = make_curve(sketch, graph.body_scale)
    request = make_request(curve, sketch, path_for_body(config, graph.body_scale))
    search = Search(macro_edges=build_macro_edges(graph), request=request)
    state = np.zeros((graph.num_nodes, 5), dtype=np.float32)
    state[:, :3] = curve.start()
    begin = search.begin(state, np.arange(graph.num_nodes))
    horizon = round(config.horizon_s * graph.frame_rate)
    first = run_beam(search, begin, width=config.beam_width, horizon=horizon)
    terminal = first.best or first.farthest
    origin, _ = search.chain(terminal.record, terminal.macro_edge)
    begin = begin.pick(begin.record == origin)
    best, _, _ = branch_and_bound(
        search, begin, horizon=horizon, best=first.best, expansions=config.expansions
    )
    terminal = best or terminal
    _, pieces = search.chain(terminal.record, terminal.macro_edge)
    root = place_pieces(graph, search.macro_edges.pieces, pieces, curve.start()).places
    figure = Figure(figsize=(8, 8), layout="constrained")
    axes = figure.subplots()
    axes.set_facecolor("#222")
    lines = _unrolled(search, curve.start())
    axes.add_collection(LineCollection(lines, colors="white", linewidths=0.3, alpha=0.35))
    axes.plot(*curve.points.T, color="#f1c40f", linewidth=3, label="sketch")
    axes.plot(*root.T, color="#e74c3c", linewidth=1.5, label="best walk of this horizon")
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.invert_xaxis()
    axes.set(xlabel="x, m", ylabel="z, m")
    axes.set_title(f"{len(lines)} partial walks remembered, {search.expanded} extended", fontsize=9)
    axes.legend(loc="best", fontsize=8)
    return figure


def _unrolled(search: Search, start: np.ndarray) -> list[np.ndarray]:
    """The root over every macro edge that was remembered, in the world; a parent comes first."""
    parents, macro_edges = search.recorded()
    tables = search.macro_edges
    tracks = np.asarray(tables.track)
    places = np.zeros((len(parents), 3))
    lines = []
    for record, (parent, macro_edge) in enumerate(
        zip(parents.tolist(), macro_edges.tolist(), strict=True)
    ):
        if parent == NO_RECORD:
            places[record] = start
            continue
        own = tracks[macro_edge, :2, : tables.frames[macro_edge]].astype(np.float64)
        flat = np.stack([own[0], 0 * own[0], own[1]], axis=-1)
        root = np.asarray(planar.apply(places[parent], flat))[:, ::2]
        lines.append(np.concatenate([places[parent][None, 1:], root]))
        places[record] = planar.compose(places[parent], tables.end[macro_edge])
    return lines
