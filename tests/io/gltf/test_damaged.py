"""GLB files that are almost right: a clear error, or a motion that is sound."""

from __future__ import annotations

import copy
import json
import struct
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mgjax.core.errors import FileFormatError
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import validate_motion
from mgjax.core.skeleton import validate_skeleton
from mgjax.io.load import load_motion
from tests.io.gltf.made import Glb, armature, glb

VALUES: list[Any] = [
    *(None, True, -1, 0, 1, 2, 5, 7, 255, 256, 1e9, 1e30, 1e308, 0.5, -0.0, 1e-30),
    *("", "x", "VEC3", "SCALAR", "LINEAR", "CUBICSPLINE", "rotation", "scale", "weights"),
    *([], {}, [0], [0, 0], [1, 2, 3], [0, 0, 0, 0], [[1]], [{}], {"a": 1}, {"node": 0}),
]


def sound_or_refused(path) -> bool:
    """Whether it loads; then it must be of use."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            skeleton, motion = load_motion(path)
        except FileFormatError as error:
            text = str(error)
            assert len(text.splitlines()) == 1
            assert text.isprintable()
            assert "expected" in text
            assert len(text) < 600
            return False
        validate_skeleton(skeleton)
        validate_motion(skeleton, motion)
        assert np.isfinite(global_positions(skeleton, motion)).all()
        norms = np.linalg.norm(motion.local_rotations, axis=-1)
        np.testing.assert_allclose(norms, 1, atol=1e-5)
    return True


def places(value: Any, at: tuple = ()) -> list[tuple]:
    """Where all values of a document stand."""
    found = [at] if at else []
    if isinstance(value, dict | list):
        items = value.items() if isinstance(value, dict) else enumerate(value)
        for key, inner in items:
            found += places(inner, (*at, key))
    return found


def changed(document: dict, place: tuple, value: Any, *, delete: bool) -> None:
    holder: Any = document
    for key in place[:-1]:
        holder = holder[key]
    if delete and isinstance(holder, dict):
        del holder[place[-1]]
    else:
        holder[place[-1]] = value


@settings(max_examples=300)
@given(st.data())
def test_any_value_may_be_another(tmp_path_factory, data):
    file = armature(1, frames=4)
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.sampled_from(places(file.json)))
        value = copy.deepcopy(data.draw(st.sampled_from(VALUES)))
        changed(file.json, place, value, delete=data.draw(st.booleans()))
    path = tmp_path_factory.mktemp("damaged") / "x.glb"
    path.write_bytes(glb(json.dumps(file.json), bytes(file.data)))
    sound_or_refused(path)


@settings(max_examples=200)
@given(st.data())
def test_any_byte_may_be_another(tmp_path_factory, data):
    content = bytearray(armature(1, frames=4).bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    content = content[: data.draw(st.sampled_from([len(content), len(content) // 2, 30, 20, 12]))]
    path = tmp_path_factory.mktemp("damaged") / "x.glb"
    path.write_bytes(content)
    sound_or_refused(path)


def test_the_undamaged_file_loads(tmp_path):
    (tmp_path / "x.glb").write_bytes(armature(1, frames=4).bytes())
    assert sound_or_refused(tmp_path / "x.glb")


def cycle(file: Glb) -> None:
    file.json["nodes"][3]["children"] = [0]
    file.json["nodes"][-1]["children"] = []


def external(file: Glb) -> None:
    file.json["buffers"] = [{"byteLength": len(file.data), "uri": "other.bin"}]


def compressed(file: Glb) -> None:
    file.json["bufferViews"][0]["extensions"] = {"EXT_meshopt_compression": {}}


def falling(file: Glb) -> None:
    file.data[:4] = struct.pack("<f", 9.0)  # the first key


def outside(file: Glb) -> None:
    file.json["accessors"][1]["count"] = 10_000


def nothing_animated(file: Glb) -> None:
    del file.json["skins"], file.json["animations"]


def in_centimetres(file: Glb) -> None:
    file.json["nodes"][-1]["scale"] = [1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (cycle, "tree"),
        (external, "another file"),
        (compressed, "EXT_meshopt_compression"),
        (falling, "do not rise"),
        (outside, "buffer view"),
        (nothing_animated, "neither a skin nor an animation"),
        (in_centimetres, "at most 10 m"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, change, words):
    file = armature(1, frames=4)
    change(file)
    text = json.dumps(file.json | {"buffers": file.json.get("buffers", [{"byteLength": 1}])})
    (tmp_path / "x.glb").write_bytes(glb(text, bytes(file.data)))
    with pytest.raises(FileFormatError, match=words):
        load_motion(tmp_path / "x.glb")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "empty"),
        (b"PK\3\4 what is this", "begins with"),
        (b"glTF\1\0\0\0\x10\0\0\0....", "version 1"),
        (armature(1).bytes()[:-1], "whole GLB"),
        (glb("{"), "no JSON"),
        (glb("[]"), "list"),
        (glb(b'{"asset": "\xff"}'), "UTF-8"),
        (glb('{"nodes": [], "nodes": 3}'), "nodes"),
        (glb("[" * 100_000), "nested"),
        (glb("{}"), "neither a skin"),
    ],
)
def test_containers(tmp_path, content, words):
    (tmp_path / "x.glb").write_bytes(content)
    with pytest.raises(FileFormatError, match=words):
        load_motion(tmp_path / "x.glb")


def test_a_missing_file(tmp_path):
    with pytest.raises(FileFormatError, match="no such file"):
        load_motion(tmp_path / "x.glb")
