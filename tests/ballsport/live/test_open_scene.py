"""Scenes without an end: what is certain does not change, and passes are asked for in time."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from mgjax.ballsport.clipset.build import ClipSet
from mgjax.ballsport.clipset.repertoire import Repertoire, make_repertoire
from mgjax.ballsport.live.open_scene import OpenScene, ScenePart
from mgjax.ballsport.scene.config import Pass, Player, SceneConfig
from mgjax.ballsport.scene.gaze import gaze_frames
from mgjax.ballsport.scene.rally import Rally
from mgjax.ballsport.scene.report import scene_json
from mgjax.ballsport.scene.types import Asked
from mgjax.core.errors import ConfigError

PLAYERS = (
    Player(name="A", x=0.0, z=-2.0),
    Player(name="B", x=1.8, z=1.8),
    Player(name="C", x=-1.8, z=1.8),
)
SCENE = SceneConfig(players=PLAYERS, frame_rate=30.0, end_s=1.0)
AFTER = {"A": "B", "B": "C", "C": "A"}
STEP = 9


@pytest.fixture(scope="module")
def moves(made_set: ClipSet) -> Repertoire:
    return make_repertoire(made_set, ball_radius=0.11)


@dataclass
class Played:
    """Plays a scene step by step, and passes round as long as it may."""

    moves: Repertoire
    passes: int
    parts: list[ScenePart] = field(default_factory=list)
    asked: list[tuple[str, int]] = field(default_factory=list)
    frame: int = 0

    def __post_init__(self) -> None:
        self.scene = OpenScene(
            SCENE, self.moves, first="A", next_pass=self.next, choose=lambda asked: None
        )

    def next(self, by: str) -> Pass | None:
        if not self.passes:
            return None
        self.passes -= 1
        self.asked.append((by, self.scene.certain))
        return Pass(by=by, to=AFTER[by])

    def play(self, frames: int) -> None:
        for _ in range(0, frames, STEP):
            self.frame += STEP
            part = self.scene.advance(self.frame)
            if part is not None:
                self.parts.append(part)


@pytest.fixture(scope="module")
def played(moves: Repertoire) -> Played:
    """Four passes, a pause, and two more."""
    player = Played(moves, 4)
    player.play(600)
    assert player.scene.waits
    player.passes = 2
    player.play(450)
    return player


def test_parts_follow_one_another(played: Played) -> None:
    ends = [part.start + next(iter(part.motions.values())).num_frames for part in played.parts]
    assert [part.start for part in played.parts] == [0, *ends[:-1]]
    assert ends[-1] == played.scene.certain >= played.frame


def test_what_was_certain_stays(played: Played) -> None:
    """The parts are the motion of the whole scene, heads and idling included.

    But for its last frames: there heads know where the ball goes on to, and a scene is over.
    """
    scene = played.scene.scene()
    for name, motion in scene.motions.items():
        for values in ("root_translation", "local_rotations"):
            shown = np.concatenate([getattr(part.motions[name], values) for part in played.parts])
            whole = np.asarray(getattr(motion, values))
            common = min(len(shown), len(whole) - gaze_frames(30.0))
            np.testing.assert_allclose(shown[:common], whole[:common], atol=2e-5)
    common = min(len(played.scene.ball), len(scene.ball.places))
    shown, whole = played.scene.ball[:common], scene.ball.places[:common]
    first = played.scene.flights[0].start
    np.testing.assert_allclose(shown[first:], whole[first:], atol=1e-6)


def test_the_report_is_that_of_a_scene(played: Played) -> None:
    """Six passes are made in two rallies, each begun by a throw."""
    result = scene_json(played.scene.scene())
    assert [(row["by"], row["to"]) for row in result["passes"]] == [
        ("A", "B"), ("B", "C"), ("C", "A"), ("A", "B"), ("B", "C"), ("C", "A"),
    ]  # fmt: skip
    assert (result["passes_made"], len(result["throws"])) == (6, 2)
    assert result["worst"]["arrival_miss_m"] < 1e-3
    assert result["worst"]["surface_gap_m"] < 2e-3
    assert [touch.number for touch in played.scene.touches] == list(range(8))


def test_passes_are_asked_for_as_late_as_heads_allow(played: Played) -> None:
    """Whoever is asked knows what has been played up to half a second before the launch."""
    reach = gaze_frames(30.0)
    launches = [touch.time for touch in played.scene.touches]
    for (_, certain), launch in zip(played.asked[1:4], launches[:3], strict=True):
        assert certain == launch - reach


def test_nothing_happens_while_nobody_is_told(moves: Repertoire) -> None:
    player = Played(moves, 0)
    player.play(300)
    assert player.scene.waits
    assert player.scene.flights == []
    assert player.scene.certain >= 300
    with pytest.raises(ConfigError, match="no pass yet"):
        player.scene.scene()


def test_a_choice_is_asked_for_each_touch(moves: Repertoire) -> None:
    asked: list[Asked] = []

    def choose(question: Asked) -> int | None:
        asked.append(question)
        return question.hits[0]

    scene = OpenScene(
        SCENE, moves, first="A", choose=choose, next_pass=lambda by: Pass(by=by, to=AFTER[by])
    )
    scene.advance(200)
    assert [question.player for question in asked] == [
        "ABC"[k % 3] for k in range(len(scene.touches))
    ]
    assert all(touch.by_user for touch in scene.touches)


def test_part_is_within_what_is_certain(played: Played) -> None:
    with pytest.raises(ConfigError, match="within"):
        played.scene.part(0, played.scene.certain + 1)


def test_a_rally_is_extended_until_it_is_over(moves: Repertoire) -> None:
    config = replace(SCENE, passes=(Pass(by="A", to="B"),))
    rally = Rally(config, moves, begin=0)
    with pytest.raises(ConfigError, match="has the ball"):
        rally.extend(Pass(by="C", to="A"))
    rally.extend(Pass(by="B", to="C"))
    assert rally.order == ["A", "B", "C"]
    while not rally.done:
        rally.step()
    with pytest.raises(ConfigError, match="over"):
        rally.extend(Pass(by="C", to="A"))
