"""Cases measured over their sizes: times, memory, growth, and the ratio to a bare kernel."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from mgjax.bench.cases import Case, bare_pass
from mgjax.bench.timing import interleaved


def case_rows(
    found: Sequence[Case], *, repeats: int = 9, most: int | None = None, progress: bool = False
) -> list[dict[str, Any]]:
    """A row for each case and size.

    Args:
        found: what is measured.
        repeats: calls of each, in turns with the bare kernel, after a first one of both.
        most: sizes of a case that are taken, the smallest first; None: all.
        progress: shows a bar with the time left.

    Returns:
        What :func:`mgjax.bench.timing.interleaved` says, with ``case``, ``axis``, ``size`` and
        ``peak_memory_mb``, the largest memory of this process meanwhile; None where the system does
        not tell.
    """
    todo = [(case, size) for case in found for size in case.sizes[:most]]
    rows = []
    for case, size in tqdm(todo, leave=False, disable=not progress):
        work, bare = case.make(size), bare_pass(case.items(size))
        forget_peak()
        row = interleaved(work, bare, repeats)
        named = {"case": case.name, "axis": case.axis, "size": size}
        rows.append(named | row | {"peak_memory_mb": peak_memory_mb()})
    return rows


def exponents(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """How the time of each case grows: time ∝ size to this power, fitted over all its sizes."""
    found = []
    for name, axis in dict.fromkeys((row["case"], row["axis"]) for row in rows):
        some = [row for row in rows if (row["case"], row["axis"]) == (name, axis)]
        if len(some) > 1:
            sizes, times = (np.log([row[key] for row in some]) for key in ("size", "median_s"))
            slope = float(np.polyfit(sizes, times, 1)[0])
            found.append({"case": name, "axis": axis, "exponent": slope})
    return found


def forget_peak() -> None:
    """Begins to count the peak of this process's memory anew, where the system can."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def peak_memory_mb() -> float | None:
    """The largest resident memory of this process since :func:`forget_peak`, MB."""
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM"):
                return int(line.split()[1]) / 1024
    except OSError:
        pass
    return None
