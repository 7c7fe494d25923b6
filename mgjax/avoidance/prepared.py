"""What answering attacks on a graph takes: made once by :func:`prepare`, and passed down."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import jax

from mgjax.avoidance.body.chord_error import chord_errors
from mgjax.avoidance.body.device_tables import DeviceTables, device_tables
from mgjax.avoidance.body.edge_tables import EdgeTables, edge_tables
from mgjax.avoidance.body.poses import GraphPoses, PosedGraph, body_reach, graph_poses
from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.config import AvoidanceConfig, SpeedConfig, for_body, validate_config
from mgjax.avoidance.culling.pictures import Slices, build_slices
from mgjax.avoidance.index.index import GridIndex
from mgjax.avoidance.index.protocol import CandidateIndex
from mgjax.core.errors import ConfigError, GraphError
from mgjax.graph.cache import cached
from mgjax.graph.fingerprint import fingerprint
from mgjax.graph.types import MotionGraph


@dataclass(frozen=True, kw_only=True, eq=False)
class Prepared:
    """The state of the avoidance room for one graph.

    Attributes:
        graph: a motion graph.
        body_rate, speed: the settings that the tables were made with, as they were given.
        tables: what is known of edges and avoidance parts, on the host.
        device: what compiled code reads of it.
        posed: the poses of the graph, for the exact check.
        slices: pictures of bodies (§5.2), where the settings ask for culling; else None.
        index: the grid index (§5.1) from which candidates are looked up, or None.
    """

    graph: MotionGraph
    body_rate: float
    speed: SpeedConfig
    tables: EdgeTables
    device: DeviceTables
    posed: PosedGraph
    slices: Slices | None
    index: CandidateIndex | None


def prepare(
    graph: MotionGraph,
    config: AvoidanceConfig | None = None,
    *,
    index: CandidateIndex | None = None,
) -> Prepared:
    """Makes everything that searches on a graph share; it takes about a second.

    What takes a graph in this room takes its result as well, and then neither makes nor keeps
    anything beside it.

    Args:
        graph: a motion graph with labelled avoidance parts.
        config: settings; ``body_rate``, ``speed`` and ``culling`` decide what is made.
        index: the graph's grid index, from which candidates are looked up.

    Raises:
        ConfigError: a setting out of range, or the index of another graph.
        GraphError: no avoidance parts.
        SkeletonError: the skeleton lacks a limb that the body's spheres are fixed to.
    """
    config = config or AvoidanceConfig()
    validate_config(config)
    made = _make(graph, config)
    slices = _slices(graph, made.tables) if config.culling != "none" else None
    return _joined(graph, config, made, slices, index)


def prepared_for(
    graph: MotionGraph | Prepared, config: AvoidanceConfig, index: CandidateIndex | None = None
) -> Prepared:
    """What was prepared, or what is kept for a graph; an ``index`` replaces that of the former.

    Raises:
        ConfigError: a setting out of range, or other than those it was prepared with; the index of
            another graph.
        GraphError: no avoidance parts.
    """
    validate_config(config)
    if isinstance(graph, Prepared):
        _check(graph, config)
        _check_index(graph.graph, index)
        return graph if index is None else replace(graph, index=index)
    key = ("avoidance", config.body_rate, config.speed)
    made = cached(graph, key, lambda: _make(graph, config))
    slices = None
    if config.culling != "none":
        slices = cached(graph, ("slices", config.body_rate), lambda: _slices(graph, made.tables))
    return _joined(graph, config, made, slices, index)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Made:
    """All that is computed from a graph, without the graph itself, which a cache must not hold."""

    tables: EdgeTables
    device: DeviceTables
    poses: GraphPoses
    reach: float


def _make(graph: MotionGraph, config: AvoidanceConfig) -> _Made:
    spheres = preset_spheres(graph.skeleton)
    if not graph.label_kind:
        raise GraphError(
            got="a graph without avoidance parts",
            expected="labelled clips: build_graph(clips, labels=…)",
        )
    poses = graph_poses(graph, spheres)
    reach = body_reach(graph.skeleton, spheres)
    posed = PosedGraph(graph=graph, poses=poses, reach=reach)
    with ThreadPoolExecutor(1) as beside:  # compiled code, which leaves Python to the tables
        errors = beside.submit(chord_errors, posed, config.body_rate)
        tables = edge_tables(graph, config.body_rate)
        speed = for_body(config, graph.body_scale).speed
        device = device_tables(graph, tables, speed, *errors.result())
    return _Made(tables=tables, device=device, poses=poses, reach=reach)


def _slices(graph: MotionGraph, tables: EdgeTables) -> Slices:
    return jax.device_put(build_slices(tables, graph.body_scale))


def _joined(
    graph: MotionGraph,
    config: AvoidanceConfig,
    made: _Made,
    slices: Slices | None,
    index: CandidateIndex | None,
) -> Prepared:
    _check_index(graph, index)
    return Prepared(
        graph=graph,
        body_rate=config.body_rate,
        speed=config.speed,
        tables=made.tables,
        device=made.device,
        posed=PosedGraph(graph=graph, poses=made.poses, reach=made.reach),
        slices=slices,
        index=index,
    )


def _check_index(graph: MotionGraph, index: CandidateIndex | None) -> None:
    if isinstance(index, GridIndex) and index.fingerprint != fingerprint(graph):
        raise ConfigError(got="the index of another graph", expected="build_index of this one")


def _check(prepared: Prepared, config: AvoidanceConfig) -> None:
    for name in ("body_rate", "speed"):
        made, asked = getattr(prepared, name), getattr(config, name)
        if made != asked:
            raise ConfigError(
                f"got {name} = {asked}, expected {made}, which the graph is prepared for"
            )
    if config.culling != "none" and prepared.slices is None:
        raise ConfigError(
            f"got culling = {config.culling!r}, expected none: the graph is prepared without slices"
        )
