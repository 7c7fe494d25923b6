"""The folder of a graph: the graph, its index, and what came of building them."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from mgjax.avoidance.index.build import build_index
from mgjax.avoidance.index.files import save_index
from mgjax.graph.files import save_graph
from mgjax.graph.types import MotionGraph

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
    folder: Path, graph: MotionGraph, *, begin: float, index: bool = True, progress: bool = False
) -> dict[str, Any]:
    """Writes ``graph.safetensors``, the index where labels can be entered, and ``build.json``.

    Args:
        folder: is there.
        graph: its report gets the seconds that writing took, and those since ``begin``.
        begin: of the clock ``time.perf_counter``.
        index: makes the index, too.
        progress: shows bars on stderr.

    Returns:
        What stands in ``build.json``.
    """
    report = graph.report
    start = time.perf_counter()
    save_graph(folder, graph)
    report["seconds"]["save"] = round(time.perf_counter() - start, 4)
    made = None
    if report["labels_enterable"] and index:
        made = build_index(graph, progress=progress)
        save_index(folder, made)
    report["index"] = made.report if made else None
    report["seconds"]["total"] = round(time.perf_counter() - begin, 4)
    result = {key: report[key] for key in KEYS}
    (folder / "build.json").write_text(json.dumps(result, allow_nan=False) + "\n")
    return result
