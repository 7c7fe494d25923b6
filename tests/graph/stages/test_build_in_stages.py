from __future__ import annotations

import dataclasses
import errno
from pathlib import Path

import numpy as np
import pytest

from mgjax.clips.types import Clip
from mgjax.core.errors import OutputError
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.distances import pruned
from mgjax.graph.distances.minima import Minima, find_minima
from mgjax.graph.distances.pruned import TILE
from mgjax.graph.stages import block
from mgjax.graph.stages.groups import corpus_groups
from mgjax.graph.stages.minima import staged_minima
from mgjax.graph.stages.stages import Stages, stage_store
from mgjax.graph.timeline import make_timeline
from mgjax.graph.types import MotionGraph
from tests.graph.distances.test_pruned import SIDE, same
from tests.graph.made import BODY, clip, march

ENTRIES = 200
"""Of a group: each clip of the tests is one."""


def stages(folder: Path) -> Stages:
    return Stages(store=stage_store(folder), entries=ENTRIES)


def arrays_of(graph: MotionGraph) -> dict[str, np.ndarray]:
    fields = {f.name: getattr(graph, f.name) for f in dataclasses.fields(graph)}
    return {name: x for name, x in fields.items() if isinstance(x, np.ndarray)}


def assert_same_graph(one: MotionGraph, other: MotionGraph) -> None:
    """Bit for bit."""
    for name, want in arrays_of(one).items():
        got = arrays_of(other)[name]
        assert got.dtype == want.dtype, name
        np.testing.assert_array_equal(got, want, err_msg=name)
    assert one.clip_names == other.clip_names


def counts(used: Stages) -> tuple[dict[str, int], dict[str, int]]:
    assert used.store is not None
    return dict(used.store.found), dict(used.store.made)


@pytest.fixture(scope="module")
def three(made) -> tuple[list[Clip], dict]:
    return made


@pytest.fixture(scope="module")
def built(three, tmp_path_factory) -> tuple[Path, MotionGraph]:
    folder = tmp_path_factory.mktemp("stages") / "new" / "folder"
    used = stages(folder)
    graph = build_graph(three[0], labels=three[1], stages=used)
    assert counts(used)[0] == {}
    # Three groups: six pairs of groups, with each other and themselves.
    assert counts(used)[1]["minima"] == 6
    return folder, graph


@pytest.fixture
def minima_of(monkeypatch):
    """Minima of clips in groups of so many entries, in tiles of a few entries."""
    for module in (pruned, block):
        monkeypatch.setattr(module, "TILE", SIDE)

    def found(lengths: tuple[int, ...], entries: int | None, seed: int = 0) -> Minima:
        clips = [clip(str(k), march(n, seed=seed + k, noise=0.05)) for k, n in enumerate(lengths)]
        timeline, _ = make_timeline(clips, {}, BODY, GraphConfig())
        weights = np.full(BODY.num_joints, 1 / BODY.num_joints, np.float32)
        rng = np.random.default_rng(5)
        masks = rng.random((2, len(timeline.root))) < 0.9
        settings = {
            "window": 6,
            "neighbourhood": 2,
            "threshold": 0.12,
            "grain": 2.0**-40,
            "leave": masks[0],
            "arrive": masks[1],
        }
        if entries is None:
            return find_minima(
                timeline.positions,
                timeline.starts,
                timeline.stops,
                weights,
                **settings,
            )
        where = Stages(entries=entries)
        groups = corpus_groups(timeline, tuple(masks), where, gap=2)
        return staged_minima(timeline, groups, weights, where, **settings)

    return found


def test_blocks_find_what_one_search_finds(minima_of):
    lengths = (150, 40, 5, 61, 90)
    assert same(minima_of(lengths, None), minima_of(lengths, SIDE)) > 20


def test_how_the_work_is_cut_changes_no_bit(minima_of):
    lengths = (150, 40, 61, 90)
    one, *others = (minima_of(lengths, entries) for entries in (None, SIDE, 130, 10_000))
    for other in others:
        for name in ("rows", "columns", "distances"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_stages_and_one_piece_make_the_same_graph(built, made_graph):
    for name, want in arrays_of(made_graph).items():
        np.testing.assert_array_equal(arrays_of(built[1])[name], want, err_msg=name)


def test_a_second_build_computes_nothing(three, built):
    used = stages(built[0])
    graph = build_graph(three[0], labels=three[1], stages=used)
    assert_same_graph(built[1], graph)
    found, made = counts(used)
    assert made == {}
    assert found["minima"] == 6


def test_clips_that_are_added_are_compared_alone(three, built, tmp_path):
    added = [clip(f"new{k}", march(70 + 10 * k, seed=20 + k)) for k in range(3)]
    clips = [added[0], *three[0], *added[1:]]
    used = stages(built[0])
    graph = build_graph(clips, labels=three[1], stages=used)
    found, made = counts(used)
    # 70 + 80 are one new group, 90 is another: 2 × 3 blocks with the old ones, 3 of the new ones.
    assert (found["minima"], made["minima"]) == (6, 9)
    assert_same_graph(build_graph(clips, labels=three[1], stages=stages(tmp_path)), graph)


def test_files_that_are_spoiled_are_made_anew(three, built, tmp_path):
    graph = build_graph(three[0], labels=three[1], stages=stages(tmp_path))
    cut, flipped, other = sorted((tmp_path / "minima").iterdir())[:3]
    cut.write_bytes(cut.read_bytes()[:-9])
    data = bytearray(flipped.read_bytes())
    data[-1] ^= 1  # a number that is another one now: the file can be read
    flipped.write_bytes(data)
    text, version = other.read_bytes(), b", jax 0."
    assert text.count(version) == 1
    other.write_bytes(text.replace(version, b", jax 9."))
    used = stages(tmp_path)
    again = build_graph(three[0], labels=three[1], stages=used)
    assert_same_graph(graph, again)
    assert_same_graph(built[1], again)
    assert counts(used)[1] == {"minima": 3}
    assert [n for n in again.report["notes"] if "2 more stage files: damaged or of an" in n]


def test_a_setting_that_matters_makes_other_files(three, built):
    used = stages(built[0])
    config = GraphConfig(max_threshold_m=0.15, keep=0.5)
    build_graph(three[0], labels=three[1], config=config, stages=used)
    assert counts(used)[1]["minima"] == 6
    assert "minima" not in counts(used)[0]


def test_a_folder_that_cannot_be_written_is_told_at_once(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"file/stages: cannot be written .*expected a writable"):
        stage_store(tmp_path / "file" / "stages")


def test_a_full_disk_leaves_nothing_half_written(three, tmp_path, monkeypatch):
    used = stages(tmp_path)
    whole = Path.write_bytes

    def write(path: Path, data: bytes) -> int:
        if path.parent.name == "transitions":
            whole(path, data[: len(data) // 2])
            raise OSError(errno.ENOSPC, "No space left on device")
        return whole(path, data)

    monkeypatch.setattr(Path, "write_bytes", write)
    with pytest.raises(OutputError, match=r"cannot be written \(.*[Nn]o space left"):
        build_graph(three[0], labels=three[1], stages=used)
    assert list((tmp_path / "transitions").iterdir()) == []
    monkeypatch.undo()
    again = stages(tmp_path)
    build_graph(three[0], labels=three[1], stages=again)
    assert counts(again)[0]["minima"] == 6


def test_what_bounds_do_not_serve_is_found_in_one_piece(three, tmp_path):
    config = GraphConfig(normalised=0.2)
    used = stages(tmp_path)
    graph = build_graph(three[0], labels=three[1], config=config, stages=used)
    assert "minima" not in counts(used)[1]
    want = build_graph(three[0], labels=three[1], config=config)
    assert_same_graph(want, graph)


def test_a_group_holds_a_tile():
    assert Stages().entries == TILE
