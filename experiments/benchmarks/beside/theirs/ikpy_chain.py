"""ikpy: a chain of ball joints, each of three hinges."""

from __future__ import annotations

from typing import Any

import numpy as np

from experiments.benchmarks.beside.calls import Calls

AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def set_up(offsets: Any, targets: Any, tolerance: float) -> Calls:
    """From rest, with its own stopping rule: it takes no tolerance."""
    from ikpy.chain import Chain  # pyright: ignore[reportMissingImports]
    from ikpy.link import OriginLink, URDFLink  # pyright: ignore[reportMissingImports]

    links: list[Any] = [OriginLink()]
    for number, offset in enumerate(offsets[:-1]):
        for axis, way in AXES.items():
            links.append(
                URDFLink(
                    name=f"{axis}{number}",
                    origin_translation=list(offset) if axis == "x" else [0.0, 0.0, 0.0],
                    origin_orientation=[0.0, 0.0, 0.0],
                    rotation=list(way),
                )
            )
    tip = {"origin_translation": list(offsets[-1]), "origin_orientation": [0.0, 0.0, 0.0]}
    links.append(URDFLink(name="tip", rotation=None, joint_type="fixed", **tip))
    chain = Chain(links, active_links_mask=[False, *[True] * (len(links) - 2), False])

    def miss(number: int, found: Any) -> float:
        return float(np.linalg.norm(chain.forward_kinematics(found)[:3, 3] - targets[number]))

    def call(number: int) -> Any:
        return chain.inverse_kinematics(targets[number])

    return Calls(count=len(targets), call=call, miss=miss)
