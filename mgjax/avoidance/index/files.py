"""The grid index in the folder of its graph: written, and read where it still belongs to it."""

from __future__ import annotations

import hashlib
from dataclasses import fields
from pathlib import Path

import numpy as np

from mgjax.avoidance.index.index import GridIndex
from mgjax.core.errors import FileFormatError
from mgjax.graph.types import MotionGraph
from mgjax.io.store import load_arrays, save_arrays

FORMAT_VERSION = 2
_READABLE = (1, 2)
"""Format 1 has no ``scale``: its cells are 10 cm for every body."""
FILE_NAME = "grid_index.safetensors"

_PLAIN = ("horizon", "half_frames", "scale", "fingerprint", "report")
"""Fields of an index that are no arrays."""


def fingerprint(graph: MotionGraph) -> str:
    """A hash of everything of a graph that its index depends on."""
    digest = hashlib.blake2b(digest_size=16)
    digest.update(repr((graph.frame_rate, graph.skeleton.names, graph.skeleton.parents)).encode())
    digest.update(np.asarray(graph.skeleton.offsets).tobytes())
    for field in fields(graph):
        value = getattr(graph, field.name)
        if isinstance(value, np.ndarray):
            digest.update(f"{field.name} {value.dtype} {value.shape}".encode())
            digest.update(np.ascontiguousarray(value).tobytes())
    return digest.hexdigest()


def save_index(path: str | Path, index: GridIndex) -> None:
    """Writes the index into the folder of its graph."""
    arrays = {f.name: getattr(index, f.name) for f in fields(index) if f.name not in _PLAIN}
    metadata = {name: getattr(index, name) for name in _PLAIN}
    metadata["format_version"] = FORMAT_VERSION
    save_arrays(Path(path) / FILE_NAME, arrays, metadata)


def load_index(path: str | Path, graph: MotionGraph) -> GridIndex:
    """Reads the index of a graph from its folder.

    Raises:
        FileFormatError: there is none, it is damaged, or it belongs to another graph.
    """
    file = Path(path) / FILE_NAME
    arrays, metadata = load_arrays(file, "grid index")
    version = metadata.get("format_version")
    if version not in _READABLE:
        raise FileFormatError(
            file, None, f"format {version}", f"format {FORMAT_VERSION}; build anew"
        )
    if metadata.get("fingerprint") != fingerprint(graph):
        raise FileFormatError(
            file, None, "the index of another graph", "this graph's; build it anew"
        )
    if version == 1:
        metadata["scale"] = 1.0
    names = {f.name for f in fields(GridIndex)} - set(_PLAIN)
    if set(arrays) != names or not set(_PLAIN) <= set(metadata):
        raise FileFormatError(file, None, "an incomplete index", "a whole one; build it anew")
    scale = metadata["scale"]
    if not isinstance(scale, float) or not 1e-6 < scale < 1e6:
        raise FileFormatError(file, None, f"the scale {scale!r:.20}", "a number; build it anew")
    if not _is_sound(arrays, graph):
        raise FileFormatError(file, None, "arrays that do not fit", "a whole index; build it anew")
    return GridIndex(**arrays, **{name: metadata[name] for name in _PLAIN})


def _is_sound(arrays: dict[str, np.ndarray], graph: MotionGraph) -> bool:
    """Whether all arrays of an index fit one another and point at something."""
    paths, columns = arrays["edge"].size, arrays["code"].size
    sizes = dict.fromkeys(set(arrays), paths) | {"follow": paths + 1, "column": columns}
    sizes |= {"code": columns, "node_first": graph.num_nodes + 1, "node_limit": graph.num_nodes}
    sizes["masks"] = arrays["masks"].size
    if any(array.shape != (sizes[name],) for name, array in arrays.items()):
        return False
    first = arrays["node_first"]
    below = (
        (arrays["edge"], graph.num_edges),
        (arrays["part"], len(graph.label_edge)),
        (arrays["follow"], paths + 1),
        (arrays["code"], sizes["masks"]),
        (arrays["column_first"] + arrays["column_count"].astype(np.int64), columns + 1),
    )
    ordered = first[0] == 0 and first[-1] == paths and (np.diff(first) >= 0).all()
    in_range = all(not a.size or int(a.max()) < limit for a, limit in below)
    return bool(ordered and in_range and (arrays["width"] > 0).all())
