"""pyfabrik: FABRIK of one chain."""

from __future__ import annotations

from typing import Any

import numpy as np

from experiments.benchmarks.beside.calls import Calls


def set_up(joints: Any, targets: Any, tolerance: float) -> Calls:
    """A chain moves when it is solved: each call has one of its own, made before."""
    from pyfabrik import Fabrik3D  # pyright: ignore[reportMissingImports]
    from vectormath import Vector3  # pyright: ignore[reportMissingImports]

    def before(number: int) -> Any:
        places = [Vector3(*place) for place in joints]
        return Fabrik3D(joint_positions=places, tolerance=tolerance), Vector3(*targets[number])

    def call(given: Any) -> Any:
        chain, target = given
        chain.move_to(target)
        return chain

    def miss(number: int, chain: Any) -> float:
        end = chain.joints[-1]
        return float(np.linalg.norm(np.array([end.x, end.y, end.z]) - targets[number]))

    return Calls(count=len(targets), call=call, miss=miss, before=before)
