"""The folder of a graph: the graph, its index, and what came of building them."""

from __future__ import annotations

import json
import time
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from mgjax.avoidance.index.build import build_index
from mgjax.avoidance.index.files import FILE_NAME, save_index
from mgjax.graph.files import save_graph
from mgjax.graph.types import MotionGraph
from mgjax.io.content_key import content_key
from mgjax.io.output import replace_file
from mgjax.io.stages import StageStore

STAGE = "index"

KEYS = (
    "frames",
    "clips",
    "transitions",
    "nodes",
    "edges",
    "threshold_m",
    "labels_total",
    "labels_kept",
    "labels_enterable",
    "genuine_total",
    "genuine_kept",
    "genuine_enterable",
    "connectivity",
    "seconds",
    "foot_slide_before",
    "foot_slide_after",
    "index",
    "retargeted",
    "notes",
)
"""What ``build.json`` has of the report."""


def write_graph_folder(
    folder: Path,
    graph: MotionGraph,
    *,
    begin: float,
    index: bool = True,
    progress: bool = False,
    store: StageStore | None = None,
) -> dict[str, Any]:
    """Writes ``graph.safetensors``, the index where labels can be entered, and ``build.json``.

    Args:
        folder: is there.
        graph: its report gets the seconds that writing took, and those since ``begin``.
        begin: of the clock ``time.perf_counter``.
        index: makes the index, too.
        progress: shows bars on stderr.
        store: keeps the index, for another build of the same graph.

    Returns:
        What stands in ``build.json``.
    """
    report = graph.report
    start = time.perf_counter()
    save_graph(folder, graph)
    report["seconds"]["save"] = round(time.perf_counter() - start, 4)
    wanted = report["labels_enterable"] and index
    report["index"] = _write_index(folder, graph, store, progress) if wanted else None
    report["seconds"]["total"] = round(time.perf_counter() - begin, 4)
    result = {key: report[key] for key in KEYS}
    (folder / "build.json").write_text(json.dumps(result, allow_nan=False) + "\n")
    return result


def _key(graph: MotionGraph) -> str:
    """Names all of a graph but what is told of how it was made."""
    return content_key([getattr(graph, f.name) for f in fields(graph) if f.name != "report"])


def _write_index(
    folder: Path, graph: MotionGraph, store: StageStore | None, progress: bool
) -> dict[str, Any]:
    """Writes the index of a graph, as it was made or as it is kept; what it reports."""
    key = "" if store is None else _key(graph)
    kept = None if store is None else store.load(STAGE, key)
    if kept is not None:
        replace_file(folder / FILE_NAME, kept[0]["file"].tobytes())
        return kept[1]["report"]
    made = build_index(graph, progress=progress)
    save_index(folder, made)
    if store is not None:
        file = np.frombuffer((folder / FILE_NAME).read_bytes(), np.uint8)
        store.save(STAGE, key, {"file": file}, {"report": made.report})
    return made.report
