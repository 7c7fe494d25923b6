"""Scenes from TOML files."""

from __future__ import annotations

from dataclasses import MISSING, fields, replace
from pathlib import Path
from typing import Any, TypeVar

from mgjax.ballsport.ball.physics import Net
from mgjax.ballsport.scene.config import Pass, Player, SceneConfig, validate_scene
from mgjax.core.errors import ConfigError, printable
from mgjax.io.settings import changed
from mgjax.io.toml_file import read_toml

T = TypeVar("T")


def load_scene(path: str | Path) -> SceneConfig:
    """Reads and checks a scene: ``[[players]]``, ``[[passes]]``, and what else is set.

    Raises:
        FileFormatError: no TOML.
        ConfigError: an unknown key (the nearest known one is named), a value of another type or out
            of range, or a scene that cannot be begun.
    """
    place = printable(path)
    _, document = read_toml(path)
    try:
        config = _structured(document, place)
        validate_scene(config)
    except ConfigError as error:
        if error.place:
            raise
        raise ConfigError(str(error), place=place) from None
    return config


def _structured(document: dict[str, Any], place: str) -> SceneConfig:
    config = SceneConfig()
    for key, value in document.items():
        if key == "players":
            players = _rows(value, Player(name="", x=0.0, z=0.0), "players", place)
            config = replace(config, players=players)
        elif key == "passes":
            config = replace(config, passes=_rows(value, Pass(by="", to=""), "passes", place))
        elif key == "net":
            config = replace(config, net=_filled(Net(), value, f"{place}: net"))
        else:
            config = changed(config, key, value, place)
    return config


def _rows(tables: Any, empty: T, name: str, place: str) -> tuple[T, ...]:
    """One object for each table ``[[name]]``, begun from an empty one."""
    if not isinstance(tables, list):
        raise ConfigError(got=f"{name} = {tables!r}", expected=f"tables [[{name}]]", place=place)
    rows: list[T] = []
    for number, table in enumerate(tables, 1):
        where = f"{place}: {name} {number}"
        row = _filled(empty, table, where)
        needed = [f.name for f in fields(empty) if f.default is MISSING]  # pyright: ignore
        for key in needed:
            if key not in table:
                raise ConfigError(got=f"no {key}", expected=", ".join(needed), place=where)
        rows.append(row)
    return tuple(rows)


def _filled(value: T, table: Any, where: str) -> T:
    if not isinstance(table, dict):
        raise ConfigError(got=f"{table!r}", expected="a table", place=where)
    for key, item in table.items():
        value = changed(value, key, item, where)
    return value
