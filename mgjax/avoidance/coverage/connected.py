"""How well a graph is connected to what avoids: its sampled measures, from the balls of a coverage.

The measures that need no balls are in :mod:`mgjax.graph.parts.connectivity`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Int

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.choice.choosing import can_widen, widened
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.search import DEPTH, STATUS, search_candidates
from mgjax.avoidance.choice.start import Query, ask
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.coverage.throws import DISTANCE_M, Coverage
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.avoidance.rates import CLEAR_M
from mgjax.avoidance.timing.time_scale import OK
from mgjax.graph.parts.connectivity import connectivity
from mgjax.graph.types import NO_CLIP, MotionGraph

SAMPLED = 200
"""Balls of a coverage whose candidates are all looked at."""
JUDGED = 4096
"""Most candidates of a ball that are looked at."""
SERVED = 0.9
"""Share of the nodes that must avoid the balls of a cell for it to count as avoidable."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Answers:
    """All that would have answered some attacks.

    Attributes:
        parts: by how many parts each could have been avoided. [B]
        used: which frames of the clips some clear candidate plays. [F]
    """

    parts: Int[np.ndarray, " B"]
    used: Bool[np.ndarray, " F"]


def connected(
    graph: MotionGraph | Prepared,
    result: Coverage,
    *,
    config: AvoidanceConfig | None = None,
    sampled: int = SAMPLED,
) -> dict[str, Any]:
    """Measures of connectivity as JSON values.

    ``time_to_part_s``: see :func:`mgjax.graph.parts.connectivity.connectivity`.
    ``avoidable_cells``: share of the cells of direction, height and arrival in which at least
    ``SERVED`` of the nodes avoid their ball. ``clear_parts``: by how many different parts one of
    ``sampled`` balls can be avoided. ``dead_frames``: share of the graph's clip frames that no
    clear candidate of those balls plays. The last two go by the sampled volumes of the search,
    which tell within millimetres, up to the end of the path.
    """
    config = config or AvoidanceConfig()
    prepared = prepared_for(graph, config)
    rng = np.random.default_rng(0)
    chosen = np.sort(rng.permutation(len(result))[:sampled])
    found = answers_to(prepared, result, chosen, config)
    inside = _played(prepared.graph, np.flatnonzero(prepared.graph.edge_clip != NO_CLIP))
    low, middle, high = np.percentile(found.parts, (10, 50, 90), method="lower").tolist()
    return {
        **connectivity(prepared.graph),
        "avoidable_cells": round(avoidable_cells(result), 4),
        "sampled_balls": len(chosen),
        "clear_parts": {"p10": low, "p50": middle, "p90": high},
        "dead_frames": round(1 - float(found.used[inside].mean()), 4),
    }


def avoidable_cells(result: Coverage) -> float:
    """Share of the cells, of those in which balls were thrown, in which ``SERVED`` are avoided."""
    shape = (len(result.directions), len(result.heights), len(result.arrivals))
    cell = np.ravel_multi_index((result.direction, result.height, result.arrival), shape)
    avoided = result.answers.status == Status.AVOIDED.code
    thrown = np.bincount(cell, minlength=int(np.prod(shape)))
    counted = np.bincount(cell[avoided], minlength=len(thrown))
    return float((counted[thrown > 0] >= SERVED * thrown[thrown > 0] - 1e-9).mean())


def answers_to(
    prepared: Prepared, result: Coverage, balls: Int[np.ndarray, " B"], config: AvoidanceConfig
) -> Answers:
    """Which parts and frames could avoid some balls of a coverage, within the wide window."""
    config = widened(config) if can_widen(config) else config
    config = replace(config, capacity=max(config.capacity, JUDGED))
    graph = prepared.graph
    parts = np.zeros(len(balls), dtype=np.int64)
    used = np.zeros(int(graph.clip_stops.max(initial=0)), dtype=bool)
    for row, i in enumerate(balls.tolist()):
        ball = ball_from(
            float(result.directions[result.direction[i]]),
            float(result.heights[result.height[i]]),
            distance=DISTANCE_M,
            speed=result.speed,
            arrives=float(result.arrivals[result.arrival[i]]),
        )
        query = ask(prepared, int(result.node[i]), ball, config)
        if query is not None and len(query.in_time.length):
            part, edges = clear_parts(query)
            parts[row] = len(np.unique(part))
            used[_played(graph, np.unique(edges[graph.edge_clip[edges] != NO_CLIP]))] = True
    return Answers(parts=parts, used=used)


def clear_parts(query: Query) -> tuple[Int[np.ndarray, " C"], Int[np.ndarray, " L"]]:
    """The parts of the candidates that are clear, one for each, and all edges that they play."""
    found = query.in_time
    _, result = search_candidates(query, replace(found, overflow=0))
    table = np.asarray(result.table)[:, : len(found.length)]
    clear = (table[STATUS] == OK) & (table[DEPTH] >= CLEAR_M)
    edges = found.edges[clear]
    return found.part[clear], edges[edges >= 0]


def _played(graph: MotionGraph, edges: Int[np.ndarray, " E"]) -> Int[np.ndarray, " F"]:
    """The frames that some edges play."""
    counts = graph.edge_frames[edges]
    before = np.cumsum(counts) - counts
    return np.repeat(graph.edge_starts[edges] - before, counts) + np.arange(int(counts.sum()))
