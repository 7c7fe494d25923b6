"""``mgjax quality``."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from mgjax.quality.result import FIGURES
from tests.cli.conftest import refused, run

PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def written(clips_folder: Path, tmp_path: Path) -> Path:
    """A motion with a result beside it."""
    folder = tmp_path / "result"
    folder.mkdir()
    shutil.copy(clips_folder / "duck.bvh", folder / "motion.bvh")
    seams = [{"start_s": 0.5, "end_s": 0.8}]
    (folder / "result.json").write_text(json.dumps({"seams": seams}))
    return folder / "motion.bvh"


def test_beside_capture(written: Path, clips_folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    ran = run(
        *("quality", written, "--against", clips_folder / "duck.bvh"),
        *(clips_folder / "sway.bvh", "--out", out, "--json"),
    )
    assert (ran.status, ran.err) == (0, "")
    (row,) = ran.json["files"]
    assert json.loads((out / "quality.json").read_text()) == ran.json
    assert (row["file"], row["notes"]) == (str(written), [])
    assert set(row["figures"]) == set(row["capture"]) == set(FIGURES)
    assert row["figures"]["limits"] == pytest.approx(0, abs=1e-2)  # it is one of the capture
    assert row["seams"] == [{"start_s": 0.5, "end_s": 0.8}]
    assert row["at_seams"]["velocity_jump"] <= row["figures"]["velocity_jump"]
    assert {"p50", "p95"} == set(row["capture"]["skate_cm"])
    assert (out / "motion.png").read_bytes().startswith(PNG)
    text = run("quality", written, "--against", clips_folder / "duck.bvh")
    assert text.status == 0
    assert text.out.count("\n") == 2 + len(FIGURES)
    for words in ("at seams", "capture p50", "slide of toes and ankles"):
        assert words in text.out


def test_alone_and_several(clips_folder: Path, tmp_path: Path) -> None:
    files = [clips_folder / "duck.bvh", clips_folder / "sway.bvh"]
    ran = run("quality", *files, "--json", "--out", tmp_path / "out")
    assert ran.status == 0
    assert [row["file"] for row in ran.json["files"]] == [str(path) for path in files]
    for row in ran.json["files"]:
        assert (row["capture"], row["at_seams"]) == ({}, {})
        assert row["figures"]["jerky"] is None
        assert row["figures"]["skate_cm"] >= 0
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"quality.json", "000_duck.png", "001_sway.png"}


def test_bad_input(written: Path, clips_folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    refused(run("quality", tmp_path / "none.bvh", "--out", out), "none.bvh", out=out)
    refused(run("quality", tmp_path / "a.txt", "--out", out), "a.txt", out=out)
    (written.parent / "result.json").write_text('{"seams": [{"start_s": "x"}]}')
    refused(run("quality", written, "--out", out), "result.json:1", "seam", out=out)
    (written.parent / "result.json").unlink()
    text = (clips_folder / "sway.bvh").read_text()
    other = tmp_path / "other.bvh"
    other.write_text(text.replace(text.split("JOINT ")[1].split()[0], "elsewhere"))
    against = ("--against", clips_folder / "duck.bvh", other)
    refused(run("quality", written, *against, "--out", out), "two skeletons", out=out)
    head, body = text.split("MOTION")
    lines = body.strip().split("\n")
    one = tmp_path / "one.bvh"
    one.write_text("\n".join([head + "MOTION", "Frames: 1", lines[1], lines[2], ""]))
    refused(run("quality", one, "--out", out), "one.bvh", "1 frames", out=out)
