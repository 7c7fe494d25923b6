"""Path synthesis: the walk whose root follows a sketched path (hybrid paper eqs 6–7).

Depth-first branch and bound over a bounded horizon, after Kovar, Gleicher and Pighin (2002): find
the best walk of the next 4 s, keep its first second, look again from there. A beam over the same
horizon gives the first walk to beat, so most of the search is proving that there is no better one.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.core.errors import ConfigError, PathError
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.config import PathConfig
from mgjax.hybrid.paths.beam import Beam, run_beam
from mgjax.hybrid.paths.branch_and_bound import branch_and_bound
from mgjax.hybrid.paths.curve import Curve, make_curve
from mgjax.hybrid.paths.frontier import UNBOUNDED, Front, Leaf, Search, join
from mgjax.hybrid.paths.kernel import make_request, prepare
from mgjax.hybrid.paths.macro_edges import Strides, stride_tables
from mgjax.hybrid.paths.result import PathResult, finish, lay_out
from mgjax.hybrid.paths.sketch import Sketch

WIDEST = 4096
SLOWEST_M_S = 0.1
"""A walk may take as long as at this speed, and 10 s more."""

Place = Float[np.ndarray, "3"]


@dataclass(kw_only=True)
class _Task:
    """A request with what does not change while it is searched."""

    graph: MotionGraph
    strides: Strides
    sketch: Sketch
    curve: Curve
    config: PathConfig
    search: Search
    start: Place
    deadline: float
    begun: float
    prepare_s: float
    windows: int = 0
    proven: int = 0

    @property
    def longest(self) -> int:
        seconds = self.curve.length / SLOWEST_M_S + 10.0
        return min(round(seconds * self.graph.frame_rate), UNBOUNDED)


def follow(
    graph: MotionGraph,
    sketch: Sketch,
    *,
    config: PathConfig | None = None,
    node: int | None = None,
    start: Place | None = None,
) -> PathResult:
    """The walk along a sketched path.

    Args:
        graph: with locomotion.
        sketch: the path and what is wanted of the walk.
        config: settings.
        node: where in the graph the walk begins; None: wherever is best.
        start: planar frame of the body at the beginning; None: on the first point of the path,
            facing along it.

    Raises:
        ConfigError: a setting out of range.
        PathError: the walk would begin too far from the path, or inside an obstacle.
        GraphError: no walk of the graph gets anywhere.
    """
    config = config or PathConfig()
    _validate(config, graph, node)
    entered = time.perf_counter()
    curve = make_curve(sketch)
    place = curve.start() if start is None else np.asarray(start, dtype=np.float64)
    _check_start(sketch, curve, place, config)
    strides = stride_tables(graph)
    request = make_request(curve, sketch, config)
    prepare(strides, request)
    begun = time.perf_counter()
    limit = config.time_limit_s or math.inf
    task = _Task(
        graph=graph,
        strides=strides,
        sketch=sketch,
        curve=curve,
        config=config,
        search=Search(
            strides=strides,
            request=request,
        ),
        start=place,
        deadline=begun + limit,
        begun=begun,
        prepare_s=begun - entered,
    )
    stops = np.arange(graph.num_nodes) if node is None else np.array([node])
    state = np.zeros((len(stops), 5), dtype=np.float32)
    state[:, :3] = place
    begin = task.search.begin(state, stops)
    if config.method == "exact":
        return _horizons(task, begin)
    leaf, interrupted = _whole(task, begin)
    return _finish(task, begin, leaf, interrupted)


def _validate(config: PathConfig, graph: MotionGraph, node: int | None) -> None:
    checks = {
        "method": config.method in ("exact", "beam"),
        "horizon_s": 1.0 <= config.horizon_s <= 60,
        "keep_s": 0.1 <= config.keep_s <= config.horizon_s,
        "near_m": 0.05 <= config.near_m <= 100,
        "beam_width": 1 <= config.beam_width <= WIDEST,
        "expansions": 1 <= config.expansions <= 10**8,
        "time_limit_s": 0 <= config.time_limit_s < math.inf,
        "blend_weight": 0 <= config.blend_weight < math.inf,
        "speed_weight": 0 <= config.speed_weight < math.inf,
        "end_weight": 0 <= config.end_weight < math.inf,
        "end_radius_m": 0 <= config.end_radius_m < math.inf,
        "margin_m": 0 <= config.margin_m <= 10,
    }
    for name, ok in checks.items():
        if not ok:
            raise ConfigError(f"{name} = {getattr(config, name)!r} is out of range")
    if node is not None and not 0 <= node < graph.num_nodes:
        raise ConfigError(f"got node {node}, expected 0 … {graph.num_nodes - 1}")


def _check_start(sketch: Sketch, curve: Curve, start: Place, config: PathConfig) -> None:
    off = float(np.linalg.norm(start[1:] - curve.points[0]))
    if not off <= config.near_m:
        raise PathError(
            f"got a walk that begins {off:.2f} m from the path, expected at most {config.near_m:g}"
        )
    for x, z, radius in sketch.obstacles:
        if math.hypot(start[1] - x, start[2] - z) < radius + config.margin_m:
            raise PathError(
                f"got an obstacle at ({x:g}, {z:g}) over the beginning of the path, expected a"
                f" free one ({radius:g} m radius and {config.margin_m:g} m margin)"
            )


def _whole(task: _Task, begin: Front) -> tuple[Leaf, bool]:
    """The best walk of beams over the whole path, and whether the time was over.

    A beam that finds no way is followed by one four times as wide. With a time limit they go on
    after the first complete walk, as long as each finds a better one.
    """
    best: Leaf | None = None
    farthest: Leaf | None = None
    arc, width = -1.0, task.config.beam_width
    while True:
        found = run_beam(
            task.search, begin, width=width, horizon=task.longest, deadline=task.deadline
        )
        leaf = found.best if found.best is not None and found.best.complete else None
        gained = leaf is not None and (best is None or leaf.cost < best.cost)
        if gained:
            best = leaf
        if found.arc > arc:
            farthest, arc = found.farthest, found.arc
        enough = best is not None and not (gained and math.isfinite(task.deadline))
        if found.interrupted or enough or width >= WIDEST:
            chosen = best or farthest
            assert chosen is not None  # every beam has a farthest walk
            return chosen, found.interrupted
        width = min(4 * width, WIDEST)


def _finish(task: _Task, begin: Front, leaf: Leaf, interrupted: bool) -> PathResult:
    _, pieces = task.search.chain(leaf.record, leaf.stride)
    parts = task.strides.pieces
    if not pieces:  # lost at the first step: one frame of it
        pieces = [int(parts.out[parts.out_first[begin.stop[0]]])]
    return finish(
        task.graph,
        task.strides,
        task.curve,
        task.sketch,
        pieces=pieces,
        frames=max(leaf.frames, 1),
        start=task.start,
        status="followed" if leaf.complete else "time_limit" if interrupted else "lost",
        interrupted=interrupted,
        prepare_s=task.prepare_s,
        search_s=time.perf_counter() - task.begun,
        expanded=task.search.expanded,
        pruned=task.search.pruned,
        windows=task.windows,
        proven=task.proven,
    )


def _horizons(task: _Task, begin: Front) -> PathResult:
    """Horizon after horizon; each is searched from where the last one's first part ends.

    Where every walk strays within a horizon, beams over the whole path look for another way.
    """
    search, config, rate = task.search, task.config, task.graph.frame_rate
    keep = round(config.keep_s * rate)
    everywhere = begin
    pieces: list[int] = []
    ahead: list[int] = []
    while True:
        played = int(task.strides.pieces.frames[pieces].sum())
        end = min(played + round(config.horizon_s * rate), task.longest)
        fronts = join([begin, _state_after(task, pieces + ahead)]) if ahead else begin
        first = _widening(task, fronts, end)
        if not pieces:
            begin = _chosen_start(search, begin, first.best or first.farthest)
        best, proven, over = branch_and_bound(
            search,
            begin,
            horizon=end,
            best=first.best,
            expansions=config.expansions,
            deadline=task.deadline,
        )
        task.windows += 1
        task.proven += proven
        leaf = best or first.farthest
        if over or leaf.complete or leaf.frames >= task.longest:
            return _finish(task, everywhere, leaf, over)
        if leaf.frames < end:
            other, over = _whole(task, everywhere)
            leaf = other if other.complete or other.frames > leaf.frames else leaf
            return _finish(task, everywhere, leaf, over)
        _, found = search.chain(leaf.record, leaf.stride)
        total = np.cumsum(task.strides.pieces.frames[found])
        kept = int(np.searchsorted(total, played + keep)) + 1
        pieces, ahead = found[:kept], found[kept:]
        begin = _state_after(task, pieces)


def _chosen_start(search: Search, begin: Front, leaf: Leaf) -> Front:
    """Of many places to begin at, the one the beam chose."""
    record, _ = search.chain(leaf.record, leaf.stride)
    return begin.pick(begin.record == record)


def _widening(task: _Task, begin: Front, horizon: int) -> Beam:
    """A beam up to the horizon, four times as wide again while it finds no way."""
    width = task.config.beam_width
    while True:
        found = run_beam(task.search, begin, width=width, horizon=horizon, deadline=task.deadline)
        if found.best is not None or found.interrupted or width >= WIDEST:
            return found
        width = min(4 * width, WIDEST)


def _state_after(task: _Task, played: list[int]) -> Front:
    """A walk that has played these pieces and is now where the last one ends."""
    track = lay_out(task.graph, task.strides.pieces, played, task.start)
    cost = track.costs(task.curve, task.config).sum()
    state = np.array([*track.end, track.arc[-1], cost], dtype=np.float32)
    stop = int(task.strides.pieces.target[played[-1]])
    return task.search.begin_with(state, stop, played)
