"""Choosing the walk that avoids an attack (§3, §4): enumerate, judge, check, go on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np

from mgjax.avoidance.attack import Attack, Crop, crop_attack, validate_attack
from mgjax.avoidance.candidates import Candidates, enumerate_candidates
from mgjax.avoidance.check import CLEAR_M, Trace, clearance, trace_motion, walk_motion
from mgjax.avoidance.config import AvoidanceConfig, SpeedConfig
from mgjax.avoidance.evaluate import DeviceTables, device_tables, judge
from mgjax.avoidance.exact import clearance_between
from mgjax.avoidance.tables import EdgeTables, edge_tables
from mgjax.avoidance.time_scale import NOT_ADJUSTABLE, OK, OUT_OF_RANGE
from mgjax.avoidance.volumes import preset_spheres, sphere_centres
from mgjax.core import planar
from mgjax.core.errors import AttackError, ConfigError
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, make_walk

MAX_CONTINUATIONS = 200
"""Edges that are tried when a walk has to go on past its end without being hit."""


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
class Selection:
    """The answer to an attack.

    Attributes:
        status: ``avoided``: the motion is clear of the attack throughout, by the exact check.
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
        clearance_m: signed distance of attack and body over the whole motion, or None without
            candidate.
        clear_until: seconds until which the motion is clear where nothing clear could follow the
            path; None otherwise.
        crop: the part of the attack that counted for energies and timing, or None.
        motion: from now until the attack is over, in the planar frame of its first pose.
        trace: the body's spheres over that motion.
    """

    status: Literal["avoided", "hit", "no_candidate"]
    node: int
    walk: Walk
    path_length: int
    part: int | None
    time_scale: float | None
    candidates: int
    dropped: Dropped
    energy: Energy | None
    clearance_m: float | None
    clear_until: float | None
    crop: Crop | None
    motion: Motion
    trace: Trace


@dataclass(frozen=True, kw_only=True)
class _Played:
    """A walk as it would be played, and how near the attack comes."""

    walk: Walk
    clearance: float
    clear_until: float | None


@dataclass(frozen=True, kw_only=True)
class _Written:
    """The motion of a walk as it is written, and its exact clearance."""

    motion: Motion
    trace: Trace
    clearance: float


@lru_cache(maxsize=8)
def _tables(
    graph: MotionGraph, body_rate: float, speed: SpeedConfig
) -> tuple[EdgeTables, DeviceTables]:
    tables = edge_tables(graph, body_rate)
    return tables, device_tables(tables, speed)


def select(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    *,
    config: AvoidanceConfig | None = None,
    seed: int = 0,
) -> Selection:
    """Chooses and time-scales the walk that avoids an attack with the least movement.

    The character stands at ``node`` now, and the path begins now. Candidates are all walks to an
    avoidance part whose middle is within T_window/2 of the middle of the cropped attack (eq. 1);
    each is scaled in time to meet it (eq. 3) and judged by its energies (eq. 10). In the order of
    their energy they are checked exactly, by forward kinematics, against the whole attack, and the
    first that stays clear wins. What follows its end is chosen so that it stays clear until
    ``settle_s`` after the attack.

    Args:
        graph: a motion graph with labelled avoidance parts.
        node: where the character stands.
        attack: in the planar frame of the body at the node.
        config: settings.
        seed: for the walk that is taken where there is no candidate.

    Raises:
        AttackError: the attack is not finite, or begins inside the body.
        ConfigError: no such node, or a setting out of range.
    """
    config = config or AvoidanceConfig()
    _validate(graph, node, attack, config)
    crop = crop_attack(attack, radius=config.crop_radius_m, height=config.crop_height_m)
    if crop is None:
        return _without_candidate(graph, node, attack, config, seed, None, 0, Dropped())
    tables, device = _tables(graph, config.body_rate, config.speed)
    candidates = enumerate_candidates(
        graph, tables, node, crop.middle, window=config.T_window, capacity=config.capacity
    )
    total = len(candidates.length) + candidates.overflow
    if not len(candidates.length):
        dropped = Dropped(overflow=candidates.overflow)
        return _without_candidate(graph, node, attack, config, seed, crop, total, dropped)
    judged = judge(tables, device, candidates, attack, crop, config, frame_rate=graph.frame_rate)
    status = judged["status"]
    dropped = Dropped(
        not_adjustable=int((status == NOT_ADJUSTABLE).sum()),
        time_scale=int((status == OUT_OF_RANGE).sum()),
        overflow=candidates.overflow,
    )
    usable = np.flatnonzero(status == OK)
    if not usable.size:
        return _without_candidate(graph, node, attack, config, seed, crop, total, dropped)
    return _first_clear(graph, node, attack, config, crop, candidates, judged, usable, dropped)


def _validate(graph: MotionGraph, node: int, attack: Attack, config: AvoidanceConfig) -> None:
    if not 0 <= node < graph.num_nodes:
        raise ConfigError(f"got node {node}, expected 0 … {graph.num_nodes - 1}")
    _validate_config(config)
    validate_attack(attack)
    spheres = preset_spheres(graph.skeleton)
    frame = graph.node_frame[node]
    positions, _ = forward(
        graph.skeleton, graph.root_translation[frame], graph.local_rotations[frame]
    )
    inverse = np.asarray(planar.inverse(graph.node_plane[node].astype(np.float64)))
    body = np.asarray(planar.apply(inverse, np.asarray(sphere_centres(spheres, positions))))
    begin = attack.at(np.array([max(attack.start, 0.0)]))[0]
    gap = np.linalg.norm(begin[:, None] - body[None], axis=-1)
    gap -= attack.radii[:, None] + spheres.radii[None]
    if gap.min() < 0:
        where = spheres.names[int(np.argmin(gap.min(axis=0)))]
        raise AttackError(
            f"got an attack that starts {-gap.min():.3f} m inside the body ({where}),"
            " expected one that starts outside"
        )


_RANGES: dict[str, tuple[float, float]] = {
    "T_window": (1e-3, 10.0),
    "crop_radius_m": (1e-3, 100.0),
    "crop_height_m": (1e-3, 100.0),
    "body_rate": (1.0, 1000.0),
    "evaluation_step_s": (1e-3, 1.0),
    "settle_s": (0.0, 10.0),
    "capacity": (1, 1_000_000),
    "checks": (1, 1_000_000),
    "energy.E_avoidance": (1e-9, 1e9),
    "energy.D_body": (1e-9, 1e9),
    "energy.E_time": (1.0, 1e6),
    "energy.w_a": (0.0, 1e9),
    "energy.w_b": (0.0, 1e9),
    "energy.w_t": (0.0, 1e9),
    "speed.V_fast": (0.0, math.inf),
    "speed.V_slow": (0.0, math.inf),
    "speed.V_still": (0.0, math.inf),
}
"""Smallest and largest value of each setting that is a number."""


def _validate_config(config: AvoidanceConfig) -> None:
    for key, (low, high) in _RANGES.items():
        part, _, name = key.rpartition(".")
        value = getattr(getattr(config, part) if part else config, name)
        try:
            ok = not isinstance(value, bool | str) and low <= float(value) <= high
        except (TypeError, ValueError):
            ok = False
        if not ok:
            top = f" … {high:g}" if high < math.inf else " or more"
            raise ConfigError(f"got {key} = {value!r}, expected {low:g}{top}")
    for key, known in (("form", ("overlap", "paper")), ("d0", ("clamped", "paper"))):
        value = getattr(config.energy, key)
        if value not in known:
            raise ConfigError(f"got energy.{key} = {value!r}, expected {' or '.join(known)}")


def _first_clear(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    config: AvoidanceConfig,
    crop: Crop,
    candidates: Candidates,
    judged: dict[str, np.ndarray],
    usable: np.ndarray,
    dropped: Dropped,
) -> Selection:
    """Checks candidates in the order of their energy; those that seem to be hit come last.

    The volumes that rank are samples, so a small penetration there is not yet a hit: such
    candidates follow, the least touched first, and the exact check decides on all.
    """
    d, energy = judged["d"][usable], judged["total"][usable]
    order = usable[np.lexsort((np.where(d < 0, -d, energy), d < 0))]
    hits = 0
    found = False
    best: tuple[int, _Played] | None = None
    written: _Written | None = None
    for index in order[: config.checks]:
        length = int(candidates.length[index])
        walk = make_walk(graph, candidates.edges[index, :length], judged["scales"][index, :length])
        played = _play_on(graph, attack, walk, config)
        if played.clearance >= CLEAR_M:
            # Pieces were checked one by one; what counts is the motion as it is written.
            written = _write(graph, attack, played.walk, config)
            if written.clearance >= CLEAR_M:
                found, best = True, (int(index), played)
                break
            played = replace(played, clearance=written.clearance)
        hits += 1
        if best is None or played.clearance > best[1].clearance:
            best = (int(index), played)
    assert best is not None
    index, played = best
    if written is None or not found:
        written = _write(graph, attack, played.walk, config)
    unchecked = 0 if found else max(len(order) - config.checks, 0)
    names = ("total", "avoidance", "body", "timescale", "penetration", "d", "d0")
    return Selection(
        status="avoided" if found else "hit",
        node=node,
        walk=played.walk,
        path_length=int(candidates.length[index]),
        part=int(candidates.part[index]),
        time_scale=float(judged["s_time"][index]),
        candidates=len(candidates.length) + candidates.overflow,
        dropped=Dropped(
            not_adjustable=dropped.not_adjustable,
            time_scale=dropped.time_scale,
            hit=hits,
            overflow=dropped.overflow + unchecked,
        ),
        energy=Energy(**{name: float(judged[name][index]) for name in names}),
        clearance_m=written.clearance,
        clear_until=None if found else played.clear_until,
        crop=crop,
        motion=written.motion,
        trace=written.trace,
    )


def _play_on(graph: MotionGraph, attack: Attack, path: Walk, config: AvoidanceConfig) -> _Played:
    """Continues a path along out-edges that stay clear until the attack is over.

    Depth first, longest edge first (fewer seams); after ``MAX_CONTINUATIONS`` edges the longest
    clear continuation stands and the result says until when it is clear.
    """
    until = attack.end + config.settle_s
    end = float(path.starts(graph)[-1])
    first = clearance_between(graph, attack, path, 0.0, min(end, until))
    if first < CLEAR_M:
        return _Played(walk=_extend(graph, path, until), clearance=first, clear_until=None)
    stack = [(path, end, first)]
    furthest = (path, end, first)
    tried = 0
    while stack:
        walk, end, clear = stack.pop()
        if end > furthest[1]:
            furthest = (walk, end, clear)
        if end >= until:
            return _Played(walk=walk, clearance=clear, clear_until=None)
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
    return _Played(walk=_extend(graph, walk, until), clearance=clear, clear_until=end)


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


def _write(graph: MotionGraph, attack: Attack, walk: Walk, config: AvoidanceConfig) -> _Written:
    spheres = preset_spheres(graph.skeleton)
    motion = walk_motion(graph, walk, attack.end + config.settle_s)
    trace = trace_motion(graph, spheres, motion)
    return _Written(
        motion=motion, trace=trace, clearance=clearance(attack, trace, spheres.radii)[1]
    )


def _without_candidate(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    config: AvoidanceConfig,
    seed: int,
    crop: Crop | None,
    candidates: int,
    dropped: Dropped,
) -> Selection:
    """A random walk: what plays when nothing avoids."""
    rng = np.random.default_rng(seed)
    until = attack.end + config.settle_s
    edges = [int(rng.choice(graph.edges_from(node)))]
    while graph.edge_frames[edges].sum() / graph.frame_rate < until:
        edges.append(int(rng.choice(graph.edges_from(int(graph.edge_target[edges[-1]])))))
    walk = make_walk(graph, edges)
    written = _write(graph, attack, walk, config)
    return Selection(
        status="no_candidate",
        node=node,
        walk=walk,
        path_length=0,
        part=None,
        time_scale=None,
        candidates=candidates,
        dropped=dropped,
        energy=None,
        clearance_m=None,
        clear_until=None,
        crop=crop,
        motion=written.motion,
        trace=written.trace,
    )
