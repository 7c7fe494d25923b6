from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mgjax.clips.labels import load_labels, validate_labels
from mgjax.clips.types import Clip, Label, as_clips, mirrored_direction
from mgjax.core.errors import FileFormatError, LabelError, MotionError
from tests.conftest import make_motion, make_skeleton

BODY = make_skeleton()
GOOD = {"start_s": 0.5, "end_s": 1.0, "kind": "duck"}


def made(name: str, frames: int = 120, frame_rate: float = 60.0) -> Clip:
    return Clip(name=name, skeleton=BODY, motion=make_motion(BODY, frames, frame_rate=frame_rate))


CLIPS = [made("one.bvh"), made("sub/two.bvh")]


def load(folder: Path, document, clips=CLIPS) -> dict[str, tuple[Label, ...]]:
    text = document if isinstance(document, str) else json.dumps(document, indent=1)
    (folder / "labels.json").write_text(text)
    return load_labels(folder / "labels.json", clips, folder)


def error(folder: Path, document, clips=CLIPS) -> str:
    with pytest.raises(FileFormatError) as caught:
        load(folder, document, clips)
    text = str(caught.value)
    assert "\n" not in text
    assert "labels.json" in text
    assert len(text) < 300 + len(str(folder))
    return text


def test_all_fields(tmp_path):
    more = {"direction": "left", "genuine": False, "note": "seen", "peak_s": 0.7}
    got = load(
        tmp_path, {"_about": "…", "clips": {"one.bvh": [{**GOOD, **more}], "sub/two.bvh": [GOOD]}}
    )
    one = Label(start_s=0.5, end_s=1.0, kind="duck", direction="left", genuine=False)
    two = Label(start_s=0.5, end_s=1.0, kind="duck", direction="", genuine=True)
    assert got == {"one.bvh": (one,), "sub/two.bvh": (two,)}


def test_a_backslash_means_a_slash(tmp_path):
    (label,) = load(tmp_path, {"clips": {"sub\\two.bvh": [GOOD]}})["sub/two.bvh"]
    assert label == Label(start_s=0.5, end_s=1.0, kind="duck")
    late = {**GOOD, "end_s": 99.0}
    assert "labels.json:3: got 'sub/two.bvh'" in error(
        tmp_path, {"clips": {"sub\\two.bvh": [late]}}
    )
    # Unless a clip is called so, as it may be here.
    odd = made("sub\\two.bvh")
    got = load(tmp_path, {"clips": {"sub\\two.bvh": [GOOD]}}, [*CLIPS, odd])
    assert got.keys() == {"sub\\two.bvh"}


def test_home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "sub"))
    assert load(tmp_path, {"clips": {"~/two.bvh": [GOOD]}}).keys() == {"sub/two.bvh"}


def test_direction_none_is_none_and_whole_numbers_are_numbers(tmp_path):
    item = {"start_s": 0, "end_s": 1, "kind": "duck", "direction": "none"}
    (got,) = load(tmp_path, {"clips": {"one.bvh": [item]}})["one.bvh"]
    assert got == Label(start_s=0.0, end_s=1.0, kind="duck")


def test_clips_without_labels_and_none_at_all(tmp_path):
    assert load(tmp_path, {"clips": {}}) == {}
    assert load(tmp_path, {"clips": {"one.bvh": []}}) == {"one.bvh": ()}


def test_paths_relative_to_the_file_or_to_the_clips(tmp_path):
    clips, other = tmp_path / "clips", tmp_path / "other"
    for folder in (clips, other):
        folder.mkdir()
    document = json.dumps({"clips": {"sub/two.bvh": [GOOD]}})
    (other / "labels.json").write_text(document)
    assert list(load_labels(other / "labels.json", CLIPS, clips)) == ["sub/two.bvh"]
    (tmp_path / "labels.json").write_text(document.replace("sub/", "clips/sub/"))
    assert list(load_labels(tmp_path / "labels.json", CLIPS, clips)) == ["sub/two.bvh"]


def test_one_clip_under_two_names(tmp_path):
    later = {**GOOD, "start_s": 1.2, "end_s": 1.5}
    got = load(tmp_path, {"clips": {"one.bvh": [GOOD], "./one.bvh": [later]}})
    assert [x.start_s for x in got["one.bvh"]] == [0.5, 1.2]
    assert "overlapping" in error(tmp_path, {"clips": {"one.bvh": [GOOD], "./one.bvh": [GOOD]}})


def test_a_clip_that_was_left_out_of_the_graph_is_no_error(tmp_path):
    (tmp_path / "three.bvh").write_text("not read")
    assert load(tmp_path, {"clips": {"three.bvh": [GOOD]}}) == {}


def test_touching_is_legal_and_order_does_not_matter(tmp_path):
    items = [
        {**GOOD, "start_s": 1.0, "end_s": 1.5},
        {**GOOD, "start_s": 0.0, "end_s": 0.5},
        {**GOOD, "start_s": 1.5, "end_s": 2.0},
        GOOD,
    ]
    got = load(tmp_path, {"clips": {"one.bvh": items}})["one.bvh"]
    assert [x.start_s for x in got] == [1.0, 0.0, 1.5, 0.5]


def test_ends_count_in_frames(tmp_path):
    # 120 frames at 60 Hz: 2.008 s rounds to frame 120, 2.009 s to 121; −0.008 s to 0.
    for good in ((0.0, 2.008), (-0.008, 1.0), (0.0, 0.009)):
        load(tmp_path, {"clips": {"one.bvh": [{**GOOD, "start_s": good[0], "end_s": good[1]}]}})
    # 0.5 … 1.004 s ends at frame 60, where the next begins.
    pair = [{**GOOD, "end_s": 1.004}, {**GOOD, "start_s": 1.0, "end_s": 1.5}]
    load(tmp_path, {"clips": {"one.bvh": pair}})


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"start_s": -0.1}, ["-0.1 … 1 s outside the clip", "0 … 2 s"]),
        ({"end_s": 2.1}, ["0.5 … 2.1 s outside the clip", "0 … 2 s"]),
        ({"end_s": 1e300}, ["outside the clip"]),
        ({"start_s": -1e300}, ["outside the clip"]),
        ({"end_s": 0.5}, ["0.5 … 0.5 s, which has no frame", "an end after its start"]),
        ({"end_s": 0.2}, ["0.5 … 0.2 s, which has no frame"]),
        ({"end_s": 0.505}, ["has no frame"]),
        ({"start_s": None}, ["interval 0: start_s = None", "a finite number of seconds"]),
        ({"start_s": "0.5"}, ["start_s = '0.5'"]),
        ({"start_s": True}, ["start_s = True"]),
        ({"end_s": float("nan")}, ["end_s = nan"]),
        ({"end_s": float("inf")}, ["end_s = inf"]),
        ({"end_s": 10**400}, ["end_s = inf"]),
        ({"end_s": [1.0]}, ["end_s = [1.0]"]),
        ({"kind": ""}, ["kind = ''", "a word such as duck"]),
        ({"kind": 3}, ["kind = 3"]),
        ({"kind": None}, ["kind = None"]),
        ({"direction": 1}, ["direction = 1", "left, right or none"]),
        ({"genuine": 1}, ["genuine = 1", "true or false"]),
        ({"genuine": "yes"}, ["genuine = 'yes'"]),
        ({"kind": ["x"] * 1000}, ["kind = ['x'"]),
    ],
)
def test_intervals_that_cannot_be(tmp_path, changes, parts):
    text = error(tmp_path, {"clips": {"one.bvh": [{**GOOD, **changes}]}})
    assert "labels.json:3: got 'one.bvh'" in text  # the line that names the clip
    for part in parts:
        assert part in text


def test_overlapping(tmp_path):
    items = [GOOD, {**GOOD, "start_s": 1.5, "end_s": 1.8}, {**GOOD, "start_s": 0.9, "end_s": 1.2}]
    text = error(tmp_path, {"clips": {"sub/two.bvh": items}})
    assert "'sub/two.bvh': interval 0.9 … 1.2 s overlapping 0.5 … 1 s" in text
    assert "expected intervals that at most touch" in text
    inside = [{**GOOD, "start_s": 0.0, "end_s": 1.9}, GOOD]
    assert "overlapping" in error(tmp_path, {"clips": {"one.bvh": inside}})


@pytest.mark.parametrize("item", [None, 3, "duck", [0.5, 1.0], {}])
def test_items_that_are_no_intervals(tmp_path, item):
    assert "'one.bvh', interval 1: " in error(tmp_path, {"clips": {"one.bvh": [GOOD, item]}})


@pytest.mark.parametrize("name", ["nowhere.bvh", "a\0b", "x" * 5000, "", "/", "../..", "a\nb"])
def test_a_clip_that_is_not_there(tmp_path, name):
    with pytest.raises(LabelError) as caught:
        load(tmp_path, {"clips": {name: [GOOD]}})
    text = str(caught.value)
    assert "which is not there, expected a clip" in text
    assert "\n" not in text


@pytest.mark.parametrize(
    "document", [[], 3, None, {}, {"clips": []}, {"clips": None}, {"Clips": {}}, '"clips"']
)
def test_documents_that_are_no_labels(tmp_path, document):
    assert "'clips'" in error(tmp_path, document)


def test_a_clip_with_no_list(tmp_path):
    assert "expected a list" in error(tmp_path, {"clips": {"one.bvh": GOOD}})


def test_bad_json_names_its_line(tmp_path):
    text = error(tmp_path, '{"clips": {\n "one.bvh": [\n  {"start_s": 0.5,, "end_s": 1}]}}')
    assert "labels.json:3: got no JSON" in text


def test_a_key_that_is_there_twice(tmp_path):
    text = error(tmp_path, '{"clips": {\n "one.bvh": [],\n "one.bvh": []}}')
    assert "'one.bvh' twice" in text
    twice = '{"clips": {"one.bvh": [{"start_s": 0, "start_s": 0.5, "end_s": 1, "kind": "duck"}]}}'
    assert "'start_s' twice" in error(tmp_path, twice)


def test_deep_nesting_and_long_numbers(tmp_path):
    error(tmp_path, "[" * 200_000)
    assert "too deep" in error(tmp_path, '{"clips":' * 50_000 + "1" + "}" * 50_000)
    error(tmp_path, '{"clips": ' + "9" * 10_000 + "}")
    item = '{"start_s": 0, "end_s": ' + "9" * 10_000 + ', "kind": "duck"}'
    assert "end_s = inf" in error(tmp_path, '{"clips": {"one.bvh": [' + item + "]}}")


def test_files_that_are_none(tmp_path):
    with pytest.raises(FileFormatError, match=r"labels\.json"):
        load_labels(tmp_path / "labels.json", CLIPS, tmp_path)
    assert "empty" in error(tmp_path, "  \n ")
    (tmp_path / "labels.json").write_bytes(b"{\0}")
    with pytest.raises(FileFormatError, match="binary"):
        load_labels(tmp_path / "labels.json", CLIPS, tmp_path)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8),
    lambda x: (
        st.lists(x, max_size=3)
        | st.dictionaries(st.sampled_from(["clips", "one.bvh", "start_s", "end_s", "kind"]), x)
    ),
    max_leaves=12,
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
@given(JSON, st.text(max_size=5), st.integers(0, 200))
def test_anything_gives_labels_or_the_documented_error(tmp_path, document, junk, place):
    text = json.dumps({"clips": {"one.bvh": [{**GOOD, "kind": document}, document]}})
    for content in (document, text[:place] + junk + text[place:]):
        message = ""
        try:
            load(tmp_path, content)
        except FileFormatError as error:
            message = str(error)
        assert "\n" not in message


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf"), 1e308])
def test_labels_that_are_given_are_checked_as_well(bad):
    for label in (
        Label(start_s=bad, end_s=1.0, kind="duck"),
        Label(start_s=0.5, end_s=bad, kind="duck"),
    ):
        with pytest.raises(
            LabelError, match=r"labels: got 'one\.bvh': interval .* outside the clip"
        ):
            validate_labels({"one.bvh": (label,)}, CLIPS)


def test_labels_that_are_given_for_no_clip():
    with pytest.raises(LabelError, match="labels for 'three'"):
        validate_labels({"three": ()}, CLIPS)
    validate_labels({}, CLIPS)
    validate_labels({"one.bvh": ()}, CLIPS)


def test_clips_in_all_forms():
    pair = (CLIPS[0].skeleton, CLIPS[0].motion)
    assert [c.name for c in as_clips([pair, CLIPS[1], pair])] == ["clip0", "sub/two.bvh", "clip2"]
    assert [c.name for c in as_clips({"x": pair, "y": pair})] == ["x", "y"]
    assert as_clips([]) == []
    with pytest.raises(MotionError, match="two clips are called"):
        as_clips([CLIPS[0], CLIPS[0]])


def test_directions_in_a_mirror():
    assert [mirrored_direction(d) for d in ("left", "right", "", "back")] == [
        "right",
        "left",
        "",
        "back",
    ]


def test_real_labels(capture):
    from mgjax.clips.folder import load_clips

    folder = capture / "avoidance"
    clips, _ = load_clips(folder / "cmu14")
    labels = load_labels(folder / "labels.json", clips, folder / "cmu14")
    document = json.loads((folder / "labels.json").read_text())["clips"]
    for clip in clips:
        items = document.get(f"cmu14/{clip.name}", [])
        assert [x.start_s for x in labels.get(clip.name, ())] == [x["start_s"] for x in items]
    assert sum(len(x) for x in labels.values()) > 20
