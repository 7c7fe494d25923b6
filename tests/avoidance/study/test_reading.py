"""Files of a study: read back as they were, or refused with their line."""

from __future__ import annotations

import json

import numpy as np
import pytest

from mgjax.avoidance.study.format import FORMAT, pick_line
from mgjax.avoidance.study.reading import read_study
from mgjax.core.errors import MgjaxError
from tests.avoidance.study.made import drawn_measures, key_text, picks_text, record_of

MEASURED = drawn_measures(3, seed=0)


@pytest.fixture
def key(tmp_path):
    path = tmp_path / "key.json"
    path.write_text(key_text(MEASURED))
    return path


def test_a_key_and_picks_are_read_in_any_order(key, tmp_path):
    paths = []
    for name, picks in (("a", [0, 1, 0]), ("b", [1, 1, 1])):
        paths.append(tmp_path / f"{name}.jsonl")
        paths[-1].write_text(picks_text(picks, name))
    study = read_study([paths[0], key, paths[1]])
    assert list(study.trials) == ["1", "2", "3"]
    for known, candidates in zip(study.trials.values(), MEASURED, strict=True):
        np.testing.assert_allclose(known.measures, candidates)
    assert [(p.observer, p.trial, p.place) for p in study.picks][:3] == [
        ("a", "1", 0),
        ("a", "2", 1),
        ("a", "3", 0),
    ]
    assert len(study.picks) == 6


def test_picks_of_the_live_page_carry_their_trials(tmp_path):
    """Measures of a body of another size are those of an adult."""
    path = tmp_path / "picks.jsonl"
    lines = [
        pick_line(record_of(candidates, number, scale=0.5), "B", "me")
        for number, candidates in enumerate(MEASURED, 1)
    ]
    path.write_text("\n".join(lines) + "\n")
    study = read_study([path])
    assert [p.place for p in study.picks] == [1, 1, 1]
    for known, candidates in zip(study.trials.values(), MEASURED, strict=True):
        np.testing.assert_allclose(known.measures, candidates)


def line(**changes) -> str:
    record = {"format": FORMAT, "study": "one", "trial": 1, "observer": "a", "pick": "A"}
    return json.dumps(record | changes) + "\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (line(study="other"), ("picks.jsonl:1", "study 'other'", "study 'one'")),
        (line(trial=9), ("picks.jsonl:1", "trial 9", "1 … 3")),
        (line(trial=1.5), ("picks.jsonl:1", "trial 1.5")),
        (line() + line(trial=2, pick="Z"), ("picks.jsonl:2", "pick 'Z'", "one of A, B")),
        (line(trial=2, pick="AB"), ("picks.jsonl:1", "pick 'AB'")),
        (line(observer=" "), ("picks.jsonl:1", "observer")),
        (line(format="mgjax-study-1"), ("picks.jsonl:1", "format 'mgjax-study-1'", FORMAT)),
        (line() + line(pick="B"), ("picks.jsonl:2", "trial 1 picked twice by 'a'")),
        (line() + "{broken\n", ("picks.jsonl:2", "no JSON")),
        ("[1, 2]\n", ("picks.jsonl:1", "a list of 2")),
        ("\n", ("an empty file",)),
    ],
)
def test_picks_that_do_not_fit_are_refused(key, tmp_path, text, words):
    path = tmp_path / "picks.jsonl"
    path.write_text(text)
    with pytest.raises(MgjaxError) as error:
        read_study([key, path])
    for word in words:
        assert word in str(error.value)


def test_picks_need_their_key(tmp_path):
    path = tmp_path / "picks.jsonl"
    path.write_text(line())
    with pytest.raises(MgjaxError, match=r"picks\.jsonl:1: got a pick without its trial"):
        read_study([path])


def test_a_key_alone_or_two_are_refused(key, tmp_path):
    with pytest.raises(MgjaxError, match="no picks"):
        read_study([key])
    other = tmp_path / "other.json"
    other.write_text(key.read_text())
    with pytest.raises(MgjaxError, match="2 keys"):
        read_study([key, other])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda trial: trial["candidates"][0].pop("energy"), "without energy"),
        (lambda trial: trial["candidates"][0]["energy"].update(d="x"), "d 'x' in trial 1"),
        (lambda trial: trial["candidates"][0].update(time_scale=-1), "time_scale -1"),
        (lambda trial: trial.update(candidates=[]), "candidates an empty list"),
        (lambda trial: trial.update(body_scale=0), "body_scale 0"),
        (lambda trial: trial.update(library="H"), "library 'H'"),
        (lambda trial: trial["settings"].update(E_time=0.1), "E_time"),
        (lambda trial: trial["settings"].update(form="odd"), "form"),
        (lambda trial: trial["settings"].update(D_move=0.5), "D_move = 0.5 and 0.3"),
        (lambda trial: trial.update(trial=7), "out of order"),
    ],
)
def test_damaged_keys_are_refused(key, tmp_path, change, words):
    document = json.loads(key.read_text())
    change(document["trials"][0])
    key.write_text(json.dumps(document))
    path = tmp_path / "picks.jsonl"
    path.write_text(line())
    with pytest.raises(MgjaxError, match=words):
        read_study([key, path])
