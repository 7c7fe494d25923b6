"""Motion graphs for characters that react: avoid, kick, walk and reach, in JAX.

Importing this package does no work; names are loaded when they are first used.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "Skeleton": "mgjax.core.skeleton",
    "Motion": "mgjax.core.motion",
    "MgjaxError": "mgjax.core.errors",
    "global_positions": "mgjax.core.kinematics",
    "load_motion": "mgjax.io.load",
    "save_bvh": "mgjax.io.bvh_write",
}
_ROOMS = ("core", "io", "clips", "graph", "avoidance", "ballsport", "hybrid")
__all__ = [*_HOMES, *_ROOMS, "__version__"]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    if name in _ROOMS:
        return importlib.import_module(f"mgjax.{name}")
    raise AttributeError(f"module 'mgjax' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
