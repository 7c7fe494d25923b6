"""What is compiled before a pitch is played, and what the game chooses until the rest is."""

from __future__ import annotations

import numpy as np

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.stage.apps.match.pitch import pitch
from mgjax.stage.apps.match.rehearsal import Rehearsal
from mgjax.stage.apps.match.wishes import Wishes


def test_one_bounce_is_ready_first(moves: Repertoire) -> None:
    """Until others are, the game bounces the ball once; who wants two gets two."""
    rehearsal, config = Rehearsal(moves), pitch(3, net=True)
    assert rehearsal.ready(config) == []
    rehearsal.prepare(config)
    assert rehearsal.ready(config) == ["1"]
    assert rehearsal.ready(pitch(6, net=True)) == []
    wishes = Wishes(players=["Ana", "Ben"], rng=np.random.default_rng(0))
    wishes.ready = lambda: rehearsal.ready(config)
    assert {p.bounces for p in (wishes.next_pass("Ana") for _ in range(30)) if p} == {1}
    wishes.bounces = "2"
    asked = wishes.next_pass("Ana")
    assert asked is not None
    assert asked.bounces == 2


def test_the_thread_ends_when_it_is_told(moves: Repertoire) -> None:
    rehearsal = Rehearsal(moves)
    rehearsal.begin(pitch(3, net=True))
    rehearsal.close()
    done = rehearsal.ready(pitch(6, net=False))
    rehearsal.prepare(pitch(6, net=False))
    assert rehearsal.ready(pitch(6, net=False)) == done
