from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mgjax.clips.folder import load_clips
from mgjax.core.errors import FileFormatError, MotionError
from mgjax.io.bvh.write import save_bvh
from mgjax.io.gltf.write import save_glb
from mgjax.io.npz.write import save_npz
from tests.conftest import make_motion, make_skeleton

BODY = make_skeleton()


@pytest.fixture
def folder(tmp_path) -> Path:
    """Three clips in two folders, a fourth of another type, and files that are no clips."""
    (tmp_path / "b" / "deep").mkdir(parents=True)
    for i, name in enumerate(("z.bvh", "b/y.BVH", "b/deep/x.bvh")):
        save_bvh(tmp_path / name, BODY, make_motion(BODY, 6, seed=i))
    (tmp_path / "notes.txt").write_text("not a clip")
    (tmp_path / "b" / "labels.json").write_text("{}")
    (tmp_path / "folder.bvh").mkdir()
    return tmp_path


def names(folder: Path, **options) -> list[str]:
    return [clip.name for clip in load_clips(folder, **options)[0]]


def test_all_clips_in_the_order_of_their_paths(folder):
    clips, notes = load_clips(str(folder))
    assert [c.name for c in clips] == ["b/deep/x.bvh", "b/y.BVH", "z.bvh"]
    assert notes == []
    for clip, seed in zip(clips, (2, 1, 0), strict=True):
        want = make_motion(BODY, 6, seed=seed)
        np.testing.assert_allclose(clip.motion.root_translation, want.root_translation, atol=1e-5)
        assert set(BODY.names) >= {n for n in clip.skeleton.names if "end" not in n.lower()}


@pytest.mark.parametrize(
    ("exclude", "want"),
    [
        (["b/*"], ["z.bvh"]),
        (["*/x.bvh"], ["b/y.BVH", "z.bvh"]),
        (["*.bvh"], ["b/y.BVH"]),
        (["b/deep/*", "z*"], ["b/y.BVH"]),
        (["B/*", "x.bvh", "deep"], ["b/deep/x.bvh", "b/y.BVH", "z.bvh"]),
        (["[xyz].bvh"], ["b/deep/x.bvh", "b/y.BVH"]),
    ],
)
def test_excluded(folder, exclude, want):
    assert names(folder, exclude=exclude) == want


def test_other_formats_are_clips_and_other_arrays_are_none(folder):
    motion = make_motion(BODY, 6, seed=9)
    save_glb(folder / "a.glb", BODY, motion)
    save_npz(folder / "c.npz", BODY, make_motion(BODY, 6, seed=8))
    np.savez(folder / "volumes.npz", times=np.arange(3))
    clips, notes = load_clips(folder)
    assert [c.name for c in clips] == ["a.glb", "b/deep/x.bvh", "b/y.BVH", "c.npz", "z.bvh"]
    assert not [note for note in notes if "volumes" in note]
    np.testing.assert_array_equal(clips[0].motion.local_rotations, motion.local_rotations)
    (folder / "volumes.npz").write_bytes(b"PK damaged")
    with pytest.raises(FileFormatError, match=r"volumes\.npz: got no \.npz archive"):
        load_clips(folder)


def test_the_second_of_two_clips_with_one_motion_is_left_out(folder):
    shutil.copy(folder / "z.bvh", folder / "b" / "copy.bvh")
    clips, notes = load_clips(folder)
    assert [c.name for c in clips] == ["b/copy.bvh", "b/deep/x.bvh", "b/y.BVH"]
    assert notes == ["z.bvh: left out, its motion is that of b/copy.bvh"]


def test_a_preferred_one_stays_of_two_with_one_motion(folder):
    shutil.copy(folder / "z.bvh", folder / "b" / "copy.bvh")
    clips, notes = load_clips(folder, prefer=["z.bvh"])
    assert [c.name for c in clips] == ["b/deep/x.bvh", "b/y.BVH", "z.bvh"]
    assert notes == ["b/copy.bvh: left out, its motion is that of z.bvh"]


def test_reading_is_watched(folder):
    told: list[float] = []
    clips, _ = load_clips(folder, watch=told.append)
    assert told == [n / len(clips) for n in range(len(clips))]


def test_a_frame_time_with_fewer_digits_is_no_other_motion(folder):
    text = (folder / "z.bvh").read_text()
    line = next(x for x in text.splitlines() if x.startswith("Frame Time"))
    (folder / "zz.bvh").write_text(text.replace(line, "Frame Time: 0.00833"))
    assert names(folder) == ["b/deep/x.bvh", "b/y.BVH", "z.bvh"]
    (folder / "zz.bvh").write_text(text.replace(line, "Frame Time: 0.0333333"))
    assert names(folder)[-1] == "zz.bvh"


def test_motions_that_differ_a_little_both_stay(folder):
    motion = make_motion(BODY, 6, seed=0)
    moved = motion.root_translation.copy()
    moved[3, 0] += 0.002
    save_bvh(folder / "zz.bvh", BODY, replace(motion, root_translation=moved))
    turned = motion.local_rotations.copy()
    turned[2, 4] = turned[2, 4] * np.cos(0.02) + np.roll(turned[2, 4], 1) * np.sin(0.02)
    turned[2, 4] /= np.linalg.norm(turned[2, 4])
    save_bvh(folder / "zzz.bvh", BODY, replace(motion, local_rotations=turned))
    assert names(folder)[-3:] == ["z.bvh", "zz.bvh", "zzz.bvh"]


def test_nothing_to_load(folder, tmp_path):
    with pytest.raises(MotionError, match=r"nowhere: got no such folder"):
        load_clips(tmp_path / "nowhere")
    with pytest.raises(MotionError, match=r"got no such folder"):
        load_clips(folder / "z.bvh")
    (tmp_path / "empty").mkdir()
    for options in ({"folder": tmp_path / "empty"}, {"folder": folder, "exclude": ["*"]}):
        with pytest.raises(MotionError, match=r"got no clip, expected \.bvh or .* \.npz files"):
            load_clips(**options)


def test_a_broken_file_is_named(folder):
    text = (folder / "b" / "y.BVH").read_text()
    (folder / "b" / "y.BVH").write_text(text.replace("HIERARCHY", "HIGHERARCHY"))
    with pytest.raises(FileFormatError, match=r"y\.BVH"):
        load_clips(folder)
    assert names(folder, exclude=["b/y*"]) == ["b/deep/x.bvh", "z.bvh"]


def test_a_bar_is_shown(folder, capsys):
    load_clips(folder)
    assert capsys.readouterr().err == ""
    load_clips(folder, progress=True)
    assert "reading" in capsys.readouterr().err


def test_real_capture(capture):
    clips, notes = load_clips(capture / "avoidance" / "cmu49")
    assert clips
    assert notes == []
    assert [c.name for c in clips] == sorted(c.name for c in clips)
    assert all(c.name.endswith(".amc") and c.motion.frame_rate == 120 for c in clips)


def test_links_to_folders_are_followed_and_each_folder_counts_once(folder, tmp_path_factory):
    """A folder elsewhere, a second way to one that is here, and a link back to the top."""
    other = tmp_path_factory.mktemp("other")
    (other / "deeper").mkdir()
    save_bvh(other / "deeper" / "w.bvh", BODY, make_motion(BODY, 6, seed=7))
    (other / "deeper" / "top").symlink_to(folder, target_is_directory=True)
    (folder / "a").symlink_to(folder / "b", target_is_directory=True)
    (folder / "b" / "up").symlink_to(folder, target_is_directory=True)
    (folder / "linked").symlink_to(other, target_is_directory=True)
    (folder / "nowhere").symlink_to(folder / "nothing", target_is_directory=True)
    (folder / "itself").symlink_to(folder / "itself", target_is_directory=True)
    assert names(folder) == ["b/deep/x.bvh", "b/y.BVH", "linked/deeper/w.bvh", "z.bvh"]
    # The folder itself may be a link, too.
    link = tmp_path_factory.mktemp("links") / "clips"
    link.symlink_to(folder, target_is_directory=True)
    assert names(link) == names(folder)


def test_home(folder, monkeypatch):
    monkeypatch.setenv("HOME", str(folder))
    assert names("~/b") == ["deep/x.bvh", "y.BVH"]
