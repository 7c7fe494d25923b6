"""Printing results: one JSON object, or lines for people."""

from __future__ import annotations

import json
from typing import Any


def emit(result: dict[str, Any], lines: list[str], *, as_json: bool) -> None:
    """Prints a result on stdout."""
    print(to_json(result) if as_json else "\n".join(lines), flush=True)


def to_json(result: dict[str, Any]) -> str:
    """Strict JSON on one line."""
    return json.dumps(result, allow_nan=False)
