"""What pages name in the code is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.docs.pages import ROOT, pages

HOMES = [ROOT / "mgjax", *(ROOT / "mgjax" / n for n in ("avoidance", "ballsport", "hybrid")), ROOT]
PLACE = re.compile(r"`([\w/]+\.py)(?:: (\w+))?`")
SCRIPT = re.compile(r"python -m (experiments[\w.]+)")
FILE = re.compile(r"(?:configs|experiments)/[\w/]+\.(?:toml|py|png|gif)")


def found(name: str) -> list[Path]:
    return [path for home in HOMES if (path := home / name).is_file()]


@pytest.mark.parametrize("page", pages())
def test_names_are_there(page: str) -> None:
    text = (ROOT / page).read_text()
    for file, name in PLACE.findall(text):
        homes = found(file)
        assert homes, f"{page}: {file}"
        defined = rf"^(?:def|class) {name}\b|^{name}\b.* = "
        assert not name or any(re.search(defined, p.read_text(), re.M) for p in homes), name
    for module in SCRIPT.findall(text):
        assert (ROOT / (module.replace(".", "/") + ".py")).is_file(), f"{page}: {module}"
    for file in FILE.findall(text):
        assert (ROOT / file).is_file(), f"{page}: {file}"
