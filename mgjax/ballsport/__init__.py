"""Ball sport: hit motions found in capture, matched to a live motion, and the ball between players.

After Choi, Kim, Kim and Kang, *Generating a Ball Sport Scene in a Virtual Environment* (2019).
"""

from __future__ import annotations

import importlib
from typing import Any

_HOMES: dict[str, str] = {}
__all__ = list(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mgjax.ballsport' has no attribute {name!r}")
