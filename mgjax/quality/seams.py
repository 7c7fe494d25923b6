"""Where a written motion has seams, as the result beside it says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mgjax.core.errors import FileFormatError
from mgjax.io.json_text import line_of, parse_json, shown
from mgjax.io.text import read_text

RESULT = "result.json"
MOTION = "motion"
"""The file that a result beside it tells of, without its suffix."""


def seams_of(path: str | Path) -> tuple[tuple[float, float], ...]:
    """First and last second of each seam of a motion file; none where nothing is said.

    Read from ``seams`` in ``result.json`` beside ``motion.bvh``, as ``mgjax avoid``, ``walk`` and
    ``demo`` write it.

    Raises:
        FileFormatError: the result is no JSON, or its seams are not what they should be.
    """
    result = Path(path).parent / RESULT
    if Path(path).stem != MOTION or not result.is_file():
        return ()
    text = read_text(result, "JSON")
    document = parse_json(result, text, expected="the result of a motion")
    rows = document.get("seams", []) if isinstance(document, dict) else []
    if not isinstance(rows, list):
        line = line_of(text, ("seams",))
        raise FileFormatError(result, line, f"seams {shown(rows)}", "a list")
    return tuple(_seam(result, text, i, row) for i, row in enumerate(rows))


def _seam(result: Path, text: str, number: int, row: Any) -> tuple[float, float]:
    start, end = (row.get("start_s"), row.get("end_s")) if isinstance(row, dict) else (None, None)
    if isinstance(start, float) and isinstance(end, float) and start <= end:
        return start, end
    got = f"from {shown(start)} to {shown(end)}" if isinstance(row, dict) else shown(row)
    line = line_of(text, ("seams", number))
    raise FileFormatError(result, line, f"a seam {got}", "start_s and, not before it, end_s")
