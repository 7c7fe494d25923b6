"""What an application asks of a planner while it plays: other settings, what was found, when."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.transform import in_frame
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.config import AvoidanceConfig, SpeedConfig
from mgjax.avoidance.play.answers import Found
from mgjax.avoidance.play.clocks import SimulatedClock, SimulatedSearches
from mgjax.avoidance.play.planner import Planner
from mgjax.core.errors import ConfigError

QUICK = AvoidanceConfig(checks=12, refine="off")


def planner_at(graph, begin: float = 0.0, **more) -> tuple[Planner, SimulatedClock]:
    clock = SimulatedClock()
    clock.advance(begin)
    searches = SimulatedSearches(0.01)
    planner = Planner(graph, clock=clock, searches=searches, config=QUICK, begin=begin, **more)
    return planner, clock


def throw(planner: Planner, clock: SimulatedClock, arrives: float = 1.4) -> None:
    root = planner.frame().root_translation[0]
    ball = ball_from(0.7, 1.2, at=(float(root[0]), float(root[2])), arrives=arrives)
    planner.attack(replace(ball, times=ball.times + clock.now()))


def play(planner: Planner, clock: SimulatedClock, seconds: float) -> None:
    for _ in range(round(seconds * 30)):
        clock.advance(1 / 30)
        planner.advance()


def test_what_a_search_found_is_told_with_what_it_was_asked(made_graph):
    told: list[Found] = []
    planner, clock = planner_at(made_graph, on_found=told.append)
    play(planner, clock, 1.0)
    throw(planner, clock)
    play(planner, clock, 2.5)
    (found,) = told
    asked = found.asked
    again = choose(made_graph, asked.node, asked.attack, config=QUICK)
    assert found.path.choice is not None
    assert found.path.choice.status == again.status
    assert found.path.choice.candidates == again.candidates
    assert found.path.seconds > 0
    # The place is where the body stands then: the attack in the world is the attack thrown.
    begins = planner.timeline.starts.index(asked.begins)
    assert planner.timeline.starts[begins] == asked.begins
    back = in_frame(asked.attack, np.zeros(3), -asked.begins)
    assert back.end == pytest.approx(asked.attack.end + asked.begins)


def test_advance_tells_until_when_all_is_final(made_graph):
    planner, clock = planner_at(made_graph)
    before = None
    for _ in range(60):
        clock.advance(0.05)
        final = planner.advance()
        assert final >= clock.now() - 1e-9
        if final < clock.now() + 1e-3:
            continue  # an edge ends just now
        times = np.linspace(clock.now(), final, 5)
        shown = np.asarray(planner.timeline.sample(times).root_translation)
        if before is not None:
            again = np.asarray(planner.timeline.sample(before[0]).root_translation)
            np.testing.assert_allclose(again, before[1], atol=1e-6)
        before = times, shown


def test_other_settings_hold_from_the_next_search_on(made_graph):
    told: list[Found] = []
    planner, clock = planner_at(made_graph, on_found=told.append)
    play(planner, clock, 0.5)
    planner.configure(replace(QUICK, T_window=0.05))
    throw(planner, clock)
    play(planner, clock, 2.5)
    planner.configure(replace(QUICK, T_window=2.0))
    throw(planner, clock)
    play(planner, clock, 2.5)
    assert len(told) == 2
    for found, window in zip(told, (0.05, 2.0), strict=True):
        config = replace(QUICK, T_window=window)
        again = choose(made_graph, found.asked.node, found.asked.attack, config=config)
        assert found.path.choice is not None
        assert found.path.choice.candidates == again.candidates


def test_settings_that_need_other_tables_are_refused(made_graph):
    planner, _ = planner_at(made_graph)
    with pytest.raises(ConfigError, match="speed"):
        planner.configure(replace(QUICK, speed=SpeedConfig(V_fast=1.0)))
    with pytest.raises(ConfigError, match="T_window"):
        planner.configure(replace(QUICK, T_window=0.0))


def test_a_planner_begins_at_any_time(made_graph):
    start = np.array([0.5, 3.0, -2.0])
    planner, clock = planner_at(made_graph, 100.0, start=start, node=3)
    assert planner.timeline.starts[0] == 100.0
    np.testing.assert_allclose(planner.frame().root_translation[0][[0, 2]], [3.0, -2.0], atol=0.3)
    play(planner, clock, 1.0)
    throw(planner, clock)
    play(planner, clock, 2.5)
    assert len(planner.answers) == 1
    assert planner.answers[0].known == pytest.approx(101.0)


def test_an_attack_that_comes_before_anything_can_change_is_no_late_answer(made_graph):
    planner, clock = planner_at(made_graph)
    found = set()
    for _ in range(25):
        play(planner, clock, 0.4)
        throw(planner, clock, arrives=0.1)
        play(planner, clock, 1.0)
        answer = planner.answers[-1]
        found.add(answer.search)
        if answer.search == "committed":
            assert answer.waited is None
            assert answer.restarts == 0
    assert "committed" in found
    assert "late" not in found
