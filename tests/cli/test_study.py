"""``mgjax study``: trials for observers, and what their picks say."""

from __future__ import annotations

import base64
import json
import zlib
from pathlib import Path

import numpy as np
import pytest

from mgjax.avoidance.attacks.json_file import load_attack
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.study.model import PARAMETERS
from mgjax.io.load import load_motion
from mgjax.io.toml_file import load_config
from tests.avoidance.study.made import drawn_measures, key_text, picks_of, picks_text
from tests.cli.conftest import Ran, refused, run

TRIALS = 3
TELLING = ("energy", "clearance", "library", "rank", "score", "part", "scales", "duck", "sway")
"""What no file for observers may mention."""


@pytest.fixture(scope="module")
def exported(built: tuple[Path, Ran], tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("study") / "study"
    ran = run("study", "export", "--graph", built[0], "--trials", TRIALS, "--out", out, "--json")
    assert ran.status == 0, ran.err
    assert ran.json["trials"] == TRIALS
    return out


def test_an_export_has_trials_and_a_key_beside_them(exported):
    assert {path.name for path in exported.iterdir()} == {"key.json", "for_observers"}
    key = json.loads((exported / "key.json").read_text())
    folders = sorted((exported / "for_observers" / "trials").iterdir())
    assert [folder.name for folder in folders] == ["01", "02", "03"]
    places: list[str] = []
    for folder, trial in zip(folders, key["trials"], strict=True):
        letters = [row["letter"] for row in trial["candidates"]]
        assert letters == list("ABCD")[: len(letters)]
        assert len(letters) >= 2
        assert len({row["part"] for row in trial["candidates"]}) == len(letters)
        names = {f"{letter}.bvh" for letter in letters} | {"index.html", "attack.json"}
        assert {path.name for path in folder.iterdir()} == names
        totals = {row["letter"]: row["energy"]["total"] for row in trial["candidates"]}
        assert trial["library"] == min(totals, key=totals.__getitem__)
        places.append(trial["library"])
        motions = [load_motion(folder / f"{letter}.bvh")[1] for letter in letters]
        assert len({motion.num_frames for motion in motions}) == 1
        assert load_attack(folder / "attack.json").radii.tolist() == trial["attack"]["radii"]
    assert len(set(places)) > 1, "the search's choice stands at no one place"


def test_nothing_is_given_away(exported):
    """Neither in text nor in the shows; their modules, which are the same in each, may say more."""
    observers = exported / "for_observers"
    for path in observers.rglob("*"):
        assert not any(word in path.name for word in TELLING), path
        if path.suffix in (".bvh", ".json"):
            assert not any(word in path.read_text().lower() for word in TELLING), path
        elif path.is_file() and path.parent != observers:
            page = path.read_text()
            packed = page.split('id="mgjax-payload"')[1].split(">", 1)[1].split("<")[0]
            data = zlib.decompress(base64.b64decode(packed))
            show = data[4 + int.from_bytes(data[:4], "little") :]
            assert b'"actors"' in show, "the show is read"
            assert not any(word.encode() in show.lower() for word in TELLING), path
            assert len(page) < 300_000
    index = (observers / "index.html").read_text()
    payload = json.loads(index.split('id="study-payload">')[1].split("</script>")[0])
    assert set(payload) == {"format", "study", "trials"}
    assert {name for row in payload["trials"] for name in row} == {"page", "letters"}


def test_the_same_seed_gives_the_same_study(built, exported, tmp_path):
    again = run("study", "export", "--graph", built[0], "--trials", 1, "--out", tmp_path / "a")
    assert again.status == 0
    keys = [json.loads((folder / "key.json").read_text()) for folder in (exported, tmp_path / "a")]
    assert keys[0]["trials"][0] == keys[1]["trials"][0]
    assert keys[0]["study"] != keys[1]["study"]


def test_an_export_that_cannot_be_is_refused(built, exported, tmp_path):
    graph = built[0]
    before = (exported / "key.json").read_bytes()
    refused(run("study", "export", "--graph", graph, "--out", exported), "has a study")
    assert (exported / "key.json").read_bytes() == before
    out = tmp_path / "out"
    for words in (("--trials", 0), ("--candidates", 1), ("--candidates", 9), ("--seed", -1)):
        refused(run("study", "export", "--graph", graph, "--out", out, *words), out=out)


def test_picks_of_an_export_are_scored(exported, tmp_path):
    key = json.loads((exported / "key.json").read_text())
    picks = ["ABCD".index(trial["library"]) for trial in key["trials"]]
    path = tmp_path / "picks.jsonl"
    path.write_text(picks_text(picks, "me", key["study"]))
    ran = run("study", "score", exported / "key.json", path, "--json")
    assert ran.status == 0, ran.err
    assert ran.json["agreement"]["share"] == 1.0
    assert ran.json["fit"]["status"] == "nothing to fit"
    assert ran.json["between_observers"] is None


def test_a_score_writes_settings_for_a_search(tmp_path):
    measured = drawn_measures(120, seed=0)
    (tmp_path / "key.json").write_text(key_text(measured))
    for name, seed in (("a", 1), ("b", 2)):
        picks = picks_of(measured, seed)
        (tmp_path / f"{name}.jsonl").write_text(picks_text(picks, name))
    files = [tmp_path / name for name in ("key.json", "a.jsonl", "b.jsonl")]
    out = tmp_path / "score"
    ran = run("study", "score", *files, "--out", out)
    assert ran.status == 0, ran.err
    assert {path.name for path in out.iterdir()} == {"score.json", "energy.toml"}
    result = json.loads((out / "score.json").read_text())
    settings = load_config(out / "energy.toml", AvoidanceConfig).energy
    for name in PARAMETERS:
        assert name in ran.out
        np.testing.assert_allclose(getattr(settings, name), result["fit"]["settings"][name])
    assert "between observers" in ran.out
    assert "a: the search agrees" in ran.out


def test_bad_picks_give_one_line(tmp_path):
    (tmp_path / "key.json").write_text(key_text(drawn_measures(2, seed=0)))
    path = tmp_path / "picks.jsonl"
    path.write_text(picks_text([0, 1], "a", "another"))
    out = tmp_path / "out"
    refused(
        run("study", "score", tmp_path / "key.json", path, "--out", out),
        *("picks.jsonl:1", "study 'another'"),
        out=out,
    )
    refused(run("study", "score", tmp_path / "none.json", "--out", out), "none.json", out=out)
    refused(run("study", "score", "--out", out), "no files", out=out)
