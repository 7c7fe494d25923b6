"""``mgjax walk``."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from mgjax.cli.arguments import Walk
from mgjax.cli.report import emit, seams_json, to_json
from mgjax.core.errors import ConfigError
from mgjax.graph.files import load_graph
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.hybrid.config import PathConfig, WalkConfig
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.result import PathResult
from mgjax.hybrid.paths.search import follow
from mgjax.hybrid.paths.sketch import Sketch, load_sketch
from mgjax.hybrid.reaching.result import ReachResult
from mgjax.hybrid.reaching.targets import Target, load_targets
from mgjax.hybrid.reaching.walk import reach
from mgjax.io.bvh.write import save_bvh
from mgjax.io.output import output_folder
from mgjax.io.toml_file import load_config, read_toml
from mgjax.pictures.walk import walk_picture
from mgjax.stage.html import save_html


def run(command: Walk) -> None:
    """Searches the walk and writes what came of it."""
    settings = load_settings(command.config) if command.config else WalkConfig()
    config = settings.path
    if command.method is not None:
        config = replace(config, method=command.method)
    if command.seconds is not None:
        if not 0 < command.seconds < math.inf:
            raise ConfigError(f"got --seconds {command.seconds:g}, expected more than 0")
        config = replace(config, time_limit_s=command.seconds)
    sketch = load_sketch(command.path, spline=command.spline, closed=command.closed)
    targets = None if command.reach is None else load_targets(command.reach)
    graph = load_graph(command.graph)
    with output_folder(command.out) as folder:
        if targets is None:
            reached = None
            walked = follow(graph, sketch, config=config)
        else:
            reached = reach(graph, sketch, targets, config=settings.reach, path=config)
            walked = reached.walked
        motion = walked.motion if reached is None else reached.motion
        result = walk_json(graph, walked, make_curve(sketch).length)
        result["sketch"] = sketch_json(sketch)
        lines = [describe(result)]
        if reached is not None:
            result |= reach_json(graph, reached)
            lines += [describe_target(row) for row in result["targets"]]
        (folder / "result.json").write_text(to_json(result) + "\n")
        save_bvh(folder / "motion.bvh", graph.skeleton, motion)
        walk_picture(folder / "walk.png", graph, sketch, walked, reached)
        if command.html:
            save_html(folder / "index.html", walked if reached is None else reached)
    emit(result, [*lines, f"written to {command.out}"], as_json=command.json)


def load_settings(path: str | Path) -> WalkConfig:
    """Settings from a file with the sections ``[path]`` and ``[reach]``, or with the path's alone.

    Raises:
        FileFormatError, ConfigError: as :func:`mgjax.io.toml_file.load_config`.
    """
    _, document = read_toml(path)
    if {field.name for field in fields(WalkConfig)} & document.keys():
        return load_config(path, WalkConfig)
    return WalkConfig(path=load_config(path, PathConfig))


def walk_json(graph: MotionGraph, walked: PathResult, length: float) -> dict[str, Any]:
    """A walk along a path as JSON values; seconds are those of the motion unless named a search."""
    off, turned = walked.end_off
    return {
        "status": walked.status,
        "interrupted": walked.interrupted,
        "failed_at": None if walked.failed_at is None else walked.failed_at.tolist(),
        "failed_s_m": walked.failed_s,
        "error_m2": walked.error,
        "mean_distance_m": walked.mean_distance,
        "largest_distance_m": walked.largest_distance,
        "path_length_m": length,
        "seconds": walked.seconds,
        "prepare_s": walked.prepare_s,
        "search_s": walked.search_s,
        "search_s_per_s": walked.search_s / walked.seconds,
        "nodes_expanded": walked.expanded,
        "nodes_pruned": walked.pruned,
        "horizons": walked.windows,
        "horizons_proven": walked.proven,
        "foot_slide_m_per_frame": walked.slide,
        "foot_slide_share": walked.slide_share,
        "end_off_m": None if math.isnan(off) else off,
        "end_off_deg": None if math.isnan(turned) else math.degrees(turned),
        "start": walked.start.tolist(),
        "walk": _edges_json(graph, walked),
        "seams": seams_json(graph, walked.walk.edges, walked.walk.starts(graph), walked.seconds),
    }


def sketch_json(sketch: Sketch) -> dict[str, Any]:
    """The path that was asked for, as its file has it."""
    value: dict[str, Any] = {
        "points": sketch.points.tolist(),
        "spline": sketch.spline,
        "closed": sketch.closed,
        "obstacles": sketch.obstacles.tolist(),
    }
    if sketch.end is not None:
        x, z, heading = sketch.end
        turned = {"heading_deg": math.degrees(heading)} if math.isfinite(heading) else {}
        value["end"] = {"place": [x, z], **turned}
    return value


def target_json(target: Target) -> dict[str, Any]:
    """Where a target is, as its file has it."""
    if target.bar is not None:
        ends = target.bar.ends.tolist()
        bar = {"from": ends[0], "to": ends[1], "radius": target.bar.radius}
        return {"limb": target.limb, "bar": bar}
    rows = [
        [float(s), *place] for s, place in zip(target.seconds, target.places.tolist(), strict=True)
    ]
    if len(rows) == 1:
        return {"limb": target.limb, "place": rows[0][1:]}
    return {"limb": target.limb, "track": rows}


def reach_json(graph: MotionGraph, reached: ReachResult) -> dict[str, Any]:
    """What limbs reached as JSON values; times are those of the motion that is written."""
    rate = reached.motion.frame_rate
    motion_s = (reached.motion.num_frames - 1) / rate
    walk = reached.walked.walk
    starts = np.searchsorted(reached.shown, walk.starts(graph) * graph.frame_rate - 1e-6) / rate

    def number(value: float) -> float | None:
        return value if math.isfinite(value) else None

    rows = [
        {
            **target_json(row.target),
            "when": row.target.when,
            "status": row.status,
            "error_m": number(row.error_m),
            "hold_error_m": number(row.hold_m),
            "from_s": None if row.first is None else row.first / rate,
            "to_s": None if row.last is None else row.last / rate,
            "extended_m": row.extended_m,
            "stopped": row.stopped,
            "pelvis_drop_m": row.drop_m,
            "clearance_m": number(row.clear_m),
        }
        for row in reached.targets
    ]
    return {
        "targets": rows,
        "motion_s": motion_s,
        "seams": seams_json(graph, walk.edges, starts, motion_s),
        "reach_s": reached.solve_s,
        "fastest_turn_deg_s": reached.fastest_deg_s,
        "fastest_turn_of_walk_deg_s": reached.fastest_plain_deg_s,
        "foot_slide_with_reach_m_per_frame": reached.slide,
    }


def describe_target(row: dict[str, Any]) -> str:
    """One line for people on one target."""
    text = f"{row['limb']} {row['when']}: {row['status']}"
    if row["from_s"] is not None:
        text += f" from {row['from_s']:.2f} to {row['to_s']:.2f} s"
    if row["hold_error_m"] is not None:
        text += (
            f", {1000 * row['error_m']:.1f} mm off, {1000 * row['hold_error_m']:.1f} in the hold"
        )
    if row["extended_m"]:
        text += f", {row['extended_m']:.1f} m of way added"
    if row["clearance_m"] is not None:
        text += f", {100 * row['clearance_m']:.0f} cm clear"
    return text


def _edges_json(graph: MotionGraph, walked: PathResult) -> list[dict[str, Any]]:
    starts = walked.walk.starts(graph)
    rows: list[dict[str, Any]] = []
    for i, edge in enumerate(walked.walk.edges.tolist()):
        ends = [graph.node_clip[n] for n in (graph.edge_source[edge], graph.edge_target[edge])]
        names = [graph.clip_names[int(clip)] for clip in ends]
        blended = graph.edge_clip[edge] == NO_CLIP
        rows.append(
            {
                "edge": edge,
                "clip": " > ".join(names) if blended else names[0],
                "start_s": float(starts[i]),
                "end_s": min(float(starts[i + 1]), walked.seconds),
            }
        )
    return rows


def describe(result: dict[str, Any]) -> str:
    """One line for people."""
    text = (
        f"{result['status']}: {result['seconds']:.1f} s of motion along"
        f" {result['path_length_m']:.1f} m, mean distance {result['mean_distance_m']:.3f} m,"
        f" largest {result['largest_distance_m']:.3f} m; search {result['search_s']:.3f} s,"
        f" {result['nodes_expanded']} expanded, {result['nodes_pruned']} pruned"
    )
    if result["failed_at"] is not None:
        x, z = result["failed_at"]
        text += f"; it leads to ({x:.2f}, {z:.2f}), after {result['failed_s_m']:.2f} m of the path"
    return text
