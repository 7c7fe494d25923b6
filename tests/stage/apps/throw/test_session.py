from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.attacks.json_file import load_attack
from mgjax.avoidance.checks.written import clearance, sphere_trajectory
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.core.errors import ConfigError
from mgjax.stage.apps.throw.lane import AHEAD_S, RATE
from mgjax.stage.packet import pack


def test_frames_come_without_gaps_and_ahead_of_time(open_tab):
    tab = open_tab()
    tab.play(6.0)
    sent = tab.of_type("frames")
    nexts = [m["frames"]["start"] + len(m["frames"]["root"]) / RATE for m in sent]
    starts = [m["frames"]["start"] for m in sent]
    assert starts[0] <= 1e-9 + 1 / RATE
    np.testing.assert_allclose(starts[1:], nexts[:-1], atol=1e-6)
    # What is shown at 6 s was there when it had to be.
    assert nexts[-1] > 6.0 + AHEAD_S - 2 / RATE


def test_what_is_sent_is_what_is_played(open_tab):
    tab = open_tab()
    tab.play(3.0)
    lane = tab.session._lanes[0]
    for message in tab.of_type("frames"):
        frames = message["frames"]
        times = frames["start"] + np.arange(len(frames["root"])) / RATE
        played = lane.planner.timeline.sample(times)
        np.testing.assert_allclose(frames["root"], played.root_translation, atol=2e-4)


def test_a_throw_is_answered_in_words(open_tab):
    tab = open_tab(3)
    tab.play(1.0)
    tab.throw()
    tab.play(3.0)
    (found,) = tab.notes("found")
    (answer,) = tab.notes("answer")
    assert any(word in answer["words"] for word in ("avoided by", "hit", "passed"))
    assert answer["tone"] == ("bad" if answer["hit"] else "good")
    assert [row[0] for row in found["rows"]][:1] == ["search"]
    for bar in answer["bars"]:
        assert 0 <= bar["value"] <= bar["of"] + 1e-6
    (ball, *_) = tab.of_type("put")
    assert ball["kind"] == "balls"
    for message in tab.told:
        pack(message)


@pytest.mark.filterwarnings("error")
def test_a_ball_may_be_thrown_in_the_first_moment(open_tab):
    tab = open_tab()
    tab.throw()
    tab.play(3.0)
    assert len(tab.notes("answer")) == 1


def test_no_claim_of_avoidance_is_false(open_tab, prepared):
    tab = open_tab(1)
    spheres, graph = prepared.tables.spheres, prepared.graph
    for number in range(8):
        tab.play(0.8)
        notice = 0.4 if number % 2 else 1.5  # too late to be avoided, and in time
        tab.session.receive({"type": "settings", "lane": 0, "notice": notice})
        tab.throw()
        tab.play(3.0)
    lane = tab.session._lanes[0]
    for throw in lane.throws:
        first = int(throw.attack.start * EXPORT_RATE)
        times = np.arange(first, int(throw.attack.end * EXPORT_RATE) + 2) / EXPORT_RATE
        motion = replace(lane.planner.timeline.sample(times), frame_rate=EXPORT_RATE)
        trace = sphere_trajectory(graph, spheres, motion)
        attack = replace(throw.attack, times=throw.attack.times - first / EXPORT_RATE)
        gap = clearance(attack, trace, spheres.radii)[1]
        assert throw.answer is not None
        assert throw.answer.hit == (gap < 1e-3) or abs(gap) < 0.01
        # The ball that is seen stops at the body it hits, and at no other.
        assert (throw.contact is not None) == throw.answer.hit or abs(gap) < 0.02
    assert {t.answer.hit for t in lane.throws} == {True, False}, "both kinds were seen"


def test_sliders_act_on_the_next_throw(open_tab):
    tab = open_tab()
    tab.play(0.5)
    tab.session.receive({"type": "settings", "lane": 0, "radius": 0.3, "T_window": 0.5, "w_a": 2.0})
    tab.throw()
    lane = tab.session._lanes[0]
    assert lane.throws[-1].attack.radii[0] == 0.3
    assert lane.config.T_window == 0.5
    assert lane.config.energy.w_a == 2.0
    with pytest.raises(ConfigError, match="got speed 99"):
        tab.session.receive({"type": "settings", "lane": 0, "speed": 99, "radius": 0.1})
    assert tab.session._ball.radius == 0.3, "a refused message changes nothing"


def test_a_switch_lets_an_arm_parry(open_tab):
    tab = open_tab()
    lane = tab.session._lanes[0]
    (opened,) = [m for m in tab.told if "settings" in m.get("options", {})]
    assert opened["options"]["settings"]["parry"] == {"value": False}
    tab.session.receive({"type": "settings", "lane": 0, "parry": True})
    assert lane.config.parry == "on"
    assert lane.planner._config.parry == "on"
    tab.session.receive({"type": "settings", "lane": 0, "w_a": 2.0})
    assert lane.config.parry == "on", "what a message does not name stays"
    tab.session.receive({"type": "settings", "lane": 0, "parry": False})
    assert lane.planner._config.parry == "off"
    with pytest.raises(ConfigError, match="got parry 1"):
        tab.session.receive({"type": "settings", "lane": 0, "parry": 1})


def test_time_stands_still_and_goes_on(open_tab):
    tab = open_tab()
    tab.play(1.0)
    tab.session.receive({"type": "pace", "pace": 0})
    count = len(tab.of_type("frames"))
    tab.play(2.0)
    assert len(tab.of_type("frames")) <= count + 1
    assert tab.session._clock.now() == pytest.approx(1.0)
    tab.session.receive({"type": "pace", "pace": 0.5})
    tab.play(2.0)
    assert tab.session._clock.now() == pytest.approx(2.0)


def test_ten_balls_one_after_another(open_tab):
    tab = open_tab()
    tab.play(0.5)
    tab.session.receive({"type": "ten"})
    tab.play(45.0)
    series = tab.notes("series")
    assert [s["done"] for s in series] == list(range(11))
    answers = tab.notes("answer")
    assert len(answers) == 10
    assert series[-1]["avoided"] == sum(not a["hit"] for a in answers)


def test_two_characters_get_the_same_throw(open_tab):
    tab = open_tab()
    tab.play(1.0)
    tab.session.receive({"type": "second", "on": True})
    tab.session.receive({"type": "settings", "lane": 1, "T_window": 0.3})
    tab.play(1.0)
    first, second = tab.session._lanes
    assert np.linalg.norm(first.frame_now()[1:] - second.frame_now()[1:]) > 0.5
    frames = [lane.frame_now() for lane in (first, second)]
    tab.throw()
    one, two = (lane.throws[-1].attack for lane in (first, second))
    from mgjax.avoidance.attacks.transform import in_frame

    local = [in_frame(a, f, 0.0).centres for a, f in zip((one, two), frames, strict=True)]
    np.testing.assert_allclose(local[0], local[1], atol=1e-6)
    tab.play(3.0)
    assert {note["lane"] for note in tab.notes("answer")} == {0, 1}
    assert (first.config.T_window, second.config.T_window) == (2.0, 0.3)
    tab.session.receive({"type": "second", "on": False})
    assert len(tab.session._lanes) == 1


def test_a_replay_shows_what_was_played_with_its_ghosts(open_tab):
    tab = open_tab(3)
    tab.play(1.0)
    with pytest.raises(ConfigError, match="no throw that is over"):
        tab.session.receive({"type": "replay", "ghosts": True})
    tab.throw()
    tab.play(3.0)
    tab.session.receive({"type": "replay", "ghosts": True})
    (message,) = tab.of_type("show")
    show = message["show"]
    assert show["words"] == tab.notes("answer")[0]["words"]
    solid = [a for a in show["actors"] if a["look"] == "solid"]
    assert len(solid) == 1
    ghosts = [a for a in show["actors"] if a["look"] == "ghost"]
    assert all(g["note"] for g in ghosts)
    assert len(ghosts) == min(len(show["notes"]), 6)
    now = tab.session._clock.now()
    tab.play(2.0)
    assert tab.session._clock.now() == pytest.approx(now), "nothing is missed meanwhile"
    tab.session.receive({"type": "live"})
    tab.play(0.5)
    assert tab.session._clock.now() == pytest.approx(now + 0.5)
    assert len(tab.notes("scene")) == 2


def test_a_study_keeps_picks_in_its_format(open_tab, tmp_path):
    tab = open_tab()
    with pytest.raises(ConfigError, match="no picks"):
        tab.session.receive({"type": "picks"})
    for _ in range(8):
        tab.play(0.7)
        tab.throw()
        tab.play(3.0)
        try:
            tab.session.receive({"type": "compare"})
        except ConfigError:
            continue
        break
    (trial,) = tab.notes("trial")
    show = tab.of_type("show")[-1]["show"]
    assert [a["note"] for a in show["actors"]] == trial["letters"]
    assert {a["colour"] for a in show["actors"]} == {"grey"}, "nothing is given away"
    with pytest.raises(ConfigError, match="got letter"):
        tab.session.receive({"type": "pick", "letter": "Z", "observer": "me"})
    tab.session.receive({"type": "pick", "letter": "B", "observer": "me"})
    tab.session.receive({"type": "picks"})
    (file,) = tab.of_type("file")
    record = json.loads(bytes(file["data"]).decode())
    assert (record["format"], record["pick"], record["observer"]) == ("mgjax-study-2", "B", "me")
    totals = {c["letter"]: c["energy"]["total"] for c in record["candidates"]}
    assert min(totals, key=totals.__getitem__) == record["library"]
    path = tmp_path / "attack.json"
    path.write_text(json.dumps(record["attack"]))
    assert load_attack(path).radii.tolist() == record["attack"]["radii"]


@pytest.mark.parametrize(
    "message",
    [
        {"type": "dance"},
        {"type": "throw"},
        {"type": "throw", "from": [0, 0, 0], "to": [0, 0, 0]},
        {"type": "throw", "from": [0, 1, 5], "to": [0, 1, 0], "lane": 1},
        {"type": "throw", "from": [0, 1, 5], "to": [0, 1, float("nan")]},
        {"type": "settings"},
        {"type": "settings", "lane": 0, "E_avoidance": "1"},
        {"type": "pace", "pace": -1},
        {"type": "second", "on": 1},
        {"type": "replay", "ghosts": "yes"},
        {"type": "compare"},
        {"type": "pick", "letter": "A", "observer": "me"},
    ],
)
def test_messages_that_are_refused_change_nothing(open_tab, message):
    tab = open_tab()
    tab.play(0.2)
    with pytest.raises(ConfigError, match="got"):
        tab.session.receive(message)
    assert not tab.session._lanes[0].throws
    tab.play(0.2)


def test_no_more_balls_than_can_be_followed(open_tab):
    tab = open_tab()
    tab.play(0.5)
    for _ in range(6):
        tab.throw()
    with pytest.raises(ConfigError, match="7 balls at once"):
        tab.throw()


def test_closing_ends_the_searches(open_tab):
    tab = open_tab()
    tab.session.close()
    assert not tab.session._lanes
    tab.session.tick()
