"""Two benchmarks compared: ratios to the bare kernel of each run, and how sure the verdict is."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mgjax.core.errors import FileFormatError
from mgjax.io.text import read_text

FILE_NAME = "bench.json"
SAME = 0.10
"""Times that differ by less count as the same."""
DRAWS = 2000


def load_bench(path: str | Path) -> dict[str, Any]:
    """What ``mgjax bench all --out`` wrote: the file, or the folder it is in.

    Raises:
        FileFormatError: no such file.
    """
    path = Path(path)
    file = path / FILE_NAME if path.is_dir() else path
    try:
        found = json.loads(read_text(file, "benchmark"))
        if all("ratios" in row and "axis" in row for row in found["rows"]) and found["rows"]:
            return found
    except (ValueError, KeyError, TypeError):
        pass
    raise FileFormatError(file, None, "other text", "what mgjax bench all wrote")


def compare(a: Mapping[str, Any], b: Mapping[str, Any], *, seed: int = 0) -> list[dict[str, Any]]:
    """A verdict for each case and size that both have.

    A call and the bare kernel are timed next to each other, so their ratio holds on a machine that
    others use. Compared are the medians of these ratios; the interval holds 95 % of what medians of
    calls drawn anew from both give.

    Returns:
        Rows with ``case``, ``axis``, ``size``; ``ratio``, time of B over that of A; ``interval`` of
        it; ``verdict``: ``slower`` or ``faster`` where the whole interval is beyond 1 and the ratio
        beyond 10 %, ``same`` where the whole interval is within 10 %, else ``undecided``.
    """
    known = {_key(row): row for row in a["rows"]}
    rng = np.random.default_rng(seed)
    rows = []
    for row in b["rows"]:
        if _key(row) in known:
            one, other = (np.log(x["ratios"]) for x in (known[_key(row)], row))
            log = float(np.median(other) - np.median(one))
            drawn = _medians(other, rng) - _medians(one, rng)
            low, high = np.percentile(drawn, [2.5, 97.5])
            rows.append(
                {key: row[key] for key in ("case", "axis", "size")}
                | {
                    "ratio": float(np.exp(log)),
                    "interval": [float(np.exp(low)), float(np.exp(high))],
                    "verdict": verdict(log, low, high),
                }
            )
    return rows


def verdict(log: float, low: float, high: float) -> str:
    """In a word; of the logarithm of a ratio and of its interval."""
    limit = np.log1p(SAME)
    if low > 0 and log > limit:
        return "slower"
    if high < 0 and log < -limit:
        return "faster"
    return "same" if -limit <= low and high <= limit else "undecided"


def differ(a: Mapping[str, Any], b: Mapping[str, Any]) -> Sequence[str]:
    """What the two benchmarks were made with that is not the same."""
    keys = ("git_revision", "git_dirty", "versions", "machine", "graph")
    return [key for key in keys if a.get(key) != b.get(key)]


def _key(row: Mapping[str, Any]) -> tuple:
    return row["case"], row["axis"], row["size"]


def _medians(values: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return np.median(rng.choice(values, (DRAWS, len(values))), axis=1)
