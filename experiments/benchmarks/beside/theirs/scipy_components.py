"""scipy.sparse.csgraph: strong components of a graph given by its edges."""

from __future__ import annotations

from typing import Any

import numpy as np

from experiments.benchmarks.beside.calls import Calls


def set_up(nodes: int, clip: int, leave: Any, arrive: Any, right: int) -> Calls:
    """Which transitions lie in the largest part, frames of a clip leading to the next ones."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    leave, arrive = np.array(leave), np.array(arrive)
    frames = np.arange(nodes - 1)
    frames = frames[(frames + 1) % clip != 0]
    source = np.concatenate([frames, leave])
    target = np.concatenate([frames + 1, arrive])
    ones = np.ones(len(source), np.int8)

    def call(_: int) -> Any:
        graph = csr_array((ones, (source, target)), shape=(nodes, nodes))
        part = connected_components(graph, directed=True, connection="strong")[1]
        inside = part == np.bincount(part).argmax()
        return inside[leave] & inside[arrive]

    return Calls(count=1, call=call, miss=lambda _, kept: abs(int(kept.sum()) - right))
