"""Pitches played before anybody looks, so that nothing is compiled while somebody does."""

from __future__ import annotations

import threading
from itertools import product

import numpy as np

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.scene.config import SceneConfig
from mgjax.stage.apps.match.game import Game
from mgjax.stage.apps.match.pitch import COUNTS, pitch
from mgjax.stage.apps.match.wishes import ANY, BOUNCES, Wishes
from mgjax.stage.serve.collector import waiting_collector

_PLAYED_S = 6.0
"""So long a pitch is played with each number of bounces."""
_WAITED_S = 9.0
"""So long it then waits for a click."""
_FIRST = "1"
"""Bounces without which nothing can begin; the others are rehearsed while the match is played."""


class Rehearsal:
    """Compiles what pitches need: some at once, the rest in a thread.

    Args:
        moves: what players can do.
    """

    def __init__(self, moves: Repertoire) -> None:
        self._moves = moves
        self._done: set[tuple[int, bool, str]] = set()
        self._one = threading.Lock()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._others, name="rehearsal", daemon=True)

    def begin(self, config: SceneConfig) -> None:
        """Plays a pitch as far as is needed to begin, and goes on in a thread."""
        self._play(config, _FIRST)
        self._thread.start()

    def prepare(self, config: SceneConfig) -> None:
        """Plays a pitch as far as is needed to begin; returns at once where that has been done."""
        self._play(config, _FIRST)

    def ready(self, config: SceneConfig) -> list[str]:
        """Numbers of bounces with which a pitch can be played without a wait."""
        pitch_of = len(config.players), config.net is not None
        return [bounces for bounces in _ORDER if (*pitch_of, bounces) in self._done]

    def close(self) -> None:
        """Ends the thread."""
        self._stopping.set()
        if self._thread.ident is not None:
            self._thread.join()

    def _others(self) -> None:
        pitches = [pitch(count, net=net) for net in (True, False) for count in COUNTS]
        with waiting_collector():
            for config, bounces in product(pitches, _ORDER):
                self._play(config, bounces)

    def _play(self, config: SceneConfig, bounces: str) -> None:
        key = len(config.players), config.net is not None, bounces
        with self._one:
            if key in self._done or self._stopping.is_set():
                return
            names = [player.name for player in config.players]
            wishes = Wishes(players=names, rng=np.random.default_rng(0), kind=ANY, bounces=bounces)
            game = Game(config, self._moves, wishes)
            time = 0.0
            while time < _PLAYED_S and not self._stopping.is_set():
                game.play(time)
                time = game.known_s
            wishes.on = False
            game.play(time + _WAITED_S)
            self._done.add(key)


_ORDER = (_FIRST, *(bounces for bounces in BOUNCES if bounces not in (ANY, _FIRST)))
