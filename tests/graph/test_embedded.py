"""The embedded graph is kept between processes, and is the same from there."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from mgjax.graph import embedded
from mgjax.graph.config import EMBEDDED
from mgjax.graph.embedded import embedded_graph
from mgjax.graph.types import MotionGraph


def same(one: MotionGraph, other: MotionGraph) -> bool:
    return all(
        np.array_equal(getattr(one, field.name), getattr(other, field.name))
        for field in dataclasses.fields(one)
        if isinstance(getattr(one, field.name), np.ndarray)
    )


@pytest.fixture
def builds(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, made_graph: MotionGraph) -> list[int]:
    """Counts builds, of a graph that is quickly made, in a cache folder of its own."""
    counted: list[int] = []

    def build(*_: object, config: object, **__: object) -> MotionGraph:
        assert config is EMBEDDED
        counted.append(1)
        return made_graph

    monkeypatch.setattr(embedded, "build_graph", build)
    monkeypatch.setattr(embedded, "synthetic_clips", lambda: ([], {}))
    monkeypatch.setenv("MGJAX_CACHE", str(tmp_path / "cache"))
    return counted


def test_it_is_built_once(builds: list[int], tmp_path: Path) -> None:
    first, second = embedded_graph(), embedded_graph()
    assert builds == [1]
    assert same(first, second)
    (file,) = (tmp_path / "cache" / "graphs").glob("embedded-*/*")
    file.write_bytes(file.read_bytes()[:100])  # damaged
    assert same(embedded_graph(), first)
    assert builds == [1, 1]


def test_other_programs_build_it_anew(
    builds: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    embedded_graph()
    monkeypatch.setattr(embedded, "made_by", lambda: "others")
    embedded_graph()
    assert builds == [1, 1]
    assert len(list((tmp_path / "cache" / "graphs").iterdir())) == 1  # the older one is gone


def test_a_folder_that_cannot_be_written(builds: list[int], tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("")  # a file where the folder would be
    with pytest.warns(UserWarning, match="the embedded graph is not kept"):
        embedded_graph()
    assert builds == [1]
