"""Where the cases from the field are, and what is right for each."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDER = (ROOT / os.environ.get("MGJAX_CASES", "../shared/cases")).resolve()
"""``MGJAX_CASES`` names it, relative to the repository."""


def cases(kind: str) -> list[dict[str, Any]]:
    """The entries of ``expected.json`` whose input is in the folder ``kind``; none without it."""
    file = FOLDER / "expected.json"
    if not file.is_file():
        return []
    entries = json.loads(file.read_text(encoding="utf-8"))
    return [entry for entry in entries if Path(entry["input"]).parts[0] == kind]


def case_file(name: str) -> Path:
    """An input; where the cases are not there the test is skipped, or fails if it must run."""
    file = FOLDER / name
    if file.exists():
        return file
    reason = f"no {name} in {FOLDER}; set MGJAX_CASES to the folder of cases"
    if os.environ.get("MGJAX_REQUIRE_CAPTURE") == "1":
        pytest.fail(reason)
    pytest.skip(reason)
