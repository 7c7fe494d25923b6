from __future__ import annotations

import json
import shutil
from pathlib import Path

from mgjax.clips.synthetic import synthetic_clips
from mgjax.graph.files import load_graph
from mgjax.io.bvh.write import save_bvh
from tests.cli.conftest import refused, run
from tests.clips.retarget.bodies import mixamo, xsens


def folder_of_three(clips_folder: Path, folder: Path) -> Path:
    """A clip of the package's body, one with Mixamo's names, one with MVN's."""
    folder.mkdir()
    shutil.copy(clips_folder / "steps.bvh", folder / "a_steps.bvh")
    made = {clip.name: clip for clip in synthetic_clips()[0]}
    for name, clip in (("mixamo", mixamo(made["walk"])), ("xsens", xsens(made["walk_curve"]))):
        save_bvh(folder / f"{name}.bvh", clip.skeleton, clip.motion)
    return folder


def test_build_puts_other_skeletons_on_the_first(clips_folder: Path, tmp_path: Path) -> None:
    clips = folder_of_three(clips_folder, tmp_path / "clips")
    settings = tmp_path / "graph.toml"
    settings.write_text("threshold_m = 0.12\n")
    out = tmp_path / "graph"
    words = ("build", "--clips", clips, "--config", settings, "--out", out, "--no-index")
    refused(run(*words), "mixamo.bvh", "'mixamorig:Hips'", "'root'", "--retarget", out=out)
    ran = run(*words, "--retarget", "--json")
    assert ran.status == 0, ran.err
    rows = ran.json["retargeted"]
    assert [row["clip"] for row in rows] == ["mixamo.bvh", "xsens.bvh"]
    assert all(row["foot_slide_after_m"] <= row["foot_slide_before_m"] + 1e-6 for row in rows)
    assert json.loads((out / "build.json").read_text())["retargeted"] == rows
    notes = [note for note in ran.json["notes"] if "put on the skeleton" in note]
    assert [note.split(":")[0] for note in notes] == ["mixamo.bvh", "xsens.bvh"]
    graph = load_graph(out)
    assert set(graph.clip_names) == {"a_steps.bvh", "mixamo.bvh", "xsens.bvh"}
    assert graph.report["retargeted"] == rows


def test_the_switch_may_stand_in_the_settings(clips_folder: Path, tmp_path: Path) -> None:
    clips = folder_of_three(clips_folder, tmp_path / "clips")
    settings = tmp_path / "graph.toml"
    settings.write_text("threshold_m = 0.12\nretarget = true\n")
    words = ("build", "--clips", clips, "--config", settings, "--no-index", "--json")
    ran = run(*words, "--out", tmp_path / "graph", "--skeleton", clips / "xsens.bvh")
    assert ran.status == 0, ran.err
    assert [row["clip"] for row in ran.json["retargeted"]] == ["a_steps.bvh", "mixamo.bvh"]
    assert "Pelvis" in load_graph(tmp_path / "graph").skeleton.names
