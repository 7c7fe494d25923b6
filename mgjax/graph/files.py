"""Graphs on disk: a folder with ``graph.safetensors`` and, beside it, later their indices."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from mgjax.core.errors import FileFormatError, OutputError, printable
from mgjax.core.skeleton import Skeleton, validate_skeleton
from mgjax.graph.fingerprint import fingerprint, remember_fingerprint
from mgjax.graph.types import MotionGraph
from mgjax.io.store import load_arrays, save_arrays
from mgjax.io.text import reason
from mgjax.io.user_path import user_path

FORMAT_VERSION = 1
FILE_NAME = "graph.safetensors"
_SHAPES = {
    "root_translation": "F 3",
    "local_rotations": "F J 4",
    "skeleton_offsets": "J 3",
    **dict.fromkeys(("clip_starts", "clip_stops"), "K"),
    **dict.fromkeys(("node_frame", "node_clip"), "N"),
    "node_plane": "N 3",
    **dict.fromkeys(("edge_source", "edge_target", "edge_starts", "edge_stops", "edge_clip"), "E"),
    "edge_exit": "E 3",
    "edge_distance": "E",
    "out_edges": "E",
    "out_first": "N1",
    **dict.fromkeys(("label_edge", "label_starts", "label_stops", "label_genuine"), "P"),
}
_RANGES = {
    **dict.fromkeys(("clip_starts", "node_frame", "edge_starts", "edge_stops"), "F"),
    **dict.fromkeys(("node_clip", "edge_clip"), "K"),
    **dict.fromkeys(("edge_source", "edge_target"), "N"),
    **dict.fromkeys(("out_edges", "label_edge"), "E"),
    "label_starts": "F",
}
"""Arrays of indices, and of what; ``edge_clip`` may be ``NO_CLIP``."""
_PLAIN = ("frame_rate", "window", "clip_names", "label_kind", "label_direction", "report")


def save_graph(path: str | Path, graph: MotionGraph) -> None:
    """Writes a graph into the folder ``path``, which is made if it is not there."""
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:  # ValueError: a null byte
        raise OutputError(
            f"{printable(path)}: cannot be written ({reason(error)}), expected a writable folder"
        ) from None
    arrays = {"skeleton_offsets": np.asarray(graph.skeleton.offsets)}
    for field in dataclasses.fields(graph):
        if field.name not in (*_PLAIN, "skeleton"):
            arrays[field.name] = getattr(graph, field.name)
    metadata = {name: getattr(graph, name) for name in _PLAIN}
    metadata["format_version"] = FORMAT_VERSION
    metadata["fingerprint"] = fingerprint(graph)
    metadata["skeleton"] = {
        "names": graph.skeleton.names,
        "parents": graph.skeleton.parents,
        "end_joints": graph.skeleton.end_joints,
        "roles": graph.skeleton.roles,
    }
    save_arrays(Path(path) / FILE_NAME, arrays, metadata)


def load_graph(path: str | Path) -> MotionGraph:
    """Reads a graph from its folder.

    Raises:
        FileFormatError: there is none, it is damaged, or of another format version.
    """
    file = user_path(path) / FILE_NAME
    arrays, metadata = load_arrays(file, "motion graph")
    version = metadata.get("format_version")
    if version != FORMAT_VERSION:
        raise FileFormatError(
            file, None, f"format {version}", f"format {FORMAT_VERSION}; build anew"
        )
    try:
        tree = metadata["skeleton"]
        _check(arrays, len(tree["names"]), file)
        skeleton = Skeleton(
            names=tuple(tree["names"]),
            parents=tuple(tree["parents"]),
            offsets=arrays.pop("skeleton_offsets"),
            end_joints=tuple(tree["end_joints"]),
            roles=tuple((role, joint) for role, joint in tree.get("roles", ())),
        )
        validate_skeleton(skeleton)
        plain = {name: metadata[name] for name in _PLAIN}
        for name in ("clip_names", "label_kind", "label_direction"):
            plain[name] = tuple(plain[name])
        graph = MotionGraph(skeleton=skeleton, **arrays, **plain)
    except FileFormatError:
        raise
    except (KeyError, TypeError, ValueError) as error:
        first = (str(error).splitlines() or [""])[0]
        raise FileFormatError(
            file, None, f"an incomplete graph ({type(error).__name__}: {first:.80})", "a whole one"
        ) from None
    if isinstance(
        metadata.get("fingerprint"), str
    ):  # written since graphs have indices in format 3
        remember_fingerprint(graph, metadata["fingerprint"])
    return graph


def _check(arrays: dict[str, np.ndarray], joints: int, file: Path) -> None:
    """Raises unless all arrays are there, fit one another and point at something."""
    sizes = {"J": joints, "3": 3, "4": 4}
    for name, dims in _SHAPES.items():
        if name not in arrays:
            raise FileFormatError(file, None, f"no array {name!r}", "a whole graph")
        shape = arrays[name].shape
        if dims == "N1":
            sizes["N1"] = sizes["N"] + 1
        want = tuple(sizes.setdefault(d, n) for d, n in zip(dims.split(), shape, strict=False))
        if shape != want or len(shape) != len(dims.split()):
            raise FileFormatError(file, None, f"{name!r} of shape {shape}", f"{want or dims}")
    for name, of in _RANGES.items():
        values, least = arrays[name], -1 if name == "edge_clip" else 0
        if values.size and not (values.min() >= least and values.max() < sizes[of]):
            got = f"{name!r} with values {values.min()} … {values.max()}"
            raise FileFormatError(file, None, got, f"{least} … {sizes[of] - 1}")
    firsts = arrays["out_first"]
    if firsts[0] != 0 or firsts[-1] != sizes["E"] or (np.diff(firsts) < 0).any():
        raise FileFormatError(file, None, "'out_first' out of order", "a whole graph")
