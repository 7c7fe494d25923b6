from __future__ import annotations

import dataclasses
import subprocess
import sys

import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.ballsport import BallPhysics, Net
from mgjax.core.errors import ConfigError


@pytest.mark.parametrize(
    "setting",
    [
        {"restitution": -0.1},
        {"restitution": 1.1},
        {"drag": -0.2},
        {"drag": float("nan")},
        {"gravity": 0.0},
        {"radius": -0.11},
        {"radius": "big"},
        {"restitution": True},
        {"drag": None},
    ],
    ids=str,
)
def test_bad_physics(setting: dict) -> None:
    name = next(iter(setting))
    with pytest.raises(ConfigError, match=f"^got {name} = .*, expected .*$") as error:
        BallPhysics(**setting)
    assert "\n" not in str(error.value)
    with pytest.raises(ConfigError):
        dataclasses.replace(BallPhysics(), **setting)


def test_unknown_law() -> None:
    physics = BallPhysics()
    object.__setattr__(physics, "drag_law", "cubic")  # past the type check of the tests
    with pytest.raises(ConfigError, match="got drag_law = 'cubic'"):
        physics.__post_init__()


def test_bad_net() -> None:
    with pytest.raises(ConfigError, match="height = -1"):
        Net(height=-1.0)
    with pytest.raises(ConfigError, match="heading"):
        Net(heading=float("inf"))


def test_numbers_may_be_arrays() -> None:
    assert BallPhysics(drag=jnp.array(0.3)).drag.shape == ()
    assert BallPhysics(restitution=np.float32(0.5)).restitution == 0.5


def test_settings_do_not_import_jax() -> None:
    code = (
        "import sys, mgjax.ballsport as b; b.BallPhysics(), b.Net(); sys.exit('jax' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
