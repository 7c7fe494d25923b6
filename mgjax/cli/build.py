"""``mgjax build``."""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from typing import Any

from mgjax.avoidance.index.graph_folder import write_graph_folder
from mgjax.cli.arguments import Build
from mgjax.cli.files.reading import read_as_of
from mgjax.cli.report import emit
from mgjax.clips.folder import load_clips
from mgjax.clips.labels import load_labels
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.stages.choice import build_stages
from mgjax.graph.stages.stages import stage_store
from mgjax.graph.walk import random_walk
from mgjax.io.load import load_motion
from mgjax.io.output import output_folder
from mgjax.io.toml_file import load_config
from mgjax.stage.html import save_html

WALK_S = 20.0
"""How long the walk on the page lasts."""


def run(command: Build) -> None:
    """Reads clips and labels, builds the graph, writes it."""
    begin = time.perf_counter()
    config = load_config(command.config, GraphConfig) if command.config else GraphConfig()
    switches = {"mirror": command.mirror, "retarget": command.retarget}
    config = replace(config, **{name: True for name, on in switches.items() if on})
    progress = sys.stderr.isatty()
    with output_folder(command.out) as folder:
        store = None if command.work is None else stage_store(command.work)
        read_as = read_as_of(command, command.roles)
        clips, notes = load_clips(
            command.clips,
            exclude=command.exclude,
            progress=progress,
            read_as=read_as,
            skip_bad=command.skip_bad,
            need_body=not command.no_body,
            store=store,
        )
        labels = load_labels(command.labels, clips, command.clips) if command.labels else None
        skeleton = load_motion(command.skeleton) if command.skeleton else None
        readings = {clip.name: dict(clip.reading) for clip in clips}
        read = time.perf_counter()
        with build_stages(
            frames=sum(clip.motion.num_frames for clip in clips),
            store=store,
            name=command.executor,
            workers=command.workers,
            address=command.address,
            device=command.device,
        ) as stages:
            graph = build_graph(
                clips,
                labels=labels,
                config=config,
                skeleton=skeleton,
                progress=progress,
                stages=stages,
            )
        report = graph.report
        report["notes"] = notes + report["notes"]
        report["readings"] = readings
        report["seconds"] = {"read": round(read - begin, 4), **report["seconds"]}
        result = write_graph_folder(
            folder,
            graph,
            begin=begin,
            index=not command.no_index,
            progress=progress,
            store=None if stages is None else stages.store,
        )
        if command.html:
            walk = random_walk(graph, int(graph.edge_source[0]), WALK_S, 0)
            save_html(folder / "index.html", walk, title="A random walk")
    emit(result, _lines(result, str(command.out)), as_json=command.json)


def _lines(result: dict[str, Any], out: str) -> list[str]:
    lines = [f"note: {note}" for note in result["notes"]]
    lines += [
        f"{result['clips']} clips, {result['frames']} frames: {result['transitions']} transitions"
        f" below {result['threshold_m']:.4f} m, {result['nodes']} nodes, {result['edges']} edges",
        f"labels: {result['labels_kept']} of {result['labels_total']} kept,"
        f" {result['labels_enterable']} enterable; genuine: {result['genuine_kept']} of"
        f" {result['genuine_total']} kept, {result['genuine_enterable']} enterable",
        *_time_to_part(result["connectivity"]["time_to_part_s"]),
        f"planted feet travel {1000 * result['foot_slide_before']:.2f} mm per transition frame as"
        f" blended, {1000 * result['foot_slide_after']:.2f} mm cleaned",
        f"{result['seconds']['total']:.1f} s; written to {out}",
    ]
    return lines


def _time_to_part(times: dict[str, dict[str, float | None]]) -> list[str]:
    """Half of all frames, and 95 % of them, are this near to a part."""

    def text(seconds: float | None) -> str:
        return "–" if seconds is None else f"{seconds:.1f}"

    kinds = [f"{name} {text(row['p50'])}/{text(row['p95'])}" for name, row in times.items()]
    return [f"time to a part (p50/p95, s): {', '.join(kinds)}"] if kinds else []
