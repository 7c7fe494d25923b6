"""The grid index in the folder of its graph: written, and read where it still belongs to it."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np

from mgjax.avoidance.index.cells import HEIGHTS
from mgjax.avoidance.index.index import GridIndex, arrays_of
from mgjax.avoidance.index.part_volumes import PartVolumes
from mgjax.avoidance.index.walk_table import Arrivals, WalkTable
from mgjax.core.errors import FileFormatError
from mgjax.graph.fingerprint import fingerprint
from mgjax.graph.types import MotionGraph
from mgjax.io.store import map_arrays, save_arrays

FORMAT_VERSION = 3
FILE_NAME = "grid_index.safetensors"

_PLAIN = ("horizon", "half_frames", "scale", "fingerprint", "report")
"""Fields of an index that are no arrays."""
_RECORDS = {"arrivals": Arrivals, "jumps": WalkTable, "parts": PartVolumes}


def save_index(path: str | Path, index: GridIndex) -> None:
    """Writes the index into the folder of its graph."""
    metadata = {name: getattr(index, name) for name in _PLAIN}
    metadata["format_version"] = FORMAT_VERSION
    save_arrays(Path(path) / FILE_NAME, arrays_of(index), metadata)


def load_index(path: str | Path, graph: MotionGraph) -> GridIndex:
    """Reads the index of a graph from its folder: of the file only what is looked up later on.

    Raises:
        FileFormatError: there is none, it is damaged, of another format, or of another graph.
    """
    file = Path(path) / FILE_NAME
    arrays, metadata = map_arrays(file, "grid index")
    version = metadata.get("format_version")
    if version != FORMAT_VERSION:
        raise FileFormatError(
            file, None, f"format {version}", f"format {FORMAT_VERSION}; build anew"
        )
    if metadata.get("fingerprint") != fingerprint(graph):
        raise FileFormatError(
            file, None, "the index of another graph", "this graph's; build it anew"
        )
    names = {f"{record}.{f.name}" for record, of in _RECORDS.items() for f in fields(of)}
    if set(arrays) != names | {"complete", "nearest"} or not set(_PLAIN) <= set(metadata):
        raise FileFormatError(file, None, "an incomplete index", "a whole one; build it anew")
    scale = metadata["scale"]
    if not isinstance(scale, float) or not 1e-6 < scale < 1e6:
        raise FileFormatError(file, None, f"the scale {scale!r:.20}", "a number; build it anew")
    if not _is_sound(arrays, graph):
        raise FileFormatError(file, None, "arrays that do not fit", "a whole index; build it anew")
    return GridIndex(
        **{name: metadata[name] for name in _PLAIN},
        complete=arrays["complete"],
        nearest=arrays["nearest"],
        **{
            record: of(**{f.name: arrays[f"{record}.{f.name}"] for f in fields(of)})
            for record, of in _RECORDS.items()
        },
    )


def _is_sound(arrays: dict[str, np.ndarray], graph: MotionGraph) -> bool:
    """Whether all arrays of an index fit one another and point at something.

    Places, rasters and spheres are not read: whatever stands there is a number.
    """
    nodes, parts = graph.num_nodes, len(graph.label_edge)
    shapes: dict[str, tuple[int, ...]] = {"complete": (nodes,), "nearest": (nodes,)}
    firsts: dict[str, int] = {}
    for record in ("arrivals", "jumps"):
        walks, edges = arrays[f"{record}.end"].size, arrays[f"{record}.edges"].size
        shapes |= {f"{record}.{name}": (walks,) for name in ("end", "time", "length", "rank")}
        shapes |= {f"{record}.first": (nodes + 1,), f"{record}.edges": (edges,)}
        shapes[f"{record}.place"] = (walks, 3)
        firsts[f"{record}.first"] = walks
    shapes |= {f"arrivals.{name}": (arrays["arrivals.end"].size,) for name in ("jump", "then")}
    moments, spheres = len(arrays["parts.centres"]), arrays["parts.radii"].size
    shapes |= {f"parts.{name}": (parts,) for name in ("rows", "columns")}
    shapes |= {f"parts.{name}": (parts + 1,) for name in ("moment_first", "packed_first")}
    shapes |= {"parts.radii": (spheres,), "parts.centres": (moments, 3, spheres)}
    points = arrays["parts.inner_bit"].size
    shapes |= {"parts.corner": (parts, 2), "parts.inner_first": (parts, HEIGHTS + 1)}
    shapes |= {"parts.inner": (points, 3), "parts.inner_bit": (points,)}
    shapes |= {"parts.packed": (arrays["parts.packed"].size,)}
    firsts |= {"parts.moment_first": moments, "parts.packed_first": arrays["parts.packed"].size}
    return (
        all(arrays[name].shape == shape for name, shape in shapes.items())
        and all(_counts_up_to(arrays[name], last) for name, last in firsts.items())
        and _points_at(arrays["arrivals.end"], parts)
        and _points_at(arrays["parts.inner_first"], points + 1)
        and _points_at(arrays["jumps.end"], nodes)
        and all(_points_at(arrays[f"{r}.edges"], graph.num_edges) for r in ("arrivals", "jumps"))
        and all(_has_edges(arrays, record) for record in ("arrivals", "jumps"))
        and bool((arrays["jumps.rank"] > 0).all())
        and _goes_on(arrays)
    )


def _has_edges(arrays: dict[str, np.ndarray], record: str) -> bool:
    """Whether the walks that have a rank have as many edges as they say."""
    length = arrays[f"{record}.length"]
    own = length[arrays[f"{record}.rank"] > 0]
    return bool(own.sum(dtype=np.int64) == arrays[f"{record}.edges"].size and (length > 0).all())


def _goes_on(arrays: dict[str, np.ndarray]) -> bool:
    """Whether arrivals without a rank go on by a jump of their node to a shorter one."""
    jumps, first = (arrays[f"{r}.first"].astype(np.int64) for r in ("jumps", "arrivals"))
    rest = np.flatnonzero(arrays["arrivals.rank"] == 0)
    node = np.repeat(np.arange(len(first) - 1), np.diff(first))[rest]
    jump = jumps[node] + arrays["arrivals.jump"][rest]
    if not (jump < jumps[node + 1]).all():
        return False
    target = arrays["jumps.end"][jump].astype(np.int64)
    then, length = first[target] + arrays["arrivals.then"][rest], arrays["arrivals.length"]
    return bool((then < first[target + 1]).all() and (length[then] < length[rest]).all())


def _counts_up_to(first: np.ndarray, last: int) -> bool:
    """Whether rows begin one after another, from 0 to ``last``."""
    return bool(first[0] == 0 and first[-1] == last and (first[1:] >= first[:-1]).all())


def _points_at(numbers: np.ndarray, count: int) -> bool:
    return not numbers.size or int(numbers.max()) < count
