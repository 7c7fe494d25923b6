"""Hooks of mkdocs (``mkdocs.yml``): what the site has beyond the files of ``docs``."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "docs")]

from making.links import PICTURES, ROOT_PAGES, rewritten, site_path  # noqa: E402
from making.players import make  # noqa: E402
from making.reference import ROOMS, page, plain_roles  # noqa: E402

PLAYERS = ROOT / "out" / "players"
_FRAME = re.compile(r'<iframe class="player" src="([^"]+)"')


def on_config(config: Any) -> Any:
    """Pages that the navigation does not name come last in their part of it."""
    groups = {title: part for item in config.nav for title, part in item.items()}
    named = str(config.nav)
    pages = {"Topics": [path.name for path in sorted((ROOT / "docs").glob("*.md"))]}
    pages["Project"] = [name for name in ROOT_PAGES if (ROOT / name).is_file()]
    for title, names in pages.items():
        groups[title] += [name for name in names if f"'{name}'" not in named]
    return config


def on_files(files: Files, config: Any) -> Files:
    """Adds pictures, players, pages of the root and of the reference."""
    make(PLAYERS)
    for path in sorted((ROOT / PICTURES).iterdir()):
        if path.suffix in (".png", ".gif"):
            files.append(File.generated(config, f"pictures/{path.name}", abs_src_path=str(path)))
    for path in sorted(PLAYERS.glob("*.html")):
        files.append(File.generated(config, f"players/{path.name}", abs_src_path=str(path)))
    for name in ROOT_PAGES:
        if (ROOT / name).is_file():
            files.append(File.generated(config, name, abs_src_path=str(ROOT / name)))
    for room in ROOMS:
        files.append(File.generated(config, f"reference/{room}.md", content=page(room)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Links of the repository become links of the site."""
    name = page.file.src_uri
    return rewritten(markdown, name if name in ROOT_PAGES else f"docs/{name}")


def on_page_content(html: str, page: Any, files: Files, **_: Any) -> str:
    """Docstrings without roles; and every player that a page shows is there."""
    for target in _FRAME.findall(html):
        source = (Path("docs") / page.file.src_uri).parent / target
        place = site_path(source.as_posix().replace("tutorials/../", ""))
        if place is None or files.get_file_from_path(place) is None:
            raise PluginError(f"{page.file.src_uri}: there is no player {target}")
    return plain_roles(html)
