from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from safetensors import safe_open
from safetensors.numpy import save_file

from mgjax.core.errors import FileFormatError, OutputError
from mgjax.graph.files import FILE_NAME, load_graph, save_graph
from mgjax.graph.types import MotionGraph


@pytest.fixture(scope="module")
def saved(made_graph, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("graph")
    save_graph(folder, made_graph)
    return folder


def rewritten(saved: Path, folder: Path, change) -> Path:
    """A copy whose (arrays, metadata) went through ``change``; metadata are decoded JSON."""
    with safe_open(str(saved / FILE_NAME), framework="numpy") as file:
        metadata = {k: json.loads(v) for k, v in file.metadata().items()}
        arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    change(arrays, metadata)
    save_file(arrays, folder / FILE_NAME, {k: json.dumps(v) for k, v in metadata.items()})
    return folder


def one_line(folder: Path) -> str:
    with pytest.raises(FileFormatError) as caught:
        load_graph(folder)
    text = str(caught.value)
    assert "\n" not in text
    assert FILE_NAME in text
    assert " got " in text
    assert ", expected " in text
    assert len(text) < 400
    return text


def assert_equal(a: MotionGraph, b: MotionGraph) -> None:
    for field in dataclasses.fields(MotionGraph):
        one, two = getattr(a, field.name), getattr(b, field.name)
        if isinstance(one, np.ndarray):
            assert one.dtype == two.dtype
            np.testing.assert_array_equal(one, two)
        elif field.name == "skeleton":
            assert (one.names, one.parents, one.end_joints) == (
                two.names,
                two.parents,
                two.end_joints,
            )
            np.testing.assert_array_equal(one.offsets, two.offsets)
        else:
            assert one == two
            assert type(one) is type(two)


def test_round_trip(saved, made_graph):
    assert_equal(load_graph(saved), made_graph)
    assert [p.name for p in saved.iterdir()] == [FILE_NAME]


def test_round_trip_of_real_capture(real_graph, tmp_path):
    save_graph(tmp_path / "a" / "b", real_graph)
    assert_equal(load_graph(tmp_path / "a" / "b"), real_graph)


def test_missing(tmp_path):
    assert "no such file" in one_line(tmp_path)
    assert "no such file" in one_line(tmp_path / "nowhere")


@pytest.mark.parametrize(
    "data", [b"", b"\0" * 100, b"HIERARCHY\nROOT x\n", b"{}", bytes(range(256))]
)
def test_something_else(data, tmp_path):
    (tmp_path / FILE_NAME).write_bytes(data)
    assert "damaged" in one_line(tmp_path)


@pytest.mark.parametrize("share", [0.001, 0.1, 0.5, 0.999])
def test_truncated(saved, tmp_path, share):
    data = (saved / FILE_NAME).read_bytes()
    (tmp_path / FILE_NAME).write_bytes(data[: int(share * len(data))])
    assert "damaged" in one_line(tmp_path)


def test_another_version(saved, tmp_path):
    folder = rewritten(saved, tmp_path, lambda a, m: m.update(format_version=99))
    assert "got format 99, expected format 1; build anew" in one_line(folder)
    folder = rewritten(saved, tmp_path, lambda a, m: m.pop("format_version"))
    assert "got format None" in one_line(folder)


def test_metadata_that_are_no_json(saved, tmp_path):
    with safe_open(str(saved / FILE_NAME), framework="numpy") as file:
        metadata = dict(file.metadata())
        arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    save_file(arrays, tmp_path / FILE_NAME, {**metadata, "report": "{"})
    one_line(tmp_path)


def put(name: str, index: int, value: int):
    def change(arrays, metadata):
        arrays[name] = arrays[name].copy()
        arrays[name][index] = value

    return change


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (lambda a, m: a.pop("edge_exit"), "edge_exit"),
        (lambda a, m: m.pop("window"), "window"),
        (lambda a, m: m.pop("skeleton"), "skeleton"),
        (lambda a, m: a.update(extra=np.zeros(3)), "extra"),
        (lambda a, m: a.update(edge_stops=a["edge_stops"][:-1]), "edge_stops"),
        (lambda a, m: a.update(node_plane=a["node_plane"][:, :2].copy()), "node_plane"),
        (lambda a, m: a.update(label_edge=a["label_edge"][None].copy()), "label_edge"),
        (lambda a, m: a.update(local_rotations=a["local_rotations"][:, 1:].copy()), "rotations"),
        (lambda a, m: m["skeleton"].update(names=m["skeleton"]["names"][:-1]), ""),
        (lambda a, m: m["skeleton"].update(names=["x"] * 15), "'x'"),
        (lambda a, m: m["skeleton"].update(parents=[3, *m["skeleton"]["parents"][1:]]), "root"),
        (lambda a, m: m["skeleton"].update(end_joints=None), ""),
        (lambda a, m: m.update(clip_names=7), ""),
        (put("edge_target", 3, 10**6), "edge_target"),
        (put("edge_source", 0, -1), "edge_source"),
        (put("edge_stops", -1, 10**9), "edge_stops"),
        (put("out_edges", 0, -5), "out_edges"),
        (put("out_first", 1, 10**6), "out_first"),
        (put("label_edge", 0, 10**6), "label_edge"),
        (put("node_clip", 0, 99), "node_clip"),
        (put("edge_clip", 0, -2), "edge_clip"),
    ],
)
def test_parts_that_do_not_fit(saved, tmp_path, change, part):
    assert part in one_line(rewritten(saved, tmp_path, change))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_changed_bytes(saved, tmp_path, data):
    """Either it is noticed, as a documented error, or the graph holds together."""
    raw = bytearray((saved / FILE_NAME).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        # The header is a small part of the file but most of what can go wrong.
        place = data.draw(st.integers(0, 4000) | st.integers(0, len(raw) - 1))
        raw[place] = data.draw(st.integers(0, 255))
    (tmp_path / FILE_NAME).write_bytes(raw)
    try:
        graph = load_graph(tmp_path)
    except FileFormatError as error:
        text = str(error)
    else:
        text = ""
        assert graph.edge_target.max() < graph.num_nodes
    assert "\n" not in text


def test_a_place_that_cannot_be_written(made_graph, tmp_path):
    (tmp_path / "file").write_text("here")
    for path in (tmp_path / "file", tmp_path / "file" / "below", tmp_path / "a\0b"):
        with pytest.raises(OutputError) as caught:
            save_graph(path, made_graph)
        assert "\n" not in str(caught.value)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_nothing_half_written(made_graph, saved, tmp_path, monkeypatch):
    save_graph(tmp_path, made_graph)
    whole = (tmp_path / FILE_NAME).read_bytes()

    def full(self, data):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OutputError, match="space"):
        save_graph(tmp_path, made_graph)
    assert (tmp_path / FILE_NAME).read_bytes() == whole
    assert [p.name for p in tmp_path.iterdir()] == [FILE_NAME]
