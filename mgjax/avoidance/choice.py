"""Choosing the walk that avoids an attack (§3, §4): enumerate, judge, check, go on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np

from mgjax.avoidance.attack import Attack, Crop, crop_attack
from mgjax.avoidance.candidates import Candidates, enumerate_candidates
from mgjax.avoidance.check import CLEAR_M
from mgjax.avoidance.config import AvoidanceConfig, SpeedConfig
from mgjax.avoidance.evaluate import DeviceTables, device_tables, judge
from mgjax.avoidance.exact import clearance_between
from mgjax.avoidance.grid_index import GridIndex, lookup, touched_cells
from mgjax.avoidance.tables import EdgeTables, edge_tables
from mgjax.avoidance.time_scale import NOT_ADJUSTABLE, OK, OUT_OF_RANGE
from mgjax.avoidance.validate import validate_config, validate_start
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, make_walk

MAX_CONTINUATIONS = 200
"""Edges that are tried when a walk has to go on past its end without being hit."""

ROUNDING_M = 1e-5
"""What the jitted check may differ from that of the written motion."""


@dataclass(frozen=True, kw_only=True)
class Energy:
    """What the chosen walk was worth; the fields are those of eqs 4–10."""

    total: float
    avoidance: float
    body: float
    timescale: float
    penetration: float
    d: float
    d0: float


@dataclass(frozen=True, kw_only=True)
class Dropped:
    """Why candidates were dropped.

    Attributes:
        not_adjustable: no edge may change its speed as needed.
        time_scale: the time scale is not positive, or out of range.
        hit: the exact check found that the attack touches the body.
        overflow: not judged, or not checked exactly, for lack of room.
    """

    not_adjustable: int = 0
    time_scale: int = 0
    hit: int = 0
    overflow: int = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class Choice:
    """A walk for an attack, before its motion is made.

    Attributes:
        status: ``avoided``: the walk is clear of the attack throughout, by the exact check.
            ``hit``: there were candidates and every one is touched; the walk is the one touched
            least of those checked. ``no_candidate``: no avoidance part comes at the right time.
        node: where the walk begins.
        walk: the path, and what follows it until the attack is over.
        path_length: edges that belong to the path; the last one holds the avoidance part.
        part: the avoidance part, or None.
        time_scale: s_time, or None.
        candidates: how many satisfy eq. 1.
        dropped: why how many of them were dropped.
        energy: of the chosen candidate, or None.
        clearance_m: signed distance of attack and body over the walk, or None without candidate.
        clear_until: seconds until which the motion is clear where nothing clear could follow the
            path; None otherwise.
        crop: the part of the attack that counted for energies and timing, or None.
    """

    status: Literal["avoided", "hit", "no_candidate"]
    node: int
    walk: Walk
    path_length: int = 0
    part: int | None = None
    time_scale: float | None = None
    candidates: int = 0
    dropped: Dropped = Dropped()
    energy: Energy | None = None
    clearance_m: float | None = None
    clear_until: float | None = None
    crop: Crop | None = None


@dataclass(frozen=True, kw_only=True)
class Played:
    """A walk as it would be played, and how near the attack comes."""

    walk: Walk
    clearance: float
    clear_until: float | None


@lru_cache(maxsize=8)
def search_tables(
    graph: MotionGraph, body_rate: float, speed: SpeedConfig
) -> tuple[EdgeTables, DeviceTables]:
    """The tables of a graph, kept: they are made once for all attacks."""
    tables = edge_tables(graph, body_rate)
    return tables, device_tables(tables, speed)


def choose(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    *,
    config: AvoidanceConfig,
    seed: int = 0,
    index: GridIndex | None = None,
) -> Choice:
    """Chooses and time-scales the walk that avoids an attack with the least movement.

    The same as :func:`mgjax.avoidance.selection.select` without making the motion. With an
    ``index`` the candidates are looked up (§5.1); where it holds none, or cannot say, and where
    none of them is clear, they are enumerated.
    """
    validate_config(config)
    tables, _ = search_tables(graph, config.body_rate, config.speed)
    validate_start(graph, tables, node, attack)
    crop = crop_attack(attack, radius=config.crop_radius_m, height=config.crop_height_m)
    nothing = Choice(
        status="no_candidate", node=node, walk=_idle(graph, node, attack, config, seed)
    )
    if crop is None:
        return nothing
    found = None if index is None else lookup_candidates(index, node, attack, crop, config)
    if found is not None and len(found.length):
        choice = _best(graph, node, attack, config, crop, found, nothing)
        if choice.status == "avoided":
            return choice
    found = enumerate_candidates(
        graph, tables, node, crop.middle, window=config.T_window, capacity=config.capacity
    )
    return _best(graph, node, attack, config, crop, found, nothing)


def lookup_candidates(
    index: GridIndex, node: int, attack: Attack, crop: Crop, config: AvoidanceConfig
) -> Candidates | None:
    """The candidates whose avoidance volume the attack touches (§5.1), or None if unknown."""
    return lookup(index, node, touched_cells(attack, crop), crop.middle, config.T_window)


def _best(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    config: AvoidanceConfig,
    crop: Crop,
    candidates: Candidates,
    nothing: Choice,
) -> Choice:
    """Judges candidates and takes the best that stays clear; ``nothing`` if none can be timed."""
    total = len(candidates.length) + candidates.overflow
    dropped = Dropped(overflow=candidates.overflow)
    if not len(candidates.length):
        return replace(nothing, candidates=total, dropped=dropped, crop=crop)
    tables, device = search_tables(graph, config.body_rate, config.speed)
    judged = judge(tables, device, candidates, attack, crop, config, frame_rate=graph.frame_rate)
    status = judged["status"]
    dropped = replace(
        dropped,
        not_adjustable=int((status == NOT_ADJUSTABLE).sum()),
        time_scale=int((status == OUT_OF_RANGE).sum()),
    )
    order = ranking(judged)
    if not order.size:
        return replace(nothing, candidates=total, dropped=dropped, crop=crop)
    found = _first_clear(graph, node, attack, config, candidates, judged, order, dropped)
    return replace(found, candidates=total, crop=crop)


def ranking(judged: dict[str, np.ndarray]) -> np.ndarray:
    """Candidates that can be timed, in the order of their energy; those that seem to be hit last.

    The volumes that rank are samples, so a small penetration there is not yet a hit: such
    candidates follow, the least touched first, and the exact check decides on all.
    """
    usable = np.flatnonzero(judged["status"] == OK)
    d, energy = judged["d"][usable], judged["total"][usable]
    return usable[np.lexsort((np.where(d < 0, -d, energy), d < 0))]


def _first_clear(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    config: AvoidanceConfig,
    candidates: Candidates,
    judged: dict[str, np.ndarray],
    order: np.ndarray,
    dropped: Dropped,
) -> Choice:
    """Checks candidates in their order; the first that stays clear wins."""
    hits = 0
    found = False
    best: tuple[int, Played] | None = None
    for index in order[: config.checks]:
        length = int(candidates.length[index])
        walk = make_walk(graph, candidates.edges[index, :length], judged["scales"][index, :length])
        played = play_on(graph, attack, walk, config)
        if played.clearance >= CLEAR_M:
            # Pieces were checked one by one; what counts is the motion as a whole.
            whole = clearance_between(graph, attack, played.walk, 0.0, attack.end)
            found = whole >= CLEAR_M + ROUNDING_M
            played = replace(played, clearance=whole)
        if found or best is None or played.clearance > best[1].clearance:
            best = (int(index), played)
        if found:
            break
        hits += 1
    assert best is not None
    index, played = best
    unchecked = 0 if found else max(len(order) - config.checks, 0)
    names = ("total", "avoidance", "body", "timescale", "penetration", "d", "d0")
    return Choice(
        status="avoided" if found else "hit",
        node=node,
        walk=played.walk,
        path_length=int(candidates.length[index]),
        part=int(candidates.part[index]),
        time_scale=float(judged["s_time"][index]),
        dropped=replace(dropped, hit=hits, overflow=dropped.overflow + unchecked),
        energy=Energy(**{name: float(judged[name][index]) for name in names}),
        clearance_m=played.clearance,
        clear_until=None if found else played.clear_until,
    )


def play_on(graph: MotionGraph, attack: Attack, path: Walk, config: AvoidanceConfig) -> Played:
    """Continues a path along out-edges that stay clear until the attack is over.

    Depth first, longest edge first (fewer seams); after ``MAX_CONTINUATIONS`` edges the longest
    clear continuation stands and the result says until when it is clear.
    """
    until = attack.end + config.settle_s
    end = float(path.starts(graph)[-1])
    first = clearance_between(graph, attack, path, 0.0, min(end, until))
    if first < CLEAR_M:
        return Played(walk=_extend(graph, path, until), clearance=first, clear_until=None)
    stack = [(path, end, first)]
    furthest = (path, end, first)
    tried = 0
    while stack:
        walk, end, clear = stack.pop()
        if end > furthest[1]:
            furthest = (walk, end, clear)
        if end >= until:
            return Played(walk=walk, clearance=clear, clear_until=None)
        edges = graph.edges_from(int(graph.edge_target[walk.edges[-1]]))
        edges = edges[np.argsort(graph.edge_frames[edges], kind="stable")]
        for edge in edges:
            tried += 1
            if tried > MAX_CONTINUATIONS:
                break
            longer = Walk(edges=np.append(walk.edges, edge), scales=np.append(walk.scales, 1.0))
            stop = end + float(graph.edge_frames[edge]) / graph.frame_rate
            # The last stretch before the seam leads to the new edge, so it counts again.
            seam = end - float(walk.scales[-1]) / graph.frame_rate
            gap = clearance_between(graph, attack, longer, seam, min(stop, until))
            if gap >= CLEAR_M:
                stack.append((longer, stop, min(clear, gap)))
        if tried > MAX_CONTINUATIONS:
            break
    walk, end, clear = max([furthest, *stack], key=lambda item: item[1])
    return Played(walk=_extend(graph, walk, until), clearance=clear, clear_until=end)


def _extend(graph: MotionGraph, walk: Walk, until: float) -> Walk:
    """The walk with first out-edges appended until it lasts ``until`` seconds."""
    edges, scales = list(walk.edges), list(walk.scales)
    end = float(walk.starts(graph)[-1])
    while end < until:
        edge = int(graph.edges_from(int(graph.edge_target[edges[-1]]))[0])
        edges.append(edge)
        scales.append(1.0)
        end += graph.edge_frames[edge] / graph.frame_rate
    return Walk(edges=np.array(edges), scales=np.array(scales))


def _idle(
    graph: MotionGraph, node: int, attack: Attack, config: AvoidanceConfig, seed: int
) -> Walk:
    """A random walk until the attack is over: what plays when nothing avoids."""
    rng = np.random.default_rng(seed)
    until = attack.end + config.settle_s
    edges = [int(rng.choice(graph.edges_from(node)))]
    end = graph.edge_frames[edges[0]] / graph.frame_rate
    while end < until:
        edges.append(int(rng.choice(graph.edges_from(int(graph.edge_target[edges[-1]])))))
        end += graph.edge_frames[edges[-1]] / graph.frame_rate
    return make_walk(graph, edges)
