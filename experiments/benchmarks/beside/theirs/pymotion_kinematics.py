"""upc-pymotion: forward kinematics of a motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from experiments.benchmarks.beside.calls import Calls


def set_up(rotations: Any, roots: Any, offsets: Any, parents: Any, right: Any) -> Calls:
    """Arrays as its reader of BVH gives them."""
    from pymotion.ops.skeleton import fk  # pyright: ignore[reportMissingImports]

    given = np.array(rotations), np.array(roots), np.array(offsets), np.array(parents)
    wanted = np.array(right)
    return Calls(
        count=1,
        call=lambda _: fk(*given)[0],
        miss=lambda _, found: np.abs(found - wanted).max(),
    )
