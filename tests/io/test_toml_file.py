from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest

from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig, SpeedConfig
from mgjax.core.errors import ConfigError, FileFormatError
from mgjax.graph.config import GraphConfig
from mgjax.io.toml_file import load_config

ROOT = Path(__file__).resolve().parent.parent.parent


def toml(table: dict[str, Any]) -> str:
    """Enough TOML for settings; nested tables come last."""
    lines = []
    nested = {k: v for k, v in table.items() if isinstance(v, dict)}
    for key, value in table.items():
        if value is not None and key not in nested:
            lines.append(f"{key} = {str(value).lower() if value in (True, False) else repr(value)}")
    for key, value in nested.items():
        lines += [f"[{key}]", toml(value)]
    return "\n".join(lines)


CHANGED = [
    GraphConfig(),
    GraphConfig(threshold_m=0.1, keep=0.5, mirror=True, neighbourhood=3, weights="limbs"),
    GraphConfig(normalised=0.3, weights={"root": 1.0, "lfemur": 2.5}, clean_feet=False),
    AvoidanceConfig(),
    AvoidanceConfig(
        energy=EnergyConfig(form="paper", d0="paper", E_avoidance=0.5, w_t=0.0),
        speed=SpeedConfig(V_slow=0.1, V_still=0.0),
        limit_scale=False,
        capacity=100,
    ),
    EnergyConfig(D_body=0.1),
    SpeedConfig(V_fast=1.0),
]


@pytest.mark.parametrize("config", CHANGED, ids=lambda c: type(c).__name__)
def test_round_trip(tmp_path: Path, config: Any) -> None:
    path = tmp_path / "config.toml"
    path.write_text("# settings\n" + toml(dataclasses.asdict(config)) + "\n")
    assert load_config(path, type(config)) == config


def test_empty_tables_are_defaults(tmp_path: Path) -> None:
    path = tmp_path / "config.toml"
    path.write_text("# nothing\n")
    assert load_config(path, AvoidanceConfig) == AvoidanceConfig()
    path.write_text("[energy]\n[speed]\nV_fast = 1\n")
    got = load_config(path, AvoidanceConfig)
    assert got == AvoidanceConfig(speed=SpeedConfig(V_fast=1.0))
    assert isinstance(got.speed.V_fast, float)  # whole numbers are numbers


BAD: list[tuple[type, str, str]] = [
    (GraphConfig, "keepp = 1", r"toml:1: got unknown key 'keepp', expected one such as 'keep' "),
    (GraphConfig, "\n\nkeep = 'x'", r"toml:3: got keep = 'x', expected a number"),
    (GraphConfig, "keep = true", r"toml:1: got keep = True, expected a number"),
    (GraphConfig, "keep = [1]", r"toml:1: got keep = \[1\], expected a number"),
    (GraphConfig, "threshold_m = 'x'", r"threshold_m = 'x', expected a number"),
    (GraphConfig, "neighbourhood = 2.0", r"neighbourhood = 2.0, expected a whole number"),
    (GraphConfig, "neighbourhood = false", r"expected a whole number"),
    (GraphConfig, "clean_feet = 'no'", r"clean_feet = 'no', expected true or false"),
    (GraphConfig, "weights = 3", r"expected a word or a table of numbers"),
    (GraphConfig, "[weights]\nroot = 'x'", r"toml:1: .*expected a word or a table of numbers"),
    (AvoidanceConfig, "energy = 1", r"toml:1: got energy = 1, expected a table"),
    (AvoidanceConfig, "capacity = '9'", r"toml:1: got capacity = '9', expected a whole number"),
    (
        AvoidanceConfig,
        "capacity = 9\n[speed]\nV_fats = 1",
        r"toml:3: got unknown key 'speed.V_fats', expected one such as 'V_fast'",
    ),
    (AvoidanceConfig, "[energy]\nform = 3", r"toml:2: .*energy.form = 3, expected 'paper' or"),
    (AvoidanceConfig, "[energy]\nD_body = 'x'", r"toml:2: got energy.D_body = 'x', expected a num"),
    (AvoidanceConfig, "[enrgy]\nD_body = 1", r"toml:1: got unknown key 'enrgy', .*'energy'"),
    (
        AvoidanceConfig,
        "# checks are few\ncapacity = 1\nchecks = 0.5",
        r"toml:3: got checks = 0.5",
    ),
]


@pytest.mark.parametrize(("kind", "text", "message"), BAD, ids=lambda x: str(x)[:30])
def test_bad_settings(tmp_path: Path, kind: type, text: str, message: str) -> None:
    path = tmp_path / "settings.toml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=message) as caught:
        load_config(path, kind)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "line"),
    [("keep 1", 1), ("keep = 1\nwindow_s = = 2", 2), ("keep = 1\n\n[x", 3), ("a = '", 1)],
)
def test_no_toml(tmp_path: Path, text: str, line: int) -> None:
    path = tmp_path / "settings.toml"
    path.write_text(text)
    with pytest.raises(FileFormatError, match="TOML") as caught:
        load_config(path, GraphConfig)
    assert caught.value.line in (line, None)
    assert "\n" not in str(caught.value)


def test_files_that_are_no_text(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=r"none\.toml"):
        load_config(tmp_path / "none.toml", GraphConfig)
    (tmp_path / "binary.toml").write_bytes(b"\0\1\2")
    with pytest.raises(FileFormatError, match="binary"):
        load_config(tmp_path / "binary.toml", GraphConfig)
    (tmp_path / "deep.toml").write_text("a = " + "[" * 5000)
    with pytest.raises(FileFormatError, match="TOML"):
        load_config(tmp_path / "deep.toml", GraphConfig)


@pytest.mark.parametrize(
    "name", ["graph/default", "graph/paper", "avoidance/default", "avoidance/paper"]
)
def test_configs_that_come_along(name: str) -> None:
    kind = {"graph": GraphConfig, "avoidance": AvoidanceConfig}[name.split("/")[0]]
    config = load_config(ROOT / "configs" / f"{name}.toml", kind)
    assert (config == kind()) == name.endswith("default")
