"""The observer study (§6.1) on the live page: the clear candidates of a throw beside each other.

Picks are kept in the study's format (:mod:`mgjax.avoidance.study.format`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mgjax.avoidance.choice.explain import Explained
from mgjax.avoidance.play.answers import Asked
from mgjax.avoidance.study.format import pick_line, trial_json
from mgjax.avoidance.study.trials import LETTERS, different_parts, shuffled
from mgjax.core import planar
from mgjax.core.errors import ConfigError
from mgjax.stage.apps.throw.lane import Lane, Throw
from mgjax.stage.apps.throw.replay import BEFORE_S, RATE, candidates_of, walk_frames
from mgjax.stage.serve.fields import text
from mgjax.stage.serve.session import Message
from mgjax.stage.show.types import Show
from mgjax.stage.study import QUESTION, placed, trial_show

MOST = 4
"""Candidates of a trial."""
_AFTER_S = 0.3


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """Candidates in the order in which they stand; the search's own choice is ``chosen``."""

    number: int
    lane: Lane
    asked: Asked
    shown: list[Explained]
    chosen: int


def make_trial(number: int, lane: Lane, throw: Throw, rng: np.random.Generator) -> Trial | None:
    """A trial of the best clear candidates of different parts; None of fewer than two."""
    if throw.found is None:
        return None
    rows = different_parts(candidates_of(lane, throw.found.asked))
    if len(rows) < 2:
        return None
    shown, chosen = shuffled(rows, rng, MOST, best=True)
    return Trial(number=number, lane=lane, asked=throw.found.asked, shown=shown, chosen=chosen)


def show_of_trial(trial: Trial) -> Show:
    """The candidates beside each other, from a little before the path begins."""
    lane, asked = trial.lane, trial.asked
    first = max(asked.begins - BEFORE_S, 0.0)
    seconds = asked.begins + asked.attack.end + _AFTER_S - first
    times = first + np.arange(max(int(seconds * RATE), 2)) / RATE
    inverse = np.asarray(planar.inverse(asked.place))
    return trial_show(
        lane.prepared.graph.skeleton,
        [placed(walk_frames(lane, asked, row, times), inverse) for row in trial.shown],
        asked.attack,
        title=f"Trial {trial.number}",
        words=QUESTION,
        now=asked.begins - first,
    )


def line_of(trial: Trial, pick: str, observer: str) -> str:
    """A pick as a line of the study's file."""
    record = trial_json(
        trial.lane.prepared.graph,
        trial.lane.config,
        number=trial.number,
        node=trial.asked.node,
        attack=trial.asked.attack,
        rows=trial.shown,
        taken=trial.chosen,
    )
    return pick_line(record, pick, observer)


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
        return show_of_trial(trial)

    def give_up(self) -> None:
        """The trial is left without a pick."""
        self._trial = None

    def pick(self, message: Message) -> dict[str, Any]:
        """Takes a pick; whether the search agrees, and how many there are."""
        if self._trial is None:
            raise ConfigError(got="a pick without a trial", expected="compare first")
        letter = text(message, "letter", self.letters)
        observer = text(message, "observer", most=40)
        self._picks.append(line_of(self._trial, letter, observer))
        agrees = letter == LETTERS[self._trial.chosen]
        self._trial = None
        return {"agrees": agrees, "picks": len(self._picks)}

    def file(self) -> bytes:
        """All picks, a line each; :class:`ConfigError` without any."""
        if not self._picks:
            raise ConfigError(got="no picks", expected="some: compare the ways out of a throw")
        return ("\n".join(self._picks) + "\n").encode()
