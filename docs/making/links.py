"""Where a file of the repository is in the site, and links rewritten to it."""

from __future__ import annotations

import posixpath
import re

PICTURES = "experiments/pictures"
ROOT_PAGES = ("CHANGELOG.md", "CONTRIBUTING.md", "RESULTS.md")
"""Pages of the site that lie beside ``docs``; those that are there."""

_LINK = re.compile(r"(\]\()([^)\s#]+)")
_CODE = re.compile(r"(```.*?```|`[^`\n]+`)", re.DOTALL)


def site_path(path: str) -> str | None:
    """The place in the site of a file of the repository; None where it has none."""
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    if path.startswith(f"{PICTURES}/"):
        return "pictures/" + posixpath.basename(path)
    return path if path in ROOT_PAGES else "index.md" if path == "README.md" else None


def rewritten(text: str, page: str) -> str:
    """Markdown whose links, as they are in the repository, lead to places of the site.

    Args:
        text: of the page.
        page: its file, from the root of the repository, such as ``docs/howto/label.md``.
    """
    here = posixpath.dirname(site_path(page) or page)

    def moved(match: re.Match[str]) -> str:
        target = match[2]
        if "://" in target:
            return match[0]
        place = site_path(posixpath.normpath(posixpath.join(posixpath.dirname(page), target)))
        return match[0] if place is None else match[1] + posixpath.relpath(place, here or ".")

    parts = _CODE.split(text)  # code stays as it is
    return "".join(p if i % 2 else _LINK.sub(moved, p) for i, p in enumerate(parts))
