"""Path synthesis: the walk whose root follows a sketched path (hybrid paper eqs 6–7).

Depth-first branch and bound over a bounded horizon, after Kovar, Gleicher and Pighin (2002): find
the best walk of the next 4 s, keep its first second, look again from there. A beam over the same
horizon gives the first walk to beat, so most of the search is proving that there is no better one.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from jaxtyping import Float

from mgjax.core.errors import ConfigError, PathError
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.config import WIDEST, PathConfig, path_for_body, validate_path_config
from mgjax.hybrid.paths.beam import Beam, run_beam
from mgjax.hybrid.paths.branch_and_bound import branch_and_bound
from mgjax.hybrid.paths.curve import Curve, make_curve
from mgjax.hybrid.paths.frontier import UNBOUNDED, Frontier, Search, Terminal, concatenate
from mgjax.hybrid.paths.kernel import compile_kernels, make_request
from mgjax.hybrid.paths.result import PathResult, measure_walk, place_pieces
from mgjax.hybrid.paths.sketch import Sketch
from mgjax.hybrid.prepared import Prepared, prepared_for

SLOWEST_M_S = 0.1
"""An adult's walk may take as long as at this speed, and 10 s more."""

PlanarFrame: TypeAlias = Float[np.ndarray, "3"]


@dataclass(kw_only=True)
class _Run:
    """One request with its state, its times and its counts."""

    graph: MotionGraph
    prepared: Prepared
    sketch: Sketch
    curve: Curve
    config: PathConfig
    search: Search
    start: PlanarFrame
    deadline: float
    begun: float
    prepare_s: float
    windows: int = 0
    proven: int = 0

    @property
    def longest(self) -> int:
        seconds = self.curve.length / (self.curve.scale * SLOWEST_M_S) + 10.0
        return min(round(seconds * self.graph.frame_rate), UNBOUNDED)


def follow(
    graph: MotionGraph,
    sketch: Sketch,
    *,
    config: PathConfig | None = None,
    node: int | None = None,
    start: PlanarFrame | None = None,
    prepared: Prepared | None = None,
) -> PathResult:
    """The walk along a sketched path.

    Args:
        graph: with locomotion.
        sketch: the path and what is wanted of the walk.
        config: settings.
        node: where in the graph the walk begins; None: wherever is best.
        start: planar frame of the body at the beginning; None: on the first point of the path,
            facing along it.
        prepared: of :func:`mgjax.hybrid.prepare`; None: computed once for each graph, and kept for
            the graphs used last.

    Raises:
        ConfigError: a setting out of range.
        PathError: the walk would begin too far from the path, or inside an obstacle.
        GraphError: no walk of the graph gets anywhere.
    """
    config = config or PathConfig()
    validate_path_config(config)
    if node is not None and not 0 <= node < graph.num_nodes:
        raise ConfigError(got=f"node {node}", expected=f"0 … {graph.num_nodes - 1}")
    entered = time.perf_counter()
    config = path_for_body(config, graph.body_scale)
    curve = make_curve(sketch, graph.body_scale)
    place = curve.start() if start is None else np.asarray(start, dtype=np.float64)
    _check_start(sketch, curve, place, config)
    prepared = prepared_for(graph, prepared=prepared)
    request = make_request(curve, sketch, config)
    compile_kernels(prepared.macro_edges, request)
    begun = time.perf_counter()
    limit = config.time_limit_s or math.inf
    run = _Run(
        graph=graph,
        prepared=prepared,
        sketch=sketch,
        curve=curve,
        config=config,
        search=Search(macro_edges=prepared.macro_edges, request=request),
        start=place,
        deadline=begun + limit,
        begun=begun,
        prepare_s=begun - entered,
    )
    stops = np.arange(graph.num_nodes) if node is None else np.array([node])
    state = np.zeros((len(stops), 5), dtype=np.float32)
    state[:, :3] = place
    begin = run.search.begin(state, stops)
    if config.method == "exact":
        return _receding_horizon(run, begin)
    terminal, interrupted = _best_of_beams(run, begin)
    return _finish(run, begin, terminal, interrupted)


def _check_start(sketch: Sketch, curve: Curve, start: PlanarFrame, config: PathConfig) -> None:
    off = float(np.linalg.norm(start[1:] - curve.points[0]))
    if not off <= config.near_m:
        raise PathError(
            f"got a walk that begins {off:.2f} m from the path, expected at most"
            f" {config.near_m:.3g}"
        )
    for x, z, radius in sketch.obstacles:
        if math.hypot(start[1] - x, start[2] - z) < radius + config.margin_m:
            raise PathError(
                f"got an obstacle at ({x:g}, {z:g}) over the beginning of the path, expected a"
                f" free one ({radius:g} m radius and {config.margin_m:.3g} m margin)"
            )


def _best_of_beams(run: _Run, begin: Frontier) -> tuple[Terminal, bool]:
    """The best walk of beams over the whole path, and whether the time was over.

    A beam that finds no way is followed by one four times as wide. With a time limit they go on
    after the first complete walk, as long as each finds a better one.
    """
    best: Terminal | None = None
    farthest: Terminal | None = None
    arc, width = -1.0, run.config.beam_width
    while True:
        beam = run_beam(run.search, begin, width=width, horizon=run.longest, deadline=run.deadline)
        terminal = beam.best if beam.best is not None and beam.best.complete else None
        gained = terminal is not None and (best is None or terminal.cost < best.cost)
        if gained:
            best = terminal
        if beam.arc > arc:
            farthest, arc = beam.farthest, beam.arc
        enough = best is not None and not (gained and math.isfinite(run.deadline))
        if beam.interrupted or enough or width >= WIDEST:
            chosen = best or farthest
            assert chosen is not None  # every beam has a farthest walk
            return chosen, beam.interrupted
        width = min(4 * width, WIDEST)


def _finish(run: _Run, begin: Frontier, terminal: Terminal, interrupted: bool) -> PathResult:
    _, pieces = run.search.chain(terminal.record, terminal.macro_edge)
    parts = run.prepared.macro_edges.pieces
    if not pieces:  # lost at the first step: one frame of it
        pieces = [int(parts.out[parts.out_first[begin.stop[0]]])]
    return measure_walk(
        run.graph,
        run.prepared,
        run.curve,
        run.sketch,
        pieces=pieces,
        frames=max(terminal.frames, 1),
        start=run.start,
        status="followed" if terminal.complete else "time_limit" if interrupted else "lost",
        interrupted=interrupted,
        prepare_s=run.prepare_s,
        search_s=time.perf_counter() - run.begun,
        expanded=run.search.expanded,
        pruned=run.search.pruned,
        windows=run.windows,
        proven=run.proven,
    )


def _receding_horizon(run: _Run, begin: Frontier) -> PathResult:
    """Horizon after horizon; each is searched from where the last one's first part ends.

    Where every walk strays within a horizon, beams over the whole path look for another way.
    """
    search, config, rate = run.search, run.config, run.graph.frame_rate
    keep = round(config.keep_s * rate)
    everywhere = begin
    pieces: list[int] = []
    ahead: list[int] = []
    while True:
        played = int(run.prepared.macro_edges.pieces.frames[pieces].sum())
        end = min(played + round(config.horizon_s * rate), run.longest)
        frontiers = concatenate([begin, _state_after(run, pieces + ahead)]) if ahead else begin
        first = _widening(run, frontiers, end)
        if not pieces:
            begin = _chosen_start(search, begin, first.best or first.farthest)
        best, proven, over = branch_and_bound(
            search,
            begin,
            horizon=end,
            best=first.best,
            expansions=config.expansions,
            deadline=run.deadline,
        )
        run.windows += 1
        run.proven += proven
        terminal = best or first.farthest
        if over or terminal.complete or terminal.frames >= run.longest:
            return _finish(run, everywhere, terminal, over)
        if terminal.frames < end:
            other, over = _best_of_beams(run, everywhere)
            terminal = other if other.complete or other.frames > terminal.frames else terminal
            return _finish(run, everywhere, terminal, over)
        _, walk = search.chain(terminal.record, terminal.macro_edge)
        total = np.cumsum(run.prepared.macro_edges.pieces.frames[walk])
        kept = int(np.searchsorted(total, played + keep)) + 1
        pieces, ahead = walk[:kept], walk[kept:]
        begin = _state_after(run, pieces)


def _chosen_start(search: Search, begin: Frontier, terminal: Terminal) -> Frontier:
    """The one place to begin at that the beam chose."""
    record, _ = search.chain(terminal.record, terminal.macro_edge)
    return begin.pick(begin.record == record)


def _widening(run: _Run, begin: Frontier, horizon: int) -> Beam:
    """A beam up to the horizon, four times as wide again while it finds no way."""
    width = run.config.beam_width
    while True:
        beam = run_beam(run.search, begin, width=width, horizon=horizon, deadline=run.deadline)
        if beam.best is not None or beam.interrupted or width >= WIDEST:
            return beam
        width = min(4 * width, WIDEST)


def _state_after(run: _Run, played: list[int]) -> Frontier:
    """A walk that has played these pieces and is now where the last one ends."""
    track = place_pieces(run.graph, run.prepared.macro_edges.pieces, played, run.start)
    cost = track.costs(run.curve, run.config).sum()
    state = np.array([*track.end, track.arc[-1], cost], dtype=np.float32)
    stop = int(run.prepared.macro_edges.pieces.target[played[-1]])
    return run.search.begin_with(state, stop, played)
