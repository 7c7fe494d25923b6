"""Settings out of range are refused by name, with what was got and expected."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from mgjax.core.errors import ConfigError
from mgjax.hybrid.config import (
    PathConfig,
    ReachConfig,
    validate_path_config,
    validate_reach_config,
)

PATH: list[tuple[str, Any]] = [
    ("method", "best"),
    ("horizon_s", 0.5),
    ("horizon_s", math.nan),
    ("keep_s", 0.0),
    ("keep_s", 5.0),
    ("near_m", 0.0),
    ("beam_width", 0),
    ("beam_width", 5000),
    ("beam_width", 2.5),
    ("expansions", 0),
    ("time_limit_s", -1.0),
    ("time_limit_s", math.inf),
    ("blend_weight", -0.1),
    ("blend_weight", "1"),
    ("speed_weight", math.inf),
    ("end_weight", -1.0),
    ("end_radius_m", -1.0),
    ("margin_m", 11.0),
    ("margin_m", True),
]
REACH: list[tuple[str, Any]] = [
    ("limits", 1),
    ("extend", "yes"),
    ("stop", None),
    ("blend_s", -0.1),
    ("blend_s", math.nan),
    ("turn_deg_s", 0.0),
    ("drop_m", 2.0),
    ("hold_m", 0.0),
    ("radius_m", 0.0),
    ("radius_m", math.inf),
]


def test_every_setting_has_a_case() -> None:
    assert {name for name, _ in PATH} == {field.name for field in fields(PathConfig)}
    assert {name for name, _ in REACH} == {field.name for field in fields(ReachConfig)}


@pytest.mark.parametrize(("name", "value"), PATH)
def test_bad_paths(name: str, value: Any) -> None:
    with pytest.raises(ConfigError, match=rf"^got {name} = .*, expected "):
        validate_path_config(_changed(PathConfig(), name, value))


@pytest.mark.parametrize(("name", "value"), REACH)
def test_bad_reaches(name: str, value: Any) -> None:
    with pytest.raises(ConfigError, match=rf"^got {name} = .*, expected "):
        validate_reach_config(_changed(ReachConfig(), name, value))


def test_good_settings() -> None:
    validate_path_config(PathConfig())
    validate_path_config(replace(PathConfig(), near_m=2, beam_width=4096, keep_s=4.0))
    validate_path_config(_changed(PathConfig(), "beam_width", np.int64(8)))
    validate_reach_config(ReachConfig())
    validate_reach_config(replace(ReachConfig(), blend_s=0, drop_m=0.0))


def _changed(config: Any, name: str, value: Any) -> Any:
    """The configuration with a value of any type; the hook of the tests checks constructors."""
    changed = replace(config)
    object.__setattr__(changed, name, value)
    return changed
