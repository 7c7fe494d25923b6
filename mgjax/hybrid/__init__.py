"""Hybrid motion graphs: walks along a sketched path, and hands and head that reach on the way.

After Kalouache and Cherif, *Hybrid Motion Graphs for Character Animation*, and Kovar, Gleicher and
Pighin, *Motion Graphs* (2002).
"""

from __future__ import annotations

import importlib
from typing import Any

_HOMES: dict[str, str] = {}
__all__ = list(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mgjax.hybrid' has no attribute {name!r}")
