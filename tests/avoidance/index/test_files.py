from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from mgjax.avoidance.index.build import build_index
from mgjax.avoidance.index.files import load_index, save_index
from mgjax.core.errors import FileFormatError
from mgjax.io.store import load_arrays, save_arrays
from tests.avoidance.made import random_graph


def test_saved_and_loaded(tmp_path: Path) -> None:
    graph = random_graph(1)
    index = build_index(graph, horizon=0.8)
    save_index(tmp_path, index)
    again = load_index(tmp_path, graph)
    for field in fields(index):
        a, b = getattr(index, field.name), getattr(again, field.name)
        if isinstance(a, np.ndarray):
            assert a.dtype == b.dtype
            np.testing.assert_array_equal(a, b)
        else:
            assert a == b
    assert again.nbytes == index.nbytes > 0


def test_of_format_1_every_cell_has_10_cm(tmp_path: Path) -> None:
    graph = random_graph(1)
    index = build_index(graph, horizon=0.8)
    save_index(tmp_path, index)
    file = tmp_path / "grid_index.safetensors"
    arrays, metadata = load_arrays(file, "grid index")
    assert index.scale == metadata.pop("scale") == graph.body_scale != 1
    save_arrays(file, arrays, metadata | {"format_version": 1})
    again = load_index(tmp_path, graph)
    assert again.scale == 1
    np.testing.assert_array_equal(again.code, index.code)
    for scale in (0, "1", None):
        save_arrays(file, arrays, metadata | {"scale": scale})
        with pytest.raises(FileFormatError, match="scale"):
            load_index(tmp_path, graph)


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
        "follow": {"follow": arrays["follow"] + np.uint32(9)},
        "short": {"code": arrays["code"][:-1]},
        "first": {"node_first": arrays["node_first"][::-1].copy()},
        "edge": {"edge": arrays["edge"] + np.uint8(100)},
    }
    for change in worse.values():
        save_arrays(file, arrays | change, metadata)
        with pytest.raises(FileFormatError, match="do not fit"):
            load_index(tmp_path, graph)
    save_arrays(file, {k: v for k, v in arrays.items() if k != "masks"}, metadata)
    with pytest.raises(FileFormatError, match="incomplete"):
        load_index(tmp_path, graph)
    save_arrays(file, arrays, metadata | {"format_version": 99})
    with pytest.raises(FileFormatError, match="format 99"):
        load_index(tmp_path, graph)
    file.write_bytes(file.read_bytes()[:100])
    with pytest.raises(FileFormatError, match="damaged"):
        load_index(tmp_path, graph)
