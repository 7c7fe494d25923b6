"""Clips with names, their labels, and the procedural set that comes with the package."""

from __future__ import annotations

import importlib
from typing import Any

_HOMES = {
    "Clip": "mgjax.clips.types",
    "Label": "mgjax.clips.types",
    "load_labels": "mgjax.clips.labels",
    "load_clips": "mgjax.clips.folder",
    "synthetic_clips": "mgjax.clips.synthetic",
}
__all__ = list(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mgjax.clips' has no attribute {name!r}")
