"""The files of the page, read once: what a request names is looked up, never opened."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
}


def page_files() -> dict[str, tuple[str, bytes]]:
    """Type and content of each file of the page, by the path of its address."""
    found: dict[str, tuple[str, bytes]] = {}
    _collect(files("mgjax.stage") / "page", "/", found)
    found["/"] = found["/index.html"]
    return found


def _collect(folder: Traversable, path: str, found: dict[str, tuple[str, bytes]]) -> None:
    for item in folder.iterdir():
        if item.is_dir():
            _collect(item, f"{path}{item.name}/", found)
            continue
        suffix = "." + item.name.rpartition(".")[2]
        if suffix in TYPES:
            found[path + item.name] = (TYPES[suffix], item.read_bytes())
