from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace

import pytest

from mgjax.core.errors import ConfigError, FileFormatError
from mgjax.io.settings import changed
from mgjax.io.toml_file import to_toml
from mgjax.runs.experiment import execute
from mgjax.runs.settings import describe, resolve
from tests.runs.toys import Config, Inner, names, simple, toy


def test_settings_in_their_order(tmp_path):
    file = tmp_path / "a.toml"
    file.write_text("balls = 7\nname = 'file'\nspeeds = [3]\n[inner]\nwidth = 2\nform = 'square'\n")
    config = resolve(Config, file)
    assert config == Config(
        balls=7, name="file", speeds=(3.0,), inner=Inner(width=2.0, form="square")
    )
    assert isinstance(config.speeds[0], float)
    config = resolve(Config, file, smoke=True)
    assert (config.balls, config.inner.width, config.inner.form) == (1, 0.5, "square")
    config = resolve(Config, file, smoke=True, settings=["balls=9", "balls=3", "inner.width=8"])
    assert (config.balls, config.inner.width, config.name) == (3, 8.0, "file")


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("name=a b", "name", "a b"),
        ("name='a'", "name", "a"),
        ("name=2012", "name", "2012"),
        ("name=a=b", "name", "a=b"),
        ("name=1\nballs = 3", "name", "1\nballs = 3"),
        ("name=", "name", ""),
        (" balls = 3 ", "balls", 3),
        ("limit=3", "limit", 3.0),
        ("limit=-inf", "limit", -math.inf),
        ("quick=true", "quick", True),
        ("speeds=[]", "speeds", ()),
        ("speeds=[1, 2.5]", "speeds", (1.0, 2.5)),
        ("pair=[2, 'b']", "pair", (2, "b")),
        ("maybe=2", "maybe", 2.0),
        ("joints={a = 1}", "joints", {"a": 1.0}),
        ("either=limbs", "either", "limbs"),
        ("either={a = 1, b = 0.5}", "either", {"a": 1.0, "b": 0.5}),
        ("inner={width = 3}", "inner", Inner(width=3.0)),
    ],
)
def test_single_settings(text, key, value):
    found = getattr(resolve(Config, settings=[text]), key)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("bals=3", "unknown key 'bals', expected one such as 'balls'"),
        ("inner.wdth=3", "unknown key 'inner.wdth', expected one such as 'inner.width'"),
        ("inner={wdth = 3}", "unknown key 'inner.wdth'"),
        ("smoke=3", "unknown key 'smoke'"),
        ("balls.x=3", "expected no more than 'balls'"),
        ("balls", "got 'balls', expected key=value"),
        ("=3", "unknown key ''"),
        ("balls=2.5", "got balls = 2.5, expected a whole number"),
        ("balls=true", "got balls = True, expected a whole number"),
        ("balls=many", "got balls = 'many', expected a whole number"),
        ("limit=wide", "got limit = 'wide', expected a number"),
        ("quick=1", "got quick = 1, expected true or false"),
        ("speeds=3", "expected a list in brackets"),
        ("speeds=['a']", "expected a list, each of it a number"),
        ("pair=[1]", "expected a list of 2"),
        ("maybe=x", "got maybe = 'x', expected a number"),
        ("joints=3", "got joints = 3, expected a table"),
        ("joints={a = 'x'}", "expected a number"),
        ("either=[1]", "expected a word or a table"),
        ("inner=3", "got inner = 3, expected a table"),
        ("inner.form=oval", "got inner.form = 'oval', expected 'round' or 'square'"),
    ],
)
def test_bad_settings(text, message, tmp_path, capsys):
    with pytest.raises(ConfigError, match=re.escape(message)):
        resolve(Config, settings=[text])
    status = execute(simple, Config, ["--set", text, "--out", str(tmp_path / "out")])
    captured = capsys.readouterr()
    assert status == 2
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert message in captured.err
    assert names(tmp_path) == []


@pytest.mark.parametrize(
    "text",
    [
        "bals = 3",
        "balls = 'x'",
        "speeds = 'abc'",
        "words = 'abc'",
        "maybe = '3'",
        "speeds = [true]",
        "[inner]\nwidht = 3",
        "inner = 3",
        "balls = ",
        "",
        "smoke = 3",
    ],
)
def test_bad_files(text, tmp_path, capsys):
    file = tmp_path / "bad.toml"
    file.write_text(text)
    with pytest.raises((ConfigError, FileFormatError), match=r"bad\.toml"):
        resolve(Config, file)
    assert execute(simple, Config, ["--config", str(file), "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert names(tmp_path) == ["bad.toml"]


def test_bad_arguments(tmp_path, capsys):
    for arguments in (["--frob"], ["x"], ["--config"], ["--config", str(tmp_path / "none.toml")]):
        assert execute(simple, Config, arguments) == 2
        assert capsys.readouterr().err.count("\n") == 1
    with pytest.raises(ConfigError, match="tiny version"):
        resolve(Inner, smoke=True)


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"name": 'a "quoted"\n\ttext \\ \x7f \x01 ü 😀', "limit": 1e-7},
        {"joints": {"a b": 1.0, "": 2e22}, "either": {"ü": 0.1}, "words": ("x", "")},
        {"maybe": 0.1 + 0.2, "inner": Inner(width=-math.inf, form="square"), "quick": True},
    ],
)
def test_toml_there_and_back(settings, tmp_path):
    config = replace(Config(), **settings)
    file = tmp_path / "config.toml"
    file.write_text(to_toml(config), encoding="utf-8")
    assert resolve(Config, file) == config


def test_none_must_be_the_default():
    @dataclass(frozen=True, kw_only=True)
    class Odd:
        x: float | None = 1.0

    assert to_toml(Odd(x=2.0)) == "x = 2.0\n"
    with pytest.raises(ConfigError, match="None"):
        to_toml(Odd(x=None))


def test_help(capsys):
    text = describe(Config)
    assert "balls = 4: How many." in text
    assert "speeds = [1.0, 2.0]: Speeds, m/s." in text
    assert "  maybe\n" in text
    with pytest.raises(SystemExit) as stop:
        execute(toy, Config, ["--help"])
    assert stop.value.code == 0
    assert "inner.…" in capsys.readouterr().out


def test_changed_places():
    with pytest.raises(ConfigError, match=r"^here: got balls"):
        changed(Config(), "balls", "x", "here")
