"""The labels file keeps all that was not edited, and is never written over what is newer."""

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mgjax.clips.labels import load_labels
from mgjax.clips.types import Clip, Label
from mgjax.core.errors import LabelError, OutputError
from mgjax.stage.apps.edit.labels_file import LabelsFile, labels_text
from mgjax.stage.apps.edit.table import Extent, LabelTable
from tests.conftest import make_motion, make_skeleton

RATE, FRAMES = 60.0, 600
EXTENT = Extent(frames=FRAMES, rate=RATE)
NAMES = ("one.bvh", "sub/two.bvh")
BODY = make_skeleton()
CLIPS = [
    Clip(name=name, skeleton=BODY, motion=make_motion(BODY, FRAMES, frame_rate=RATE))
    for name in NAMES
]
DUCK = {
    "start_s": 0.5,
    "end_s": 1.0,
    "peak_s": 0.7,
    "kind": "duck",
    "direction": "none",
    "note": "ä",
}
SWAY = {"start_s": 1, "end_s": 2, "kind": "sway", "direction": "left", "genuine": False}
DOCUMENT = {
    "_about": "by hand",
    "clips": {"one.bvh": [DUCK, SWAY], "gone.bvh": [{"start_s": 0, "end_s": 1, "kind": "jump"}]},
    "version": 123456789012345678901234567890,
}


def opened(folder: Path, document: object = DOCUMENT, indent: int | None = 2) -> LabelsFile:
    for name in NAMES:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).touch()
    text = document if isinstance(document, str) else json.dumps(document, indent=indent)
    (folder / "labels.json").write_text(text, encoding="utf-8")
    return LabelsFile(folder / "labels.json", folder, NAMES)


def test_labels_are_read_as_the_builder_reads_them(tmp_path):
    file = opened(tmp_path, {"clips": {"one.bvh": [DUCK, SWAY], "sub\\two.bvh": [SWAY]}})
    table = LabelTable(file.intervals)
    assert table.labels() == load_labels(tmp_path / "labels.json", CLIPS, tmp_path)
    assert file.strange == []


def test_nothing_edited_is_nothing_changed(tmp_path):
    file = opened(tmp_path)
    assert file.strange == ["gone.bvh"]
    assert json.loads(file.text(LabelTable(file.intervals))) == DOCUMENT


@pytest.mark.parametrize(("indent", "end"), [(None, ""), (1, "\n"), (4, "")])
def test_the_text_is_laid_out_as_it_was(tmp_path, indent, end):
    text = json.dumps(DOCUMENT, indent=indent) + end
    file = opened(tmp_path, text)
    assert file.text(LabelTable(file.intervals)) == text


def test_an_edit_keeps_every_other_key(tmp_path):
    file = opened(tmp_path)
    table = LabelTable(file.intervals)
    duck, sway = table.of("one.bvh")
    table.change("one.bvh", EXTENT, duck.id, start=33, genuine=False)
    table.change("one.bvh", EXTENT, sway.id, direction="")
    table.add("one.bvh", EXTENT, 300, 330, kind="jump")
    file.save(table)
    written = json.loads((tmp_path / "labels.json").read_text(encoding="utf-8"))
    first, second, third = written["clips"]["one.bvh"]
    assert first == {**DUCK, "start_s": 0.55, "genuine": False}
    assert second == {**SWAY, "direction": "none"}
    assert third == {"start_s": 5.0, "end_s": 5.5, "kind": "jump", "genuine": True}
    assert {k: v for k, v in written.items() if k != "clips"} == {
        k: v for k, v in DOCUMENT.items() if k != "clips"
    }
    assert written["clips"]["gone.bvh"] == DOCUMENT["clips"]["gone.bvh"]


def test_a_deleted_label_is_gone_and_its_clip_stays_named(tmp_path):
    file = opened(tmp_path, {"clips": {"one.bvh": [DUCK]}})
    table = LabelTable(file.intervals)
    table.delete("one.bvh", 0)
    file.save(table)
    assert json.loads((tmp_path / "labels.json").read_text()) == {"clips": {"one.bvh": []}}


def test_two_names_of_one_clip_keep_their_own(tmp_path):
    document = {"clips": {"sub/two.bvh": [SWAY], "sub\\two.bvh": [DUCK]}}
    file = opened(tmp_path, document)
    table = LabelTable(file.intervals)
    table.add("sub/two.bvh", EXTENT, 300, 330, kind="jump")
    clips = json.loads(file.text(table))["clips"]
    assert [len(items) for items in clips.values()] == [2, 1]
    assert clips["sub\\two.bvh"] == [DUCK]


def test_a_clip_is_named_from_the_folder_of_the_labels_file(tmp_path):
    file = opened(tmp_path / ".", {"clips": {}})
    (tmp_path / "labels").mkdir()
    away = LabelsFile(tmp_path / "labels" / "mine.json", tmp_path, NAMES)
    above = LabelsFile(tmp_path / "labels.json", tmp_path / "sub", ["two.bvh"])
    for made, clip in ((file, "sub/two.bvh"), (away, "sub/two.bvh"), (above, "two.bvh")):
        table = LabelTable()
        table.add(clip, EXTENT, 0, 30, kind="duck")
        assert list(json.loads(made.text(table))["clips"]) == ["sub/two.bvh"]


def test_saving_makes_a_file_that_was_not_there(tmp_path):
    opened(tmp_path).path.unlink()
    file = LabelsFile(tmp_path / "labels.json", tmp_path, NAMES)
    table = LabelTable(file.intervals)
    table.add("one.bvh", EXTENT, 0, 30, kind="duck", direction="left")
    file.save(table)
    assert load_labels(tmp_path / "labels.json", CLIPS, tmp_path) == table.labels()


def test_a_file_that_somebody_else_wrote_is_not_overwritten_silently(tmp_path):
    file = opened(tmp_path)
    table = LabelTable(file.intervals)
    table.delete("one.bvh", 0)
    (tmp_path / "labels.json").write_text('{"clips": {}}')
    with pytest.raises(OutputError, match="changed since it was read"):
        file.save(table)
    assert (tmp_path / "labels.json").read_text() == '{"clips": {}}'
    file.save(table, overwrite=True)
    assert len(json.loads((tmp_path / "labels.json").read_text())["clips"]["one.bvh"]) == 1
    file.save(table)


def test_a_file_that_was_taken_away_or_put_there_is_noticed(tmp_path):
    file = opened(tmp_path)
    file.path.unlink()
    assert file.changed_on_disk()
    fresh = LabelsFile(tmp_path / "labels.json", tmp_path, NAMES)
    assert not fresh.changed_on_disk()
    (tmp_path / "labels.json").write_text("{}")
    assert fresh.changed_on_disk()


@pytest.mark.parametrize(
    "text", ["", "[1]", '{"clips": 3}', '{"clips": {"one.bvh": 3}}', '{"clips": {"one.bvh": [{}]}}']
)
def test_what_is_no_labels_file_is_refused(tmp_path, text):
    with pytest.raises((LabelError, ValueError), match=r"labels\.json"):
        opened(tmp_path, text)


def test_labels_of_memory_are_a_labels_file(tmp_path):
    opened(tmp_path)
    labels = {"one.bvh": (Label(start_s=0.5, end_s=1.0, kind="duck", direction="left"),)}
    (tmp_path / "labels.json").write_text(labels_text(labels))
    assert load_labels(tmp_path / "labels.json", CLIPS, tmp_path) == labels


EXTRA = st.dictionaries(
    st.text(min_size=1).filter(
        lambda k: k not in ("start_s", "end_s", "kind", "direction", "genuine")
    ),
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    max_size=3,
)


@given(extra=EXTRA, about=EXTRA, start=st.integers(0, 200), length=st.integers(1, 200))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_is_written_is_read_back_exactly(tmp_path, extra, about, start, length):
    about = {k: v for k, v in about.items() if k != "clips"}
    file = opened(tmp_path, {**about, "clips": {"one.bvh": [{**extra, **DUCK}]}})
    table = LabelTable(file.intervals)
    table.change("one.bvh", EXTENT, 0, start=start, stop=start + length, kind="jump")
    table.add("sub/two.bvh", EXTENT, start, start + length, kind="Sprung", direction="right")
    file.save(table)
    assert load_labels(tmp_path / "labels.json", CLIPS, tmp_path) == table.labels()
    written = json.loads((tmp_path / "labels.json").read_text(encoding="utf-8"))
    assert {k: written["clips"]["one.bvh"][0][k] for k in extra} == extra
    assert {k: v for k, v in written.items() if k != "clips"} == about
    again = LabelsFile(tmp_path / "labels.json", tmp_path, NAMES)
    assert LabelTable(again.intervals).labels() == table.labels()
