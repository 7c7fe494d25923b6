from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from mgjax.avoidance.index import graph_folder
from mgjax.cli import build as build_command
from mgjax.graph.files import load_graph
from mgjax.graph.stages import choice
from mgjax.graph.stages.choice import build_stages
from tests.cli.conftest import Ran, refused, run
from tests.graph.stages.test_build_in_stages import assert_same_graph


def build(folder: Path, out: Path, *more: object) -> Ran:
    known = ("--labels", folder / "labels.json", "--config", folder / "graph.toml")
    return run("build", "--clips", folder, *known, "--out", out, "--json", *more)


def kept(work: Path) -> dict[str, set[str]]:
    return {folder.name: {f.name for f in folder.iterdir()} for folder in work.iterdir()}


@pytest.fixture(scope="module")
def staged(clips_folder, tmp_path_factory) -> tuple[Path, Path]:
    """A folder of stages, and the graph that was built with it."""
    place = tmp_path_factory.mktemp("staged")
    ran = build(clips_folder, place / "out", "--work", place / "work")
    assert (ran.status, ran.err) == (0, "")
    return place / "work", place / "out"


def test_each_stage_has_files_and_the_next_build_reads_them(
    clips_folder, staged, tmp_path, monkeypatch
):
    work, out = staged
    files = kept(work)
    assert set(files) == {"read", "groups", "minima", "graph", "transitions", "index"}
    assert len(files["read"]) == 4

    def never(*_: object, **__: object) -> None:
        raise AssertionError

    monkeypatch.setattr(graph_folder, "build_index", never)
    ran = build(clips_folder, tmp_path / "out", "--work", work)
    assert (ran.status, ran.err) == (0, "")
    assert kept(work) == files
    assert_same_graph(load_graph(out), load_graph(tmp_path / "out"))
    index = "grid_index.safetensors"
    assert (tmp_path / "out" / index).read_bytes() == (out / index).read_bytes()
    one, two = (
        json.loads((folder / "build.json").read_text()) for folder in (out, tmp_path / "out")
    )
    assert {k: v for k, v in one.items() if k != "seconds"} == {
        k: v for k, v in two.items() if k != "seconds"
    }


def test_a_file_that_changed_is_read_again(clips_folder, staged, tmp_path):
    folder, work = tmp_path / "clips", tmp_path / "work"
    shutil.copytree(clips_folder, folder)
    shutil.copytree(staged[0], work)
    lines = (folder / "steps.bvh").read_text().splitlines()
    (folder / "steps.bvh").write_text("\n".join([*lines[:-1], lines[-2]]) + "\n")
    ran = build(folder, tmp_path / "out", "--work", work)
    assert (ran.status, ran.err) == (0, "")
    assert len(kept(work)["read"]) == 5


def test_a_broken_file_stops_a_build_before_it_compares(clips_folder, tmp_path):
    folder, work = tmp_path / "clips", tmp_path / "work"
    shutil.copytree(clips_folder, folder)
    (folder / "broken.bvh").write_text("what is this")
    out = tmp_path / "out"
    refused(build(folder, out, "--work", work), "broken.bvh:1", out=out)
    assert set(kept(work)) == {"read"}
    ran = build(folder, out, "--work", work, "--skip-bad", "--no-index")
    assert ran.status == 0, ran.err
    assert ran.json["clips"] == 4
    assert any("left out" in note and "broken.bvh:1" in note for note in ran.json["notes"])


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--workers", 0), ("0 workers", "1 or more")),
        (("--address", "auto", "--executor", "processes"), ("an address for processes", "ray")),
        (("--executor", "ray", "--address", "127.0.0.1:1"), ("no Ray cluster at 127.0.0.1:1",)),
    ],
)
def test_executors_that_cannot_be(clips_folder, tmp_path, more, words):
    refused(build(clips_folder, tmp_path / "out", *more), *words, out=tmp_path / "out")


def test_a_work_folder_that_is_a_file_is_told_before_anything_is_read(
    clips_folder, tmp_path, monkeypatch
):
    monkeypatch.setattr(build_command, "load_clips", lambda *_, **__: pytest.fail("was read"))
    (tmp_path / "work").write_text("")
    ran = build(clips_folder, tmp_path / "out", "--work", tmp_path / "work")
    refused(ran, "work", "cannot be written", out=tmp_path / "out")


def test_only_large_input_is_kept_where_nobody_asks(tmp_path, monkeypatch):
    monkeypatch.setenv("MGJAX_CACHE", str(tmp_path))
    with build_stages(frames=choice.LARGE - 1) as stages:
        assert stages is None
    with build_stages(frames=choice.LARGE - 1, name="serial") as stages:
        assert stages is not None
        assert stages.store is None
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setattr(choice, "KEPT_BYTES", 0)
    with build_stages(frames=choice.LARGE) as stages:
        assert stages is not None
        assert stages.store is not None
        stages.save("minima", "one", {})
        assert stages.store.folder == tmp_path / "stages"
        assert kept(stages.store.folder) == {"minima": {"one.safetensors"}}
    assert kept(tmp_path / "stages") == {"minima": set()}
