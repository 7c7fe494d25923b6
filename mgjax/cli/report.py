"""Printing results: one JSON object, or lines for people."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from mgjax.graph.types import NO_CLIP, MotionGraph


def emit(result: dict[str, Any], lines: list[str], *, as_json: bool) -> None:
    """Prints a result on stdout."""
    print(to_json(result) if as_json else "\n".join(lines), flush=True)


def to_json(result: dict[str, Any]) -> str:
    """Strict JSON on one line."""
    return json.dumps(result, allow_nan=False)


def seams_json(
    graph: MotionGraph, edges: np.ndarray, starts: np.ndarray, seconds: float
) -> list[dict[str, float]]:
    """Where a written motion of so many seconds has transitions, for ``mgjax quality``.

    Args:
        graph: the graph.
        edges: of the walk.
        starts: seconds of the motion at which each edge begins, and the last one ends.
        seconds: length of the motion.
    """
    return [
        {"start_s": float(starts[i]), "end_s": min(float(starts[i + 1]), seconds)}
        for i in np.flatnonzero(graph.edge_clip[edges] == NO_CLIP)
        if starts[i] < seconds
    ]
