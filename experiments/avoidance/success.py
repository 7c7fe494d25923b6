"""How many balls are avoided, with all avoidance parts and with genuine evasions only.

    python -m experiments.avoidance.success --graph out/real [--balls 200] [--seed 0]

Balls fly at 10 m/s from any side, 0.5–1.7 m high over the root, and arrive in 1.2 s.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from experiments.avoidance.calibrate import seeded_balls
from mgjax.avoidance.attack import Attack
from mgjax.avoidance.selection import select
from mgjax.core.compilation import enable_cache
from mgjax.graph.files import load_graph
from mgjax.graph.types import MotionGraph


def genuine_parts(graph: MotionGraph) -> MotionGraph:
    """The same graph with only the labels of real evasions."""
    kept = np.flatnonzero(graph.label_genuine)
    return replace(
        graph,
        label_edge=graph.label_edge[kept],
        label_starts=graph.label_starts[kept],
        label_stops=graph.label_stops[kept],
        label_kind=tuple(graph.label_kind[i] for i in kept),
        label_direction=tuple(graph.label_direction[i] for i in kept),
        label_genuine=graph.label_genuine[kept],
    )


def success(graph: MotionGraph, balls: list[tuple[int, Attack]]) -> dict[str, Any]:
    """Shares by status, the kinds that avoided, and what stood in the way of the rest."""
    statuses: Counter[str] = Counter()
    kinds: Counter[str] = Counter()
    dropped: Counter[str] = Counter()
    genuine = 0
    deep: list[float] = []
    for node, attack in balls:
        chosen = select(graph, node, attack)
        statuses[chosen.status] += 1
        if chosen.status == "avoided" and chosen.part is not None:
            kinds[graph.label_kind[chosen.part]] += 1
            genuine += bool(graph.label_genuine[chosen.part])
        else:
            for name in ("not_adjustable", "time_scale", "hit", "overflow"):
                dropped[name] += getattr(chosen.dropped, name)
        if chosen.status == "hit" and chosen.clearance_m is not None:
            deep.append(-chosen.clearance_m)
    return {
        "avoided": statuses["avoided"] / len(balls),
        "avoided_by_a_genuine_part": genuine / len(balls),
        "hit": statuses["hit"] / len(balls),
        "no_candidate": statuses["no_candidate"] / len(balls),
        "kinds": dict(kinds),
        "candidates_dropped_where_not_avoided": dict(dropped),
        "depth_of_hits_m_p50": float(np.median(deep)) if deep else None,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--graph", required=True)
    parser.add_argument("--balls", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    enable_cache()
    graph = load_graph(arguments.graph)
    balls = seeded_balls(graph, arguments.balls, arguments.seed)
    result = {
        "balls": len(balls),
        "threshold_m": graph.report["threshold_m"],
        "all_parts": success(graph, balls),
        "genuine_parts": success(genuine_parts(graph), balls),
    }
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
