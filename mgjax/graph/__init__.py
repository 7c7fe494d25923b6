"""Motion graphs: which pieces of motion can follow one another, and walks over them."""

from __future__ import annotations

import importlib
from typing import Any

_HOMES = {
    "GraphConfig": "mgjax.graph.config",
    "MotionGraph": "mgjax.graph.types",
    "build_graph": "mgjax.graph.build",
    "distance_matrix": "mgjax.graph.distance",
    "load_graph": "mgjax.graph.files",
    "save_graph": "mgjax.graph.files",
    "unroll": "mgjax.graph.walk",
}
__all__ = list(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mgjax.graph' has no attribute {name!r}")
