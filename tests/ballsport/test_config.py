"""Settings that cannot be, each refused by name; and settings cost no jax."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from typing import Any

import pytest

from mgjax.ballsport.config import (
    BONE_TABLE,
    FEET,
    HIT_BONES,
    AnalysisConfig,
    ClipSetConfig,
    KindConfig,
    MatchConfig,
    TransitionConfig,
    hit_bone,
    validate_clip_set,
    validate_match,
)
from mgjax.ballsport.live.config import ListenConfig, validate_listen
from mgjax.ballsport.scene.config import Pass, Player, SceneConfig, validate_scene
from mgjax.core.errors import ConfigError, SkeletonError
from mgjax.sensor.config import ReplayConfig, validate_replay

SCENE = SceneConfig(
    players=(Player(name="A", x=0.0, z=-2.0), Player(name="B", x=0.0, z=2.0)),
    passes=(Pass(by="A", to="B"),),
)


def test_defaults_are_in_range() -> None:
    validate_clip_set(ClipSetConfig())
    validate_match(MatchConfig())
    validate_listen(ListenConfig())
    validate_scene(SCENE)
    validate_replay(ReplayConfig())
    validate_replay(ReplayConfig(rate=120.0))


@pytest.mark.parametrize(
    ("config", "text"),
    [
        (ClipSetConfig(frame_rate=0.0), "frame_rate = 0.0, expected 1 … 10000"),
        (ClipSetConfig(bones=("left_foot", "left_foot")), "bones = ['left_foot', 'left_foot']"),
        (ClipSetConfig(analysis=AnalysisConfig(height_m=float("inf"))), "analysis.height_m = inf"),
        (ClipSetConfig(analysis=AnalysisConfig(margin_m=-0.1)), "analysis.margin_m = -0.1"),
        (ClipSetConfig(kinds=KindConfig(pass_m_s=-1.0)), "kinds.pass_m_s = -1.0"),
        (ClipSetConfig(kinds=KindConfig(pass_m_s=8.0)), "kinds.attack_m_s = 7.2"),
        (ClipSetConfig(transition=TransitionConfig(seconds=61.0)), "transition.seconds = 61.0"),
        (
            ClipSetConfig(transition=TransitionConfig(w_v=(0.0, 0.0, 0.0, 0.0, -1.0))),
            "transition.w_v = -1.0, expected 0 … 1e+09",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_clip_sets_that_cannot_be(config: ClipSetConfig, text: str) -> None:
    with pytest.raises(ConfigError, match=f"^got {re.escape(text)}"):
        validate_clip_set(config)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"max_speed": 0.0}, "got max_speed = 0.0, expected 0.001 … 100"),
        ({"frame_rate": 241.0}, "got frame_rate = 241.0, expected 20 … 240"),
        ({"takes": 21}, "got takes = 21, expected 1 … 20"),
        ({"end_s": -0.1}, "got end_s = -0.1, expected 0 … 60"),
        ({"seed": 2**32}, "got seed = 4294967296, expected 0 … "),
        ({"throw_in": (0.0, 0.1, 0.0)}, "got throw_in, y = 0.1, expected 0.11 … 1000"),
        ({"throw_in": (float("nan"), 1.0, 0.0)}, "got throw_in, x = nan"),
        ({"match": MatchConfig(w_t=-1.0)}, "got match.w_t = -1.0"),
        ({"transition": TransitionConfig(loop_s=-1.0)}, "got transition.loop_s = -1.0"),
        (
            {"players": (Player(name="A", x=2000.0, z=0.0), SCENE.players[1])},
            "got A.x = 2000.0, expected -1000 … 1000",
        ),
    ],
    ids=str,
)
def test_scenes_that_cannot_be(change: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigError, match=f"^{re.escape(text)}"):
        validate_scene(replace(SCENE, **change))


def test_the_table_of_hit_bones() -> None:
    assert HIT_BONES == ("left_foot", "right_foot", "left_hand", "right_hand", "head")
    assert HIT_BONES[:2] == FEET
    for name, bone in BONE_TABLE.items():
        assert name == bone.name == (f"{bone.side}_{bone.kind}" if bone.side else bone.kind)
        assert hit_bone(name) is bone
    with pytest.raises(SkeletonError, match="'knee'"):
        hit_bone("knee")


def test_settings_do_not_import_jax() -> None:
    code = (
        "import sys, mgjax.ballsport.config, mgjax.ballsport.live.config, mgjax.sensor.config;"
        "import mgjax.ballsport.scene.config;"
        "sys.exit('jax' in sys.modules or 'numpy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
