"""Files that a page saves: a motion in any format, a show as a page of its own."""

from __future__ import annotations

import tempfile
from pathlib import Path

from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.save import WRITERS, save_motion
from mgjax.stage.html import page_html
from mgjax.stage.serve.film import file_message
from mgjax.stage.serve.session import Message
from mgjax.stage.show.types import Show

FORMATS = ("html", *(suffix.removeprefix(".") for suffix in WRITERS))
"""What a page may ask for."""


def motion_file(name: str, suffix: str, skeleton: Skeleton, motion: Motion) -> Message:
    """A motion as a file of the page.

    Args:
        name: of the file, without its suffix.
        suffix: one of :data:`FORMATS` but ``html``.
        skeleton, motion: what is moved, and how.

    Raises:
        MgjaxError: what is needed to write the format is not installed.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.{suffix}"
        save_motion(path, skeleton, motion)
        return file_message(path.name, "application/octet-stream", path.read_bytes())


def html_file(name: str, show: Show) -> Message:
    """A show as one page that plays offline."""
    return file_message(f"{name}.html", "text/html", page_html(show).encode())
