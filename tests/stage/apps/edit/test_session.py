"""One tab: what it asks for is checked, done, and told to all tabs."""

import json

import numpy as np
import pytest

from mgjax.clips.labels import load_labels
from mgjax.core.errors import MgjaxError
from mgjax.stage.apps.edit.labels import LabelBook
from mgjax.stage.apps.edit.session import EditSession
from mgjax.stage.apps.edit.workbench import Workbench
from tests.stage.apps.edit.conftest import SETTINGS, Page, until_idle


@pytest.fixture
def page() -> Page:
    return Page()


@pytest.fixture
def tab(bench: Workbench, page: Page) -> EditSession:
    return EditSession(bench, page)


def add(tab: EditSession, start: int, stop: int, **more: object) -> None:
    tab.receive({"type": "label_add", "clip": "turns", "start": start, "stop": stop, **more})


def test_a_new_tab_is_told_everything(bench, page, tab):
    assert [m.get("event", m["type"]) for m in page.messages] == [
        *("ready", "clips", "rows", "labels", "used", "graph")
    ]
    assert page.last("clips")["names"] == list(bench.library.names)
    assert page.last("clips")["labels_file"] is None
    assert set(page.last("labels")["clips"]) == {"duck", "sway", "crouch_jump", "turns"}


def test_a_clip_that_is_picked_is_shown(page, tab):
    tab.receive({"type": "pick", "clip": "duck"})
    show = page.last("show")
    assert (show["of"], show["clip"]) == ("clip", "duck")
    assert len(show["show"]["actors"]) == 1
    assert show["show"]["seconds"] > 9


@pytest.mark.parametrize(
    "message",
    [
        {"type": "pick", "clip": "../../etc/passwd"},
        {"type": "pick", "clip": 3},
        {"type": "pick"},
        {"type": "nothing"},
        {"type": "label_add", "clip": "duck", "start": 0, "stop": 1e30},
        {"type": "label_add", "clip": "duck", "start": 0.5, "stop": 3},
        {"type": "label_add", "clip": "duck", "start": 0, "stop": 5, "kind": "x" * 41},
        {"type": "label_add", "clip": "duck", "start": 0, "stop": 5, "kind": "  "},
        {"type": "label_add", "clip": "duck", "start": 0, "stop": 5, "kind": "a\nb"},
        {"type": "label_add", "clip": "duck", "start": 0, "stop": 5, "direction": "up"},
        {"type": "label_add", "clip": "duck", "start": 0, "stop": 5, "genuine": 1},
        {"type": "label_change", "clip": "duck", "label": 99, "start": 0},
        {"type": "label_delete", "clip": "duck", "label": -1},
        {"type": "undo"},
        {"type": "redo"},
        {"type": "reread"},
        {"type": "transition", "edge": 0},
        {"type": "transition", "edge": 10**7},
        {"type": "throw", "direction": 0, "height": 0},
        {"type": "cover", "rounds": 1000},
        {"type": "build", "threshold_m": -1, "keep": 0.9, "retarget": False},
        {"type": "build", "threshold_m": None, "keep": 2, "retarget": False},
        {"type": "stop", "job": "everything"},
        {"type": "use", "clip": "no", "on": True},
    ],
)
def test_what_means_nothing_is_refused_and_changes_nothing(bench, tab, message):
    before = bench.book.table.labels()
    with pytest.raises(MgjaxError, match="expected"):
        tab.receive(message)
    assert bench.book.table.labels() == before
    assert not bench.book.table.changed
    assert not bench.busy


def test_labels_are_made_changed_and_taken_back(bench, page, tab):
    before = bench.book.table.labels()
    add(tab, 0, 10, kind=" swerve ", direction="left", genuine=False)
    number = page.last("chosen")["label"]
    (row,) = [r for r in page.last("labels")["clips"]["turns"] if r["id"] == number]
    assert (row["kind"], row["direction"], row["genuine"]) == ("swerve", "left", False)
    assert "swerve" in page.last("labels")["kinds"]
    change = {"type": "label_change", "clip": "turns", "label": number}
    tab.receive({**change, "stop": 12, "kind": "duck"})
    assert bench.book.table.of("turns")[0].label.kind == "duck"
    tab.receive({"type": "label_delete", "clip": "turns", "label": number})
    for _ in range(3):
        tab.receive({"type": "undo"})
    assert bench.book.table.labels() == before
    assert page.last("went")["clip"] == "turns"
    assert not page.last("labels")["changed"]
    assert page.last("labels")["can_redo"]
    tab.receive({"type": "redo"})
    assert len(bench.book.table.of("turns")) == len(before["turns"]) + 1


def test_a_refused_change_shows_again_what_is(page, tab):
    add(tab, 0, 10)
    number = page.last("chosen")["label"]
    told = len(page.of("labels"))
    with pytest.raises(MgjaxError, match="outside the clip"):
        tab.receive({"type": "label_change", "clip": "turns", "label": number, "stop": 10**6})
    assert len(page.of("labels")) == told + 1


def test_all_tabs_see_an_edit_until_they_are_closed(bench, page, tab):
    other = Page()
    second = EditSession(bench, other)
    add(tab, 0, 10)
    assert other.last("labels")["changed"]
    assert not other.of("chosen")
    second.close()
    told = len(other.messages)
    add(tab, 10, 20)
    assert len(other.messages) == told


def test_labels_of_no_file_are_downloaded(page, tab):
    add(tab, 0, 10)
    tab.receive({"type": "save"})
    document = json.loads(page.last("file")["data"].tobytes())
    assert document["clips"]["turns"][0] == {
        "start_s": 0.0, "end_s": 0.333333, "kind": "duck", "genuine": True
    }  # fmt: skip
    assert not page.last("labels")["changed"]


@pytest.fixture
def folder(tmp_path, some):
    """Two of the clips as files, one file that is none, and labels."""
    from mgjax.io.bvh.write import save_bvh

    for clip in (c for c in some[0] if c.name in ("duck", "sway")):
        save_bvh(tmp_path / f"{clip.name}.bvh", clip.skeleton, clip.motion)
    (tmp_path / "bad.bvh").write_text("HIERARCHY\nnothing\n")
    labels = {"clips": {"duck.bvh": [{"start_s": 1.0, "end_s": 2.0, "kind": "duck", "seen": 3}]}}
    (tmp_path / "labels.json").write_text(json.dumps(labels))
    return tmp_path


@pytest.fixture
def files(folder):
    from mgjax.stage.apps.edit.library import folder_library

    library = folder_library(folder)
    bench = Workbench(library, LabelBook(library, folder / "labels.json"), SETTINGS, None)
    yield bench
    bench.close()


def test_labels_are_saved_into_the_file_and_nowhere_else(folder, files):
    page = Page()
    tab = EditSession(files, page)
    there = {p.name: p.stat().st_mtime_ns for p in folder.iterdir()}
    label = files.book.table.of("duck.bvh")[0].id
    tab.receive(
        {
            "type": "label_change",
            "clip": "duck.bvh",
            "label": label,
            "start": 33,
            "direction": "left",
        }
    )
    assert page.last("labels")["changed"]
    tab.receive({"type": "save"})
    assert not page.last("labels")["changed"]
    assert page.last("sentence")["tone"] == "good"
    (written,) = json.loads((folder / "labels.json").read_text())["clips"]["duck.bvh"]
    assert written == {
        "start_s": 1.1, "end_s": 2.0, "kind": "duck", "seen": 3, "direction": "left"
    }  # fmt: skip
    now = {p.name: p.stat().st_mtime_ns for p in folder.iterdir()}
    assert {name for name in now if now[name] != there.get(name)} == {"labels.json"}


def test_a_conflict_is_told_and_solved_either_way(folder, files):
    page = Page()
    tab = EditSession(files, page)
    label = files.book.table.of("duck.bvh")[0].id
    tab.receive({"type": "label_delete", "clip": "duck.bvh", "label": label})
    newer = {"clips": {"duck.bvh": [{"start_s": 3.0, "end_s": 4.0, "kind": "sway"}]}}
    (folder / "labels.json").write_text(json.dumps(newer))
    with pytest.raises(MgjaxError, match="changed since it was read"):
        tab.receive({"type": "save"})
    assert page.of("conflict")
    assert json.loads((folder / "labels.json").read_text()) == newer
    tab.receive({"type": "reread"})
    assert [i.label.kind for i in files.book.table.of("duck.bvh")] == ["sway"]
    (folder / "labels.json").write_text("{}")
    tab.receive({"type": "label_add", "clip": "sway.bvh", "start": 0, "stop": 9})
    tab.receive({"type": "save", "overwrite": True})
    clips, _ = files.library.load(lambda share: None, ["bad.bvh"], [])
    assert set(load_labels(folder / "labels.json", clips, folder)) == {"duck.bvh", "sway.bvh"}


def test_a_bad_file_is_listed_with_its_error_and_the_rest_goes_on(folder, files):
    page = Page()
    tab = EditSession(files, page)
    for name in files.library.names:
        files.library.entry(name)
    tab.tick()
    rows = {row["name"]: row for row in page.last("rows")["rows"]}
    assert "bad.bvh" in rows["bad.bvh"]["error"]
    assert "\n" not in rows["bad.bvh"]["error"]
    assert "strip" not in rows["bad.bvh"]
    assert rows["duck.bvh"]["strip"].dtype == np.int16
    assert "38 joints" in rows["duck.bvh"]["lines"][0]
    with pytest.raises(MgjaxError, match=r"bad\.bvh"):
        tab.receive({"type": "pick", "clip": "bad.bvh"})
    tab.receive({"type": "pick", "clip": "duck.bvh"})
    assert page.of("show")


def test_a_build_leaves_out_what_it_is_told_to_and_what_is_bad(folder, files):
    page = Page()
    tab = EditSession(files, page)
    tab.receive({"type": "use", "clip": "sway.bvh", "on": False})
    assert page.last("used")["left_out"] == ["sway.bvh"]
    tab.receive({"type": "build", "threshold_m": 0.05, "keep": 0.9, "retarget": False})
    with pytest.raises(MgjaxError, match="another build"):
        tab.receive({"type": "build", "threshold_m": 0.05, "keep": 0.9, "retarget": False})
    until_idle(files)
    graph = page.last("graph")
    assert [clip["name"] for clip in graph["clips"]] == ["duck.bvh"]
    assert any("bad.bvh" in note for note in graph["notes"])
    assert [label["kept"] for label in graph["labels"]] == [True]
    assert page.last("sentence")["text"].startswith("Graph built: 1 clips")
    assert [m["running"] for m in page.of("job")][-1] is False
    assert {p.name for p in folder.iterdir()} == {
        "bad.bvh", "duck.bvh", "sway.bvh", "labels.json"
    }  # fmt: skip
