"""What the answers of a coverage amount to, as JSON values: per cell, region, clip and place."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from mgjax.avoidance.coverage.shares import cells, outcomes, shares, worst_cells
from mgjax.avoidance.coverage.throws import Coverage
from mgjax.core.body.height import body_height
from mgjax.graph.types import MotionGraph

COMPASS = (
    *("ahead", "ahead left", "the left", "behind left"),
    *("behind", "behind right", "the right", "ahead right"),
)
"""Where a ball comes from, every 45° from ahead towards the left."""
BANDS = {"low": (0.0, 0.4), "waist-high": (0.4, 0.75), "high": (0.75, np.inf)}
"""Heights in words, in parts of the height of the rest pose."""
QUANTILES = (0.0, 0.1, 0.5, 0.9, 1.0)


def coverage_report(graph: MotionGraph, result: Coverage) -> dict[str, Any]:
    """The shares of all attacks, and where they are worst, as JSON values.

    ``cells`` has one list per direction with one share per height, None where no ball was thrown.
    ``regions`` and ``directions`` begin with the worst served. ``out_of_reach`` has, per time of
    arrival, the nodes from which eq. 1 cannot have any candidate because no part comes in time.
    """
    everything = np.ones(len(result), bool)
    candidates = result.answers.candidates
    return {
        "attacks": len(result),
        "nodes": len(np.unique(result.node)),
        "speed_m_s": result.speed,
        "directions_deg": np.degrees(result.directions).round(3).tolist(),
        "heights_m": result.heights.tolist(),
        "arrivals_s": result.arrivals.tolist(),
        "parts": {kind: graph.label_kind.count(kind) for kind in result.kinds},
        "all": shares(result, everything),
        "arrivals": [
            {"arrival_s": float(x)} | shares(result, result.arrival == i)
            for i, x in enumerate(result.arrivals)
        ],
        "cells": {name: _lists(cells(result, mask)) for name, mask in outcomes(result).items()},
        "worst_cells": [_cell(result, *cell) for cell in worst_cells(result)],
        "directions": _directions(result),
        "regions": _regions(graph, result),
        "clips": _clips(graph, result),
        "out_of_reach": [_out_of_reach(graph, result, arrival) for arrival in result.arrivals],
        "nearest_part_s": _quantiles(result.nearest_part[np.isfinite(result.nearest_part)]),
        "nodes_without_any_part": int(np.isinf(result.nearest_part).sum()),
        "candidates": _quantiles(candidates) | {"mean": round(float(candidates.mean()), 2)},
    }


def _lists(values: Float[np.ndarray, "D H"]) -> list[list[float | None]]:
    return [[None if np.isnan(x) else round(float(x), 4) for x in row] for row in values]


def _cell(result: Coverage, direction: int, height: int) -> dict[str, Any]:
    angle = float(result.directions[direction])
    return {
        "direction_deg": round(float(np.degrees(angle)), 3),
        "from": bearing(angle),
        "height_m": float(result.heights[height]),
        **shares(result, (result.direction == direction) & (result.height == height)),
    }


def bearing(angle: float) -> str:
    """A direction in words: how far from ahead, and to which side."""
    degrees = round(float((np.degrees(angle) + 180) % 360 - 180), 1)
    if abs(degrees) in (0, 180):
        return "ahead" if degrees == 0 else "behind"
    return f"{abs(degrees):g}° to the {'left' if degrees > 0 else 'right'}"


def _directions(result: Coverage) -> list[dict[str, Any]]:
    rows = [
        {"direction_deg": round(float(np.degrees(angle)), 3), "from": bearing(angle)}
        | shares(result, result.direction == i)
        for i, angle in enumerate(result.directions)
    ]
    return sorted(rows, key=lambda row: row["avoided"])


def _regions(graph: MotionGraph, result: Coverage) -> list[dict[str, Any]]:
    """Attacks from within 22.5° of each point of the compass, in three bands of height.

    A direction half-way between two points counts for both.
    """
    tall = body_height(graph.skeleton) or 0.0
    rows: list[dict[str, Any]] = []
    for number, word in enumerate(COMPASS):
        off = np.abs((np.degrees(result.directions) - 45 * number + 180) % 360 - 180)
        from_there = (off <= 22.5 + 1e-6)[result.direction]
        for band, (low, high) in BANDS.items():
            within = (result.heights >= low * tall) & (result.heights < high * tall)
            mask = from_there & within[result.height]
            if mask.any():
                heights = result.heights[within]
                row = {"band": band, "heights_m": [float(heights[0]), float(heights[-1])]}
                rows.append({"from": word} | row | shares(result, mask))
    return sorted(rows, key=lambda row: row["avoided"])


def _clips(graph: MotionGraph, result: Coverage) -> list[dict[str, Any]]:
    """By the clip in which the character stands, the worst served first."""
    clip = graph.node_clip[result.node]
    rows: list[dict[str, Any]] = [
        {
            "clip": graph.clip_names[int(i)],
            "nodes": len(np.unique(result.node[clip == i])),
            **shares(result, clip == i),
        }
        for i in np.unique(clip)
    ]
    return sorted(rows, key=lambda row: row["avoided"])


def _out_of_reach(graph: MotionGraph, result: Coverage, arrival: float) -> dict[str, Any]:
    """The nodes that have no part within eq. 1, as stretches of clips, the longest first."""
    limit = float(arrival) + result.window / 2
    late = result.nearest_part >= limit
    return {
        "arrival_s": float(arrival),
        "within_s": round(limit, 4),
        "nodes": int(late.sum()),
        "share": round(float(late.mean()), 4),
        "stretches": sorted(_stretches(graph, result, late), key=lambda x: -len(x["nodes"])),
    }


def _stretches(
    graph: MotionGraph, result: Coverage, late: Bool[np.ndarray, " N"]
) -> list[dict[str, Any]]:
    """Late nodes of one clip without one between them that is in time."""
    order = np.lexsort((graph.node_frame, graph.node_clip))
    clip, is_late = graph.node_clip[order], late[order]
    changes = (np.diff(clip) != 0) | (np.diff(is_late.astype(np.int8)) != 0)
    rows: list[dict[str, Any]] = []
    for run in np.split(order, np.flatnonzero(changes) + 1):
        if not late[run[0]]:
            continue
        here = int(graph.node_clip[run[0]])
        frames = graph.node_frame[run[[0, -1]]] - graph.clip_starts[here]
        slowest = float(result.nearest_part[run].max())
        rows.append(
            {
                "clip": graph.clip_names[here],
                "frames": frames.tolist(),
                "seconds": (frames / graph.frame_rate).round(3).tolist(),
                "nearest_part_s": round(slowest, 4) if np.isfinite(slowest) else None,
                "nodes": run.tolist(),
            }
        )
    return rows


def _quantiles(values: np.ndarray) -> dict[str, float | None]:
    names = [f"p{100 * q:g}" for q in QUANTILES]
    if not len(values):
        return dict.fromkeys(names)
    result = np.quantile(values, QUANTILES).round(4).tolist()
    return dict(zip(names, result, strict=True))
