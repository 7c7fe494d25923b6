"""Building the graph again from the clips and the labels as they are now."""

from __future__ import annotations

import time
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mgjax.avoidance.index.graph_folder import write_graph_folder
from mgjax.clips.types import Labels
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import MotionGraph
from mgjax.io.output import output_folder
from mgjax.stage.apps.edit.job import Watch
from mgjax.stage.apps.edit.library import Library

_READ, _BUILT = 0.2, 0.9
"""About how much is done when the clips are read, and when the graph is built."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Built:
    """A graph, the labels it was asked to hold, and what there is to say of both."""

    graph: MotionGraph
    labels: Labels
    sentence: str
    notes: tuple[str, ...]


def rebuild(
    library: Library,
    labels: Labels,
    without: Collection[str],
    config: GraphConfig,
    folder: Path | None,
    watch: Watch,
) -> Built:
    """Reads all clips but some, builds the graph, and writes it where a folder is given.

    Files that cannot be read are left out, and said in the notes; likewise labels of clips that
    are not used.

    Raises:
        MgjaxError: what :func:`mgjax.graph.build.build_graph` refuses; nothing is written then.
    """
    begin = time.perf_counter()
    watch(0.0, "reading clips")
    clips, notes = library.load(
        lambda share: watch(_READ * share, "reading clips"), without, labels.keys()
    )
    names = {clip.name for clip in clips}
    used = {name: items for name, items in labels.items() if name in names}
    notes += _without_clip(labels, names)
    read = time.perf_counter()
    graph = build_graph(
        clips,
        labels=used,
        config=config,
        watch=lambda share, text: watch(_READ + share * (_BUILT - _READ), text),
    )
    report = graph.report
    report["notes"] = notes + report["notes"]
    report["readings"] = {clip.name: dict(clip.reading) for clip in clips}
    report["seconds"] = {"read": round(read - begin, 4), **report["seconds"]}
    if folder is not None:
        watch(_BUILT, "making the index, writing the graph")
        with output_folder(folder) as place:
            write_graph_folder(place, graph, begin=begin)
    took = time.perf_counter() - begin
    return Built(
        graph=graph,
        labels=used,
        sentence=f"{describe(report)}, in {took:.1f} s" + (f"; in {folder}" if folder else ""),
        notes=tuple(report["notes"]),
    )


def describe(report: dict[str, Any]) -> str:
    """What came of a build, in one sentence."""
    return (
        f"{report['clips']} clips, {report['nodes']} nodes, {report['edges']} edges of which"
        f" {report['transitions']} transitions below {100 * report['threshold_m']:.1f} cm;"
        f" labels: {report['labels_kept']} of {report['labels_total']} kept,"
        f" {report['labels_enterable']} can be entered"
    )


def _without_clip(labels: Labels, names: Collection[str]) -> list[str]:
    return [
        f"{name}: {len(items)} labels left out with their clip"
        for name, items in labels.items()
        if name not in names
    ]
