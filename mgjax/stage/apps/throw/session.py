"""One tab of the throw application."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.transform import in_frame
from mgjax.avoidance.play.clocks import Searches, ThreadSearches
from mgjax.avoidance.prepared import Prepared
from mgjax.core import planar
from mgjax.core.errors import AttackError, ConfigError
from mgjax.stage.apps.throw.aim import passing_point, thrown_along, thrown_at_random
from mgjax.stage.apps.throw.clock import SessionClock
from mgjax.stage.apps.throw.lane import RATE, Lane, Throw
from mgjax.stage.apps.throw.replay import replay_show
from mgjax.stage.apps.throw.scene import live_show
from mgjax.stage.apps.throw.series import Series
from mgjax.stage.apps.throw.settings import (
    START,
    BallSettings,
    settings_json,
    with_ball,
    with_search,
)
from mgjax.stage.apps.throw.study import Study
from mgjax.stage.apps.throw.words import expected, figures, outcome
from mgjax.stage.serve.exports import FORMATS, html_file, motion_file
from mgjax.stage.serve.fields import flag, number, point, text, whole
from mgjax.stage.serve.film import file_message
from mgjax.stage.serve.session import Message, Send
from mgjax.stage.show.types import show_value

APART_M = 2.5
"""So far beside the first the second character begins."""
CLOCK_S = 1.0
"""How often the page is told the time."""
MOST_UNDER_WAY = 6
"""Balls in the air at once."""
EXPORT_S = 30.0
"""So much of what was played is written as a motion."""


class ThrowSession:
    """One page: a character or two, the balls in the air, and what is asked about them.

    Args:
        prepared: of the graph.
        send: to the page.
        seed: of all that is drawn.
        clock: of the session; default: real time.
        searches: where a character searches; default: a thread of its own.
    """

    def __init__(
        self,
        prepared: Prepared,
        send: Send,
        *,
        seed: int = 0,
        clock: SessionClock | None = None,
        searches: Callable[[], Searches] = ThreadSearches,
    ) -> None:
        self._prepared, self._send = prepared, send
        self._clock = clock or SessionClock()
        self._searches = searches
        self._seed = seed
        self._rng = np.random.default_rng(seed)
        self._ball = BallSettings()
        self._lanes: list[Lane] = []
        self._told = -1.0
        self._pace = 1.0
        self._aside = False
        self._series = Series(send)
        self._study = Study(self._rng)
        self._lanes.append(self._lane(0, np.zeros(3)))
        send(
            {
                "type": "ready",
                "app": "throw",
                "title": "Throw",
                "options": {
                    "settings": settings_json(self._ball, self._lanes[0].config),
                    "formats": list(FORMATS),
                },
            }
        )
        self._show_scene()

    def receive(self, message: Message) -> None:
        """A message of the page; see the class."""
        handlers = {
            "throw": self._throw,
            "settings": self._settings,
            "pace": self._set_pace,
            "ten": self._begin_series,
            "second": self._second,
            "replay": self._replay,
            "live": self._live,
            "compare": self._compare,
            "pick": self._pick,
            "picks": self._download_picks,
            "export": self._export,
        }
        kind = message["type"]
        if kind not in handlers:
            raise ConfigError(got=f"a message of type {kind!r:.40}", expected=", ".join(handlers))
        handlers[kind](message)

    def tick(self) -> None:
        if self._aside or not self._lanes:
            return
        now = self._clock.now()
        for lane in self._lanes:
            lane.tick()
        if now >= self._told + CLOCK_S * max(self._pace, 0.1):
            self._tell_clock()
        if self._series.wants_ball(self._lanes[0].busy):
            self._throw_series_ball()

    def close(self) -> None:
        for lane in self._lanes:
            lane.close()
        self._lanes = []

    def _lane(self, number: int, start: Float[np.ndarray, "3"]) -> Lane:
        return Lane(
            number,
            self._prepared,
            self._clock,
            self._searches(),
            self._send,
            self._tell,
            config=START,
            seed=self._seed + 1000 * number,
            start=start,
        )

    # What is shown ----------------------------------------------------------------------------

    def _show_scene(self) -> None:
        """The live scene from scratch, as after a replay."""
        now = self._clock.now()
        show = live_show(self._lanes, now)
        self._send({"type": "note", "event": "scene", "show": show_value(show)})
        for lane in self._lanes:
            for throw in lane.throws:
                if throw.attack.end > now:
                    lane.show_ball(throw)
        self._tell_clock()

    def _tell_clock(self) -> None:
        self._told = self._clock.now()
        pace = 0.0 if self._aside else self._pace
        self._send({"type": "note", "event": "clock", "now": self._told, "pace": pace})

    def _tell(self, lane: Lane, throw: Throw) -> None:
        """A search or a check has ended."""
        graph = self._prepared.graph
        note: Message = {"type": "note", "lane": lane.number, "number": throw.number}
        if throw.answer is not None:
            words, tone = outcome(graph, throw.answer, throw.found, throw.contact)
            note |= {"event": "answer", "words": words, "tone": tone}
            note |= {"late": throw.answer.search == "late", "hit": throw.answer.hit}
            if lane.number == 0:
                self._series.note(not throw.answer.hit and throw.answer.limb is None)
        elif throw.found is not None:
            note |= {"event": "found", "words": expected(graph, throw.found), "tone": "busy"}
        note |= figures(lane.config, throw.found)
        self._send(note)

    # What is asked ----------------------------------------------------------------------------

    def _throw(self, message: Message) -> None:
        eye, through = point(message, "from"), point(message, "to")
        if float(np.linalg.norm(through - eye)) < 1e-6:
            raise ConfigError(got="a ray from a place to itself", expected="a direction")
        chosen = whole(message, "lane", 0, len(self._lanes) - 1) if "lane" in message else 0
        if sum(t.answer is None for t in self._lanes[0].throws) >= MOST_UNDER_WAY:
            raise ConfigError(
                got=f"{MOST_UNDER_WAY + 1} balls at once", expected=f"at most {MOST_UNDER_WAY}"
            )
        now = self._clock.now()
        lane = self._lanes[chosen]
        root = lane.predicted_root(now)
        goal = (
            point(message, "place")
            if message.get("place") is not None
            else passing_point(eye, through, root)
        )
        ahead = lane.predicted_root(now + self._ball.notice) - root
        goal = goal + np.array([ahead[0], 0.0, ahead[2]])
        attack = thrown_along(eye, through, goal, now, self._ball)
        if attack.end <= now + 0.2:
            raise AttackError(got="a ball that is there at once", expected="some time to see it")
        self._throw_at_all(lane, attack)

    def _throw_at_all(self, lane: Lane, attack: Attack) -> None:
        """At one character, and at the others as it flies in that one's frame."""
        own = lane.frame_now()
        for each in self._lanes:
            same = attack
            if each is not lane:
                move = planar.compose(each.frame_now(), np.asarray(planar.inverse(own)))
                same = in_frame(attack, np.asarray(planar.inverse(np.asarray(move))), 0.0)
            throw = each.throw(same)
            self._send(
                {"type": "note", "event": "thrown", "lane": each.number, "number": throw.number}
            )

    def _settings(self, message: Message) -> None:
        ball = with_ball(self._ball, message)
        lane = self._lanes[whole(message, "lane", 0, len(self._lanes) - 1)]
        config = with_search(lane.config, message)
        lane.configure(config)
        self._ball = ball

    def _set_pace(self, message: Message) -> None:
        self._pace = number(message, "pace", 0.0, 4.0)
        self._clock.run(self._pace)
        self._tell_clock()

    def _begin_series(self, message: Message) -> None:
        if self._series.begin():
            self._throw_series_ball()

    def _throw_series_ball(self) -> None:
        lane, now = self._lanes[0], self._clock.now()
        centre = lane.predicted_root(now + self._ball.notice)
        self._throw_at_all(lane, thrown_at_random(self._rng, centre, now, self._ball))

    def _second(self, message: Message) -> None:
        wanted = flag(message, "on")
        if wanted and len(self._lanes) == 1:
            place = planar.compose(self._lanes[0].frame_now(), np.array([0.0, APART_M, 0.0]))
            self._lanes.append(self._lane(1, np.asarray(place)))
        elif not wanted and len(self._lanes) == 2:
            self._lanes.pop().close()
        self._show_scene()

    def _last_throw(self) -> Throw:
        """The last throw at the first character that is over."""
        over = [t for t in self._lanes[0].throws if t.answer is not None]
        if not over:
            raise ConfigError(got="no throw that is over", expected="one: click on the body")
        return over[-1]

    def _replay(self, message: Message) -> None:
        show = replay_show(self._lanes[0], self._last_throw(), ghosts=flag(message, "ghosts"))
        self._leave()
        self._send({"type": "show", "show": show_value(show)})

    def _leave(self) -> None:
        """The live scene stands still while something else is shown."""
        self._aside = True
        self._clock.run(0.0)
        self._tell_clock()

    def _live(self, message: Message) -> None:
        self._aside = False
        self._study.give_up()
        self._clock.run(self._pace)
        self._show_scene()

    def _compare(self, message: Message) -> None:
        show = self._study.ask(self._lanes[0], self._last_throw())
        self._leave()
        self._send({"type": "show", "show": show_value(show)})
        self._send({"type": "note", "event": "trial", "letters": self._study.letters})

    def _pick(self, message: Message) -> None:
        self._send({"type": "note", "event": "picked"} | self._study.pick(message))

    def _export(self, message: Message) -> None:
        """The last throw as a page, or what was played in the last half minute as a motion."""
        form = text(message, "format", FORMATS)
        if form == "html":
            show = replay_show(self._lanes[0], self._last_throw(), ghosts=False)
            self._send(html_file("throw", show))
            return
        now = self._clock.now()
        times = np.arange(max(now - EXPORT_S, 0.0), now, 1 / RATE)
        if len(times) < 2:
            raise ConfigError(got="a motion that has just begun", expected="a moment more")
        motion = self._lanes[0].planner.timeline.sample(times)
        skeleton = self._prepared.graph.skeleton
        self._send(motion_file("motion", form, skeleton, replace(motion, frame_rate=RATE)))

    def _download_picks(self, message: Message) -> None:
        self._send(file_message("picks.jsonl", "application/jsonl", self._study.file()))
