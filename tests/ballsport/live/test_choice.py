"""Scenes whose passes are decided by kicks that a sender plays, in simulated time."""

from __future__ import annotations

from pathlib import Path

import pytest

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.live.choice import SensorChoice
from mgjax.ballsport.scene.build import build_scene, prepare_scene
from mgjax.ballsport.scene.config import Pass, Player, SceneConfig
from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.load import load_motion
from mgjax.sensor.config import ReplayConfig
from tests.sensor.transport import Loopback

SCENE = SceneConfig(
    players=(Player(name="Ana", x=0.0, z=-2.5), Player(name="Ben", x=0.0, z=2.5)),
    passes=(Pass(by="Ana", to="Ben"), Pass(by="Ben", to="Ana")),
    takes=1,
)


@pytest.fixture(scope="module")
def moves() -> Repertoire:
    return prepare_scene(SCENE)


def driven(
    moves: Repertoire, skeleton: Skeleton, motion: Motion, seconds: float
) -> tuple[SensorChoice, list]:
    """A scene that a replayed clip decides, and the hits that were played."""
    sent = Loopback(skeleton, motion, ReplayConfig(speed=2.0))
    choice = SensorChoice(moves, sent, seconds, clock=sent.clock)
    scene = build_scene(SCENE, moves=moves, choose=choice)
    bones = moves.clips.hit_bone
    return choice, [(bones[touch.kick.hit], touch.kick.hit) for touch in scene.touches]


def test_kicks_decide_passes(moves: Repertoire) -> None:
    clips, _ = synthetic_kicks(seed=5, frame_rate=60.0, takes=1)
    clip = next(c for c in clips if "pass" in c.name and "right" in c.name)
    choice, played = driven(moves, clip.skeleton, clip.motion, clip.motion.seconds / 2 + 2.0)
    assert choice.taken
    for touch, kick in choice.taken:
        assert kick.bone == "right_foot"
        assert played[touch] == (kick.bone, kick.hit)


def test_a_kick_that_comes_too_late_decides_nothing(moves: Repertoire) -> None:
    clips, _ = synthetic_kicks(seed=5, frame_rate=60.0, takes=1)
    clip = next(c for c in clips if "pass" in c.name and "right" in c.name)
    choice, played = driven(moves, clip.skeleton, clip.motion, 0.5)
    assert choice.taken == []
    assert len(played) == 3


@pytest.mark.parametrize("name", ["cmu10/10_02.amc"])
def test_a_captured_kick_decides_a_pass(moves: Repertoire, capture: Path, name: str) -> None:
    skeleton, motion = load_motion(capture / "ball" / name)
    choice, played = driven(moves, skeleton, motion, motion.seconds / 2 + 3.0)
    touch, kick = choice.taken[0]
    assert kick.bone == "right_foot"
    assert played[touch] == (kick.bone, kick.hit)
