"""``mgjax coverage``."""

from __future__ import annotations

import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.coverage.connected import SERVED, connected
from mgjax.avoidance.coverage.report import coverage_report
from mgjax.avoidance.coverage.throws import Coverage, measure_coverage
from mgjax.cli import arguments as commands
from mgjax.cli.report import emit, to_json
from mgjax.graph.files import load_graph
from mgjax.graph.types import MotionGraph
from mgjax.io.output import output_folder
from mgjax.io.toml_file import load_config
from mgjax.pictures.coverage import coverage_picture
from mgjax.stage.html import save_html

LISTED = 4
"""Regions and stretches of clips that are printed; coverage.json has all."""
SELDOM = 0.02
"""A kind that avoids a smaller share of the balls is hardly used."""


def run(command: commands.Coverage) -> None:
    """Throws the balls and writes what came of them."""
    config = load_config(command.config, AvoidanceConfig) if command.config else AvoidanceConfig()
    graph = load_graph(command.graph)
    with output_folder(command.out) as folder:
        found = measure_coverage(
            graph,
            directions=command.directions,
            heights=command.heights,
            arrivals=command.arrivals,
            nodes=command.nodes,
            seed=command.seed,
            speed=command.speed,
            config=config,
            progress=sys.stderr.isatty(),
        )
        result = coverage_report(graph, found) | {"seed": command.seed}
        result["connectivity"] = connected(graph, found, config=config)
        (folder / "coverage.json").write_text(to_json(result) + "\n")
        write_arrays(folder / "coverage.npz", graph, found)
        coverage_picture(folder / "coverage.png", graph, found)
        if command.html:
            save_html(folder / "index.html", found)
    emit(result, [*describe(result), f"written to {command.out}"], as_json=command.json)


def write_arrays(path: Path, graph: MotionGraph, found: Coverage) -> None:
    """Every attack and its answer, and every node: its clip, frame in it and nearest part."""
    whole: Any = {f.name: getattr(found, f.name) for f in fields(found) if f.name != "answers"}
    whole |= {f.name: getattr(found.answers, f.name) for f in fields(found.answers)}
    whole |= {
        "clips": np.array(graph.clip_names),
        "node_clip": graph.node_clip,
        "node_clip_frame": graph.node_frame - graph.clip_starts[graph.node_clip],
    }
    np.savez_compressed(path, **whole)


def describe(result: dict[str, Any]) -> list[str]:
    """For people: how much is avoided, where it is worst, and what would help."""
    total = result["all"]
    low, high = total["avoided_interval"]
    kinds = sorted(total["kinds"].items(), key=lambda item: -item[1])
    lines = [
        f"{result['attacks']} balls at {result['nodes']} nodes: {total['avoided']:.0%} avoided"
        f" ({low:.0%} … {high:.0%}), {total['hit']:.0%} hit, {total['no_candidate']:.0%} without"
        " candidate",
        "avoided by time until arrival: "
        + ", ".join(f"{row['arrival_s']:g} s {row['avoided']:.0%}" for row in result["arrivals"]),
        "avoided by kind: " + ", ".join(f"{kind} {share:.1%}" for kind, share in kinds),
        "worst directions: "
        + ", ".join(f"{row['from']} {row['avoided']:.0%}" for row in result["directions"][:LISTED]),
        *_connected(result["connectivity"]),
        "worst served:",
        *(f"  {_region(row)}" for row in result["regions"][:LISTED]),
    ]
    return [*lines, "to improve the graph:", *(f"  {line}" for line in _advice(result))]


def _connected(found: dict[str, Any]) -> list[str]:
    near = found["time_to_part_s"]["any"]
    soon = " / ".join("–" if near[p] is None else f"{near[p]:.1f}" for p in ("p50", "p95"))
    return [
        f"connected: {soon} s to a part (p50 / p95),"
        f" {found['avoidable_cells']:.0%} of the cells avoided from {SERVED:.0%} of the nodes,"
        f" {found['clear_parts']['p50']} parts clear of a ball (median),"
        f" {found['dead_frames']:.0%} of the frames in no clear candidate of"
        f" {found['sampled_balls']} balls"
    ]


def _region(row: dict[str, Any]) -> str:
    low, high = row["avoided_interval"]
    bottom, top = row["heights_m"]
    heights = f"{bottom:g} m" if bottom == top else f"{bottom:g}–{top:g} m"
    kind, share = max(row["kinds"].items(), key=lambda item: item[1])
    return (
        f"{row['band']} balls ({heights}) from {row['from']}: {row['avoided']:.0%} avoided"
        f" ({low:.0%} … {high:.0%}){f', mostly by {kind} ({share:.0%})' if share else ''};"
        f" {row['hit']:.0%} hit, {row['no_candidate']:.0%} without candidate"
    )


def _advice(result: dict[str, Any]) -> list[str]:
    """What to add: movements where parts come in time but are hit, else ways to the parts."""
    total = result["all"]
    lines = [
        f"{total['hit']:.0%} are hit though parts come in time: movements are missing, first of all"
        " against the balls above",
        f"{total['no_candidate']:.0%} have no part that comes in time or can be timed:"
        f" {_missing_ways(result)}",
    ]
    if total["no_candidate"] > total["hit"]:
        lines.reverse()
    few = [
        f"{kind} avoids {share:.1%} (labelled parts: {result['parts'][kind]})"
        for kind, share in total["kinds"].items()
        if share < SELDOM
    ]
    return lines + ([f"hardly used: {', '.join(few)}"] if few else [])


def _missing_ways(result: dict[str, Any]) -> str:
    """Where the character stands too far from any part, by the middle time of arrival."""
    late = result["out_of_reach"][len(result["out_of_reach"]) // 2]
    if not late["nodes"]:
        return f"but every node reaches a part within {late['within_s']:g} s"
    places = [
        f"{row['clip']} {row['seconds'][0]:.1f}–{row['seconds'][1]:.1f} s"
        for row in late["stretches"][:LISTED]
    ]
    more = len(late["stretches"]) - len(places)
    return (
        f"{late['share']:.0%} of the nodes reach none within {late['within_s']:g} s, add"
        f" transitions or parts there: {', '.join(places)}"
        + (f" ({more} more stretches in coverage.json)" if more else "")
    )
