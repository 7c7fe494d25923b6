"""Trials of the observer study (§6.1): the clear candidates of a throw beside each other.

A pick is one JSON object on a line:

    {"format": "mgjax-study-1", "trial": 3, "observer": "A", "when": "2026-…",
     "node": 17, "attack": {"radii", "times", "centres"},       as an attack's JSON file has it
     "settings": {"form", "d0", "E_avoidance", "D_body", "D_move", "E_time", "E_fast", "w_a", "w_b",
                  "w_m", "w_t", "w_speed_up", "T_window"},
     "candidates": [{"letter", "edges", "scales", "part", "kind", "clearance_m", "energy": {
                     "total", "avoidance", "body", "movement", "timescale", "penetration", "d",
                     "d0", "displacement"}, "time_scale"}],      in the order in which they stood
     "library": "B", "pick": "A"}
"""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.explain import Explained
from mgjax.avoidance.play.answers import Asked
from mgjax.core import planar
from mgjax.core.errors import ConfigError
from mgjax.stage.apps.throw.lane import Lane, Throw
from mgjax.stage.apps.throw.replay import BEFORE_S, RATE, candidates_of, walk_frames
from mgjax.stage.apps.throw.words import kind_of
from mgjax.stage.serve.fields import text
from mgjax.stage.serve.session import Message
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Ball, Show

FORMAT = "mgjax-study-1"
LETTERS = "ABCD"
APART_M = 2.2


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """Candidates in the order in which they stand; the library's own choice is ``chosen``."""

    number: int
    lane: Lane
    asked: Asked
    shown: list[Explained]
    chosen: int


def make_trial(number: int, lane: Lane, throw: Throw, rng: np.random.Generator) -> Trial | None:
    """A trial of the best clear candidates of different parts; None of fewer than two."""
    if throw.found is None:
        return None
    best: dict[int, Explained] = {}
    for row in candidates_of(lane, throw.found.asked):
        if row.outcome == "clear":
            best.setdefault(row.part, row)
    rows = list(best.values())[: len(LETTERS)]
    if len(rows) < 2:
        return None
    order = rng.permutation(len(rows)).tolist()
    return Trial(
        number=number,
        lane=lane,
        asked=throw.found.asked,
        shown=[rows[i] for i in order],
        chosen=order.index(0),
    )


def trial_show(trial: Trial) -> Show:
    """The candidates beside each other, each with its ball, and nothing that gives away which."""
    lane, asked = trial.lane, trial.asked
    count = len(trial.shown)
    first = max(asked.begins - BEFORE_S, 0.0)
    seconds = asked.begins + asked.attack.end + 0.3 - first
    times = first + np.arange(max(int(seconds * RATE), 2)) / RATE
    actors: list[Actor] = []
    balls: list[Ball] = []
    inverse = np.asarray(planar.inverse(asked.place))
    for place, row in enumerate(trial.shown):
        aside = np.array([0.0, -(place - (count - 1) / 2) * APART_M, 0.0])
        move = np.asarray(planar.compose(aside, inverse))
        motion = walk_frames(lane, asked, row, times)
        root, turn = planar.apply_pose(
            move,
            np.asarray(motion.root_translation, np.float64),
            np.asarray(motion.local_rotations[:, 0], np.float64),
        )
        rotations = np.array(motion.local_rotations)
        rotations[:, 0] = turn
        moved = dataclasses.replace(
            motion, root_translation=np.asarray(root), local_rotations=rotations
        )
        letter = LETTERS[place]
        actors.append(Actor(id=letter, body=0, frames=frames_of(moved), colour="grey", note=letter))
        attack = asked.attack
        balls.append(
            Ball(
                id=f"ball{letter}",
                radius=float(attack.radii[0]),
                times=attack.times + asked.begins - first,
                places=np.asarray(planar.apply(aside, attack.centres[:, 0])),
            )
        )
    return Show(
        title=f"Trial {trial.number}",
        words="Which one avoids the ball with the least movement?",
        seconds=seconds,
        bodies=[body_of(lane.prepared.graph.skeleton)],
        actors=actors,
        balls=balls,
    )


def pick_line(trial: Trial, pick: str, observer: str) -> str:
    """A pick as a line of the study's file."""
    asked = trial.asked
    energy = trial.lane.config.energy
    settings: dict[str, Any] = {
        f.name: v if isinstance(v := getattr(energy, f.name), str) else float(v)
        for f in dataclasses.fields(energy)
    }
    record = {
        "format": FORMAT,
        "trial": trial.number,
        "observer": observer,
        "when": datetime.now(UTC).isoformat(timespec="seconds"),
        "node": asked.node,
        "attack": _attack_json(asked.attack),
        "settings": settings | {"T_window": trial.lane.config.T_window},
        "candidates": [_candidate(trial, i) for i in range(len(trial.shown))],
        "library": LETTERS[trial.chosen],
        "pick": pick,
    }
    return json.dumps(record, allow_nan=False)


def _attack_json(attack: Attack) -> dict[str, Any]:
    return {
        "radii": attack.radii.tolist(),
        "times": attack.times.tolist(),
        "centres": attack.centres.tolist(),
    }


def _candidate(trial: Trial, place: int) -> dict[str, Any]:
    row = trial.shown[place]
    assert row.energy is not None, "only candidates that can be timed are clear"
    return {
        "letter": LETTERS[place],
        "edges": row.walk.edges[: row.path_length].tolist(),
        "scales": row.walk.scales[: row.path_length].tolist(),
        "part": row.part,
        "kind": kind_of(trial.lane.prepared.graph, row.part),
        "clearance_m": row.clearance_m,
        "energy": dataclasses.asdict(row.energy),
        "time_scale": row.time_scale,
    }


class Study:
    """The trials of one tab, and its picks.

    Args:
        rng: draws in which order candidates stand.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._trial: Trial | None = None
        self._picks: list[str] = []

    @property
    def letters(self) -> list[str]:
        """Of the candidates that are to be compared."""
        return [] if self._trial is None else list(LETTERS[: len(self._trial.shown)])

    def ask(self, lane: Lane, throw: Throw) -> Show:
        """The next trial; :class:`ConfigError` where there is nothing to compare."""
        trial = make_trial(len(self._picks) + 1, lane, throw, self._rng)
        if trial is None:
            raise ConfigError(
                got="a throw with fewer than two clear ways out", expected="another throw"
            )
        self._trial = trial
        return trial_show(trial)

    def give_up(self) -> None:
        """The trial is left without a pick."""
        self._trial = None

    def pick(self, message: Message) -> dict[str, Any]:
        """Takes a pick; whether the search agrees, and how many there are."""
        if self._trial is None:
            raise ConfigError(got="a pick without a trial", expected="compare first")
        letter = text(message, "letter", self.letters)
        observer = text(message, "observer", most=40)
        self._picks.append(pick_line(self._trial, letter, observer))
        agrees = letter == LETTERS[self._trial.chosen]
        self._trial = None
        return {"agrees": agrees, "picks": len(self._picks)}

    def file(self) -> bytes:
        """All picks, a line each; :class:`ConfigError` without any."""
        if not self._picks:
            raise ConfigError(got="no picks", expected="some: compare the ways out of a throw")
        return ("\n".join(self._picks) + "\n").encode()
