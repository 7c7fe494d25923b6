"""Work on a motion graph's shape: what is strongly connected."""

from __future__ import annotations

from typing import Any

import numpy as np

from experiments.benchmarks.beside.calls import Calls
from experiments.benchmarks.beside.types import Job
from mgjax.graph.pruning.prune import Candidates, largest_component


def components(seed: int, items: int, *, nodes: int, clip: int = 500) -> Job:
    """Transitions between all nodes of clips whose every frame is left or entered by one."""
    rng = np.random.default_rng(seed)
    inner = np.setdiff1d(np.arange(nodes), np.arange(0, nodes, clip))
    leave, arrive = rng.choice(inner, nodes), rng.permutation(np.resize(inner, nodes))
    starts = np.arange(0, nodes, clip)
    none = np.zeros(0, int)
    candidates = Candidates(
        leave=leave,
        arrive=arrive,
        distances=np.zeros(nodes),
        starts=starts,
        stops=starts + clip,
        label_starts=none,
        label_stops=none,
    )

    def kept() -> int:
        return int(largest_component(candidates, nodes).kept.sum())

    right = kept()

    def call(_: int) -> Any:
        return largest_component(candidates, nodes)

    def miss(_: int, found: Any) -> float:
        return abs(int(found.kept.sum()) - right)

    data = {
        "nodes": nodes,
        "clip": clip,
        "leave": leave.tolist(),
        "arrive": arrive.tolist(),
        "right": right,
    }
    return Job(data=data, ours=Calls(count=1, call=call, miss=miss), tolerance=0.0)
