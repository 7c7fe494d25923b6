"""``~`` in paths, wherever they are written."""

from __future__ import annotations

from pathlib import Path

import pytest

from mgjax.cli.arguments import Info, Replay, Sensor
from mgjax.cli.main import with_user_paths
from mgjax.clips.clips_toml import read_as_from
from mgjax.io.user_path import user_path


def test_home(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/of/somebody")
    assert user_path("~/clips") == Path("/home/of/somebody/clips")
    assert user_path("clips/~") == Path("clips/~")
    assert user_path("~nobody-of-this-name/a") == Path("~nobody-of-this-name/a")


def test_files(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/of/somebody")
    read_as = read_as_from({"asf": "~/a.asf"}, Path("clips/clips.toml"))
    assert read_as.asf == Path("/home/of/somebody/a.asf")
    assert read_as_from({"asf": "a.asf"}, Path("clips/clips.toml")).asf == Path("clips/a.asf")


def test_arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    """In tuples, in commands of commands, and nowhere else."""
    monkeypatch.setenv("HOME", "/home/of/somebody")
    info = with_user_paths(Info(files=(Path("~/a.bvh"), Path("b.bvh")), out=Path("~")))
    assert info.files == (Path("/home/of/somebody/a.bvh"), Path("b.bvh"))
    assert info.out == Path("/home/of/somebody")
    sensor = with_user_paths(Sensor(action=Replay(file=Path("~/a.bvh"), host="~")))
    assert isinstance(sensor.action, Replay)
    assert sensor.action.file == Path("/home/of/somebody/a.bvh")
    assert (sensor.action.host, sensor.action.out) == ("~", None)
