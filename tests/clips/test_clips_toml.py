from __future__ import annotations

from pathlib import Path

import pytest

from mgjax.clips.clips_toml import ClipsToml, over
from mgjax.clips.folder import load_clips
from mgjax.core.errors import ConfigError, FileFormatError, MotionError
from mgjax.io.reading.read_as import ReadAs
from tests.io.reading.made import Maker, walk, write


def test_later_and_deeper_rules_count_more(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "clips.toml").write_text(
        'units = "in"\nfloor = "keep"\n["deep/*"]\nup = "z"\nunits = "cm"\n'
        '["*_60.bvh"]\nframe_rate = 60\n'
    )
    (tmp_path / "deep" / "clips.toml").write_text('roles = { head = "Skull" }\nup = "x"\n')
    known = ClipsToml(tmp_path)
    assert known.of(tmp_path / "a.bvh") == ReadAs(units="in", floor="keep")
    assert known.of(tmp_path / "b_60.bvh") == ReadAs(units="in", floor="keep", frame_rate=60)
    assert known.of(tmp_path / "deep" / "c.bvh") == ReadAs(
        units="cm", floor="keep", up="x", roles=(("head", "Skull"),)
    )
    assert over(known.of(tmp_path / "a.bvh"), ReadAs(units="m")).units == "m"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('unit = "cm"', "'unit'"),
        ('units = "cubit"', "'cubit'"),
        ("units = 3", "units = 3"),
        ('["*"]\nup = "w"', "'w'"),
        ('roles = { wing = "x" }', "'wing'"),
        ("roles = { head = 3 }", "joint names"),
        ("frame_rate = 0", "frame rate is 0"),
        ('floor = "deep"', "'deep'"),
    ],
)
def test_what_means_nothing_is_refused(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "clips.toml").write_text(text)
    with pytest.raises(ConfigError, match=words) as error:
        ClipsToml(tmp_path)
    assert str(tmp_path / "clips.toml") in str(error.value)


def test_no_toml(tmp_path: Path) -> None:
    (tmp_path / "clips.toml").write_text("units =")
    with pytest.raises(FileFormatError, match=r"clips\.toml: got no TOML"):
        ClipsToml(tmp_path)


def test_clips_are_read_as_it_says(tmp_path: Path) -> None:
    skeleton, motion = walk(20)
    write(tmp_path / "a.bvh", skeleton, motion, Maker())
    write(tmp_path / "b.bvh", skeleton, motion, Maker(floor=1.0))
    (tmp_path / "clips.toml").write_text('["b.bvh"]\nfloor = 0.5\n')
    (a, b), notes = load_clips(tmp_path)
    assert a.reading["said"] == {}
    assert b.reading["said"] == {"floor": 0.5}
    assert b.reading["floor_m"] == 0.5
    assert b.motion.root_translation[0, 1] - a.motion.root_translation[0, 1] == pytest.approx(
        0.5, abs=1e-4
    )
    assert notes == []


def test_all_bad_files_are_named_or_left_out(tmp_path: Path) -> None:
    skeleton, motion = walk(20)
    write(tmp_path / "good.bvh", skeleton, motion, Maker())
    for name in ("one", "two"):
        (tmp_path / f"{name}.bvh").write_text("HIERARCHY\nROOT\n")
    with pytest.raises(MotionError, match=r"2 of 3 files: .*one\.bvh:2: .*; .*two\.bvh:2: "):
        load_clips(tmp_path)
    clips, notes = load_clips(tmp_path, skip_bad=True)
    assert [clip.name for clip in clips] == ["good.bvh"]
    assert sum(note.startswith("left out: ") for note in notes) == 2


def test_bodies_of_no_person_are_refused_unless_told(tmp_path: Path) -> None:
    skeleton, motion = walk(20)
    write(tmp_path / "giant.bvh", skeleton, motion, Maker(scale=165.0))
    with pytest.raises(FileFormatError, match=r"2\.6\d m in the centimetre"):
        load_clips(tmp_path, need_body=True)
    clips, _ = load_clips(tmp_path, need_body=True, read_as=ReadAs(units="cm"))
    assert clips[0].reading["height_m"] == pytest.approx(1.65 * 1.63, rel=0.02)
