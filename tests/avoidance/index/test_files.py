from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mgjax.avoidance.index.build import build_index
from mgjax.avoidance.index.files import load_index, save_index
from mgjax.avoidance.index.index import arrays_of
from mgjax.core.errors import FileFormatError
from mgjax.graph import fingerprint as hashes
from mgjax.graph.files import load_graph, save_graph
from mgjax.io.store import load_arrays, save_arrays
from tests.avoidance.index.made import paths_of
from tests.avoidance.made import random_graph


def test_saved_and_loaded(tmp_path: Path) -> None:
    graph = random_graph(1)
    index = build_index(graph, horizon=0.8)
    save_index(tmp_path, index)
    again = load_index(tmp_path, graph)
    arrays, read = arrays_of(index), arrays_of(again)
    assert arrays.keys() == read.keys()
    for name, array in arrays.items():
        assert read[name].dtype == array.dtype
        np.testing.assert_array_equal(read[name], array)
    for name in ("horizon", "half_frames", "scale", "fingerprint", "report"):
        assert getattr(again, name) == getattr(index, name)
    assert again.nbytes == index.nbytes > 0


def test_what_is_not_looked_up_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    graph = random_graph(1)
    save_graph(tmp_path, graph)
    save_index(tmp_path, build_index(graph, horizon=0.8))
    graph = load_graph(tmp_path)
    monkeypatch.setattr(hashes, "_hash", None)  # the graph's file names its fingerprint
    index = load_index(tmp_path, graph)
    for array in arrays_of(index).values():  # views of the file, not copies of it
        assert not array.size or not array.flags.owndata
        assert not array.flags.writeable
    node = int(np.argmax([len(paths_of(index, n)) for n in range(graph.num_nodes)]))
    paths = paths_of(index, node)
    assert "rasters" not in vars(index.parts)  # nor does it take any to know what is in time
    index.cells(paths[np.arange(1)])
    some = set(index.walks(paths[np.arange(1)]).part.tolist())
    assert len(some) < len(graph.label_edge)
    assert set(np.flatnonzero(index.parts.rasters.known).tolist()) == some


def test_a_damaged_raster_is_said(tmp_path: Path) -> None:
    graph = random_graph(1)
    save_index(tmp_path, build_index(graph, horizon=0.8))
    file = tmp_path / "grid_index.safetensors"
    arrays, metadata = load_arrays(file, "grid index")
    arrays["parts.packed"][:] = 0
    save_arrays(file, arrays, metadata)
    index = load_index(tmp_path, graph)
    node = next(n for n in range(graph.num_nodes) if len(paths_of(index, n)))
    with pytest.raises(FileFormatError, match=r"damaged raster of part .* build it anew$"):
        index.cells(paths_of(index, node))


def test_a_stale_or_damaged_index_is_refused(tmp_path: Path) -> None:
    graph = random_graph(1)
    with pytest.raises(FileFormatError, match="no such file"):
        load_index(tmp_path, graph)
    save_index(tmp_path, build_index(graph, horizon=0.8))
    moved = replace(graph, root_translation=graph.root_translation + np.float32(0.01))
    named = replace(graph, label_starts=graph.label_starts + 0, label_stops=graph.label_stops + 1)
    for other in (random_graph(2), moved, named):
        with pytest.raises(FileFormatError, match=r"another graph, expected .* build it anew$"):
            load_index(tmp_path, other)
    file = tmp_path / "grid_index.safetensors"
    arrays, metadata = load_arrays(file, "grid index")
    worse = {
        "then": {"arrivals.then": arrays["arrivals.then"] + np.uint32(900)},
        "jump": {"arrivals.jump": arrays["arrivals.jump"] + np.uint8(100)},
        "short": {"jumps.time": arrays["jumps.time"][:-1]},
        "first": {"jumps.first": arrays["jumps.first"][::-1].copy()},
        "edge": {"jumps.edges": arrays["jumps.edges"] + np.uint8(100)},
        "end": {"arrivals.end": arrays["arrivals.end"] + np.uint8(100)},
        "length": {"jumps.length": arrays["jumps.length"] + np.uint8(1)},
        "inner": {"parts.inner_first": arrays["parts.inner_first"] + np.uint32(90000)},
    }
    for change in worse.values():
        save_arrays(file, arrays | change, metadata)
        with pytest.raises(FileFormatError, match="do not fit"):
            load_index(tmp_path, graph)
    save_arrays(file, {k: v for k, v in arrays.items() if k != "parts.centres"}, metadata)
    with pytest.raises(FileFormatError, match="incomplete"):
        load_index(tmp_path, graph)
    for version in (1, 2, 99):
        save_arrays(file, arrays, metadata | {"format_version": version})
        with pytest.raises(FileFormatError, match=f"got format {version}, .* 3; build anew$"):
            load_index(tmp_path, graph)
    for scale in (0, "1", None):
        save_arrays(file, arrays, metadata | {"scale": scale})
        with pytest.raises(FileFormatError, match="scale"):
            load_index(tmp_path, graph)
    file.write_bytes(file.read_bytes()[:100])
    with pytest.raises(FileFormatError, match="damaged"):
        load_index(tmp_path, graph)
