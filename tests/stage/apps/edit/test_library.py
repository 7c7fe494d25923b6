"""Clips by name, read in the background, with a few of their poses; and the application's start."""

import json
import time

import numpy as np
import pytest

from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.errors import ConfigError, MgjaxError, MotionError
from mgjax.graph.files import save_graph
from mgjax.io.bvh.write import save_bvh
from mgjax.stage.apps.edit.app import graph_clips, graph_labels, make_app
from mgjax.stage.apps.edit.filmstrip import POSES, key_poses
from mgjax.stage.apps.edit.labels import LabelBook
from mgjax.stage.apps.edit.library import KEPT, folder_library, memory_library
from mgjax.stage.serve.options import Options
from tests.conftest import make_motion, make_skeleton
from tests.stage.apps.edit.conftest import Page, until_idle


def read_all(library):
    library.start()
    end = time.monotonic() + 60
    while len(library.entries()) < len(library.names) and time.monotonic() < end:
        time.sleep(0.005)
    return library


def test_all_clips_are_read_once_and_told_once(library):
    read_all(library)
    assert [e.name for e in library.take_new()] == list(library.names)
    assert library.take_new() == []
    assert all(e.extent is not None and e.extent.rate == 30.0 for e in library.entries())
    library.close()


def test_a_clip_that_is_looked_at_is_read_at_once(library):
    assert library.entry("sway").extent == library.extent("sway")
    assert [e.name for e in library.take_new()] == ["sway"]
    assert library.motion("sway")[1] is library.motion("sway")[1]
    with pytest.raises(MotionError, match="expected one of the list"):
        library.entry("../sway")


def test_few_motions_stay_in_memory(tmp_path):
    body = make_skeleton()
    for n in range(KEPT + 2):
        save_bvh(tmp_path / f"{n:02}.bvh", body, make_motion(body, 8, seed=n))
    library = folder_library(tmp_path)
    first = library.motion("00.bvh")
    for name in library.names:
        library.motion(name)
    assert library.motion("00.bvh") is not first
    np.testing.assert_array_equal(
        library.motion("00.bvh")[1].root_translation, first[1].root_translation
    )


def test_labelled_clips_stay_of_two_with_one_motion(some, tmp_path):
    clip = next(c for c in some[0] if c.name == "duck")
    for name in ("a_copy.bvh", "duck.bvh"):
        save_bvh(tmp_path / name, clip.skeleton, clip.motion)
    library = folder_library(tmp_path)
    assert [c.name for c in library.load(lambda s: None, (), ())[0]] == ["a_copy.bvh"]
    assert [c.name for c in library.load(lambda s: None, (), ["duck.bvh"])[0]] == ["duck.bvh"]
    assert [c.name for c in library.load(lambda s: None, ["a_copy.bvh"], ())[0]] == ["duck.bvh"]


def test_names_are_no_patterns(some, tmp_path):
    clip = some[0][0]
    for name in ("[ab].bvh", "a.bvh"):
        save_bvh(tmp_path / name, clip.skeleton, clip.motion)
    library = folder_library(tmp_path)
    assert [c.name for c in library.load(lambda s: None, ["[ab].bvh"], ())[0]] == ["a.bvh"]


def test_poses_stand_on_the_floor_and_do_not_turn_with_the_body(some):
    clip = next(c for c in some[0] if c.name == "turns")
    strip = key_poses(clip.skeleton, clip.motion)
    assert strip.shape == (POSES, clip.skeleton.num_joints, 2)
    assert (strip[:, 0, 0] == 0).all()
    assert (np.abs(strip[..., 1].min(axis=1)) < 60).all()
    assert 950 <= np.ptp(strip[..., 1]) <= 1050
    left, right = (clip.skeleton.index(f"{side}humerus") for side in "lr")
    width = strip[:, left, 0] - strip[:, right, 0]
    assert (width > 0).all()  # seen from the front its left is on the right
    assert np.ptp(width) < 0.5 * width.mean()


def test_one_frame_has_a_pose():
    body = make_skeleton()
    assert key_poses(body, make_motion(body, 1)).shape[0] == 1


def test_a_graph_gives_its_clips_and_labels_back(graph, some):
    clips = {c.name: c for c in graph_clips(graph)}
    assert set(clips) == {c.name for c in some[0]}
    for name, items in graph_labels(graph).items():
        for label in items:
            assert any(
                abs(label.start_s - x.start_s) <= 0.5 / 30 + 1e-9 and label.kind == x.kind
                for x in some[1][name]
            )
    assert sum(map(len, graph_labels(graph).values())) == graph.report["labels_kept"]


def test_without_folders_the_embedded_clips_are_there_and_a_graph_is_built():
    app = make_app(Options(app="edit"))
    app.prepare(lambda share, text: None)
    page = Page()
    session = app.open(page)
    names = [clip.name for clip in synthetic_clips()[0]]
    assert page.last("clips")["names"] == names
    bench = app._bench
    assert bench is not None
    until_idle(bench)
    assert len(page.last("graph")["clips"]) == len(names)
    session.close()
    app.close()


def test_a_graph_folder_alone_is_shown_and_never_written(graph, tmp_path):
    save_graph(tmp_path / "graph", graph)
    before = (tmp_path / "graph" / "graph.safetensors").stat().st_mtime_ns
    app = make_app(Options(app="edit", graph=tmp_path / "graph"))
    app.prepare(lambda share, text: None)
    page = Page()
    session = app.open(page)
    assert page.last("graph")["sentence"].startswith("4 clips")
    session.receive({"type": "build", "threshold_m": 0.05, "keep": 0.9, "retarget": False})
    assert app._bench is not None
    until_idle(app._bench)
    assert (tmp_path / "graph" / "graph.safetensors").stat().st_mtime_ns == before
    app.close()


def test_what_is_not_there_is_said_at_the_start(some, tmp_path):
    clip = some[0][0]
    save_bvh(tmp_path / "one.bvh", clip.skeleton, clip.motion)
    (tmp_path / "labels.json").write_text(json.dumps({"clips": []}))
    for options, error in (
        (Options(app="edit", clips=tmp_path / "no"), "no such folder"),
        (Options(app="edit", clips=tmp_path), "labels.json"),
        (Options(app="edit", graph=tmp_path / "no"), "no graph"),
        (Options(app="edit", labels=tmp_path / "labels.json"), "--clips"),
    ):
        with pytest.raises(MgjaxError, match=error):
            make_app(options).prepare(lambda share, text: None)


def test_memory_has_no_folder(some):
    library = memory_library(some[0])
    assert library.folder is None
    book = LabelBook(library, None, some[1])
    with pytest.raises(ConfigError, match="no file"):
        book.save()
