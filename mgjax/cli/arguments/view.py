"""Arguments of ``mgjax view``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import tyro

from mgjax.cli.arguments.shared import Output


@dataclass(frozen=True, kw_only=True)
class View(Output):
    """Open a page in the browser: throw balls, sketch walks, play, edit clips, or see a result.

    The page reads and writes the folders given here, and nothing else.
    """

    what: tyro.conf.Positional[str] = "throw"
    """throw, sketch, match or edit; or the folder or motion file of a result."""
    graph: Path | None = None
    """Folder of a graph; default: one of the embedded clips."""
    clips: Path | None = None
    """Folder of clips."""
    labels: Path | None = None
    """JSON file of labelled intervals; default: labels.json in the folder of clips."""
    port: int = 8765
    """Port to listen on; 0 takes a free one."""
    host: str = "127.0.0.1"
    """Address to listen on; anything but this machine's own lets others use the page."""
    no_browser: bool = False
    """Do not open the page, only print its address."""
    save: Path | None = None
    """Write a result to a file and do not serve it: .html, .png or .mp4."""
