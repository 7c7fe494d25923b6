"""The pages of the documentation in the order in which they are read, and the code in them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[2]
NOT_RUN = re.compile(r"<!-- not run: (.+) -->")
_FENCE = re.compile(r"^```(\w*)(?: title=\"([^\"]+)\")?$")


@dataclass(frozen=True, kw_only=True)
class Block:
    """Some lines of code in a page.

    Attributes:
        page: from the root of the repository.
        line: of its first line in the page, from 1.
        language: as the page says.
        title: the file that it is, or "".
        not_run: why it cannot run, as the comment above it says, or "".
        text: the code.
    """

    page: str
    line: int
    language: str
    title: str
    not_run: str
    text: str

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def pages() -> list[str]:
    """README.md, the pages of the navigation in its order, and then all others."""
    nav = yaml.safe_load((ROOT / "mkdocs.yml").read_text())["nav"]
    named = [f"docs/{name}" for name in _names(nav) if (ROOT / "docs" / name).is_file()]
    others = sorted(p.relative_to(ROOT).as_posix() for p in (ROOT / "docs").rglob("*.md"))
    return ["README.md", *dict.fromkeys(named + others)]


def _names(nav: Any) -> Iterator[str]:
    if isinstance(nav, str):
        yield nav
    else:
        for item in nav.values() if isinstance(nav, dict) else nav:
            yield from _names(item)


def blocks(page: str) -> list[Block]:
    """The fenced blocks of a page."""
    found: list[Block] = []
    lines = (ROOT / page).read_text().split("\n")
    number = 0
    while number < len(lines):
        fence = _FENCE.match(lines[number])
        number += 1
        if fence is None:
            assert not lines[number - 1].startswith("```"), f"{page}:{number}: {lines[number - 1]}"
            continue
        end = lines.index("```", number)
        reason = NOT_RUN.fullmatch(lines[number - 2])
        found.append(
            Block(
                page=page,
                line=number + 1,
                language=fence[1],
                title=fence[2] or "",
                not_run=reason[1] if reason else "",
                text="\n".join(lines[number:end]) + "\n",
            )
        )
        number = end + 1
    return found


def outside_fences(page: str) -> list[tuple[int, str]]:
    """Numbers and text of the lines of a page that are in no fenced block."""
    inside, found = False, []
    for number, line in enumerate((ROOT / page).read_text().split("\n"), 1):
        if line.startswith("```"):
            inside = not inside
        elif not inside:
            found.append((number, line))
    return found
