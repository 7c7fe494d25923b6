"""Graphs on disk: a folder with ``graph.safetensors`` and, beside it, later their indices."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from mgjax.core.errors import FileFormatError, OutputError
from mgjax.core.skeleton import Skeleton, validate_skeleton
from mgjax.graph.types import MotionGraph
from mgjax.io.store import load_arrays, save_arrays

FORMAT_VERSION = 1
FILE_NAME = "graph.safetensors"
_PLAIN = ("frame_rate", "window", "clip_names", "label_kind", "label_direction", "report")


def save_graph(path: str | Path, graph: MotionGraph) -> None:
    """Writes a graph into the folder ``path``, which is made if it is not there."""
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{path}: got {error.strerror}, expected a writable folder") from None
    arrays = {"skeleton_offsets": np.asarray(graph.skeleton.offsets)}
    for field in dataclasses.fields(graph):
        if field.name not in (*_PLAIN, "skeleton"):
            arrays[field.name] = getattr(graph, field.name)
    metadata = {name: getattr(graph, name) for name in _PLAIN}
    metadata["format_version"] = FORMAT_VERSION
    metadata["skeleton"] = {
        "names": graph.skeleton.names,
        "parents": graph.skeleton.parents,
        "end_joints": graph.skeleton.end_joints,
    }
    save_arrays(Path(path) / FILE_NAME, arrays, metadata)


def load_graph(path: str | Path) -> MotionGraph:
    """Reads a graph from its folder.

    Raises:
        FileFormatError: there is none, it is damaged, or of another format version.
    """
    file = Path(path) / FILE_NAME
    arrays, metadata = load_arrays(file, "motion graph")
    version = metadata.get("format_version")
    if version != FORMAT_VERSION:
        raise FileFormatError(
            file, None, f"format {version}", f"format {FORMAT_VERSION}; build anew"
        )
    try:
        tree = metadata["skeleton"]
        skeleton = Skeleton(
            names=tuple(tree["names"]),
            parents=tuple(tree["parents"]),
            offsets=arrays.pop("skeleton_offsets"),
            end_joints=tuple(tree["end_joints"]),
        )
        plain = {name: metadata[name] for name in _PLAIN}
        for name in ("clip_names", "label_kind", "label_direction"):
            plain[name] = tuple(plain[name])
        graph = MotionGraph(skeleton=skeleton, **arrays, **plain)
    except (KeyError, TypeError) as error:
        raise FileFormatError(file, None, f"a graph without {error}", "a whole graph") from None
    validate_skeleton(skeleton)
    return graph
