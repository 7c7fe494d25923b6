"""The graph of the embedded clips, kept in the cache folder: pages that show it open sooner."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path

from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.errors import FileFormatError, OutputError
from mgjax.core.xla.compilation import cache_folder
from mgjax.graph.build import build_graph
from mgjax.graph.config import EMBEDDED
from mgjax.graph.files import load_graph, save_graph
from mgjax.graph.stages.stages import made_by
from mgjax.graph.types import MotionGraph
from mgjax.io.content_key import content_key

NAME = "embedded"


def embedded_graph() -> MotionGraph:
    """The graph of the embedded clips: from the cache folder, where the same programs have kept it
    there, else built, and kept for the next time.

    A file that is damaged is made anew. Where nothing can be written the graph is not kept, and a
    warning says so.
    """
    folder = _folder()
    try:
        return load_graph(folder)
    except FileFormatError:  # none yet, or damaged
        clips, labels = synthetic_clips()
        graph = build_graph(clips, labels=labels, config=EMBEDDED)
    for older in folder.parent.glob(f"{NAME}-*"):
        shutil.rmtree(older, ignore_errors=True)
    try:
        save_graph(folder, graph)
    except OutputError as error:
        warnings.warn(f"the embedded graph is not kept: {error}", stacklevel=2)
    return graph


def _folder() -> Path:
    return cache_folder() / "graphs" / f"{NAME}-{content_key([made_by(), repr(EMBEDDED)])}"
