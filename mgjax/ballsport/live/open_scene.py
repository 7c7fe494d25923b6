"""A scene without an end: passes are asked for one by one, while what is certain is played."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.scene.ball_track import BallEvent, track_ball
from mgjax.ballsport.scene.build import Scene, make_scene
from mgjax.ballsport.scene.config import Pass, SceneConfig, validate_scene
from mgjax.ballsport.scene.gaze import gaze_frames, look_at
from mgjax.ballsport.scene.rally import Rally
from mgjax.ballsport.scene.types import THROWN_IN, BallFlight, Choose, Touch
from mgjax.core.errors import ConfigError
from mgjax.core.motion import Motion, cut

NextPass = Callable[[str], Pass | None]
"""Asked for the pass of a player, at the last moment at which it can be planned; None: there is
none, the ball goes to nobody, and the players idle until there is one."""

_IDLE_S = 0.5
"""How far ahead of what is asked for idling is made certain, s."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ScenePart:
    """Some frames of an open scene, which do not change any more.

    Attributes:
        start: the first, scene frame.
        motions: of each player by name, all of one length.
    """

    start: int
    motions: Mapping[str, Motion]


class OpenScene:
    """Rallies one after the other, planned pass by pass (Choi et al. 2019, §4–5).

    A touch is planned just before the ball is launched to it, as late as heads need to know where
    the ball goes. So whoever decides passes has until then; what is played is never changed.

    Args:
        config: players, physics and net; its passes are not looked at.
        moves: what players can do.
        first: who is thrown the first ball.
        next_pass: decides.
        choose: decides the hits of passes whose kind is "any".

    Attributes:
        touches: so far, numbered through all rallies.
        flights: so far, likewise.
        ends: by whom and to whom each flight goes, "" for nobody.
        arrivals: where the ball is at the end of each flight, m. [3] each
        events: of the ball, in order of time.
        holder: whose pass is asked for next.

    Raises:
        ConfigError: players that cannot be.
    """

    def __init__(
        self,
        config: SceneConfig,
        moves: Repertoire,
        *,
        first: str,
        next_pass: NextPass,
        choose: Choose | None = None,
    ) -> None:
        self.rate = moves.frame_rate
        self.holder = first
        self._config, self._moves = replace(config, passes=()), moves
        self._next, self._choose = next_pass, choose
        other = next((p.name for p in config.players if p.name != first), "")
        self._rally = self._new_rally(Pass(by=first, to=other), None, 0)
        self._over = True
        self._ball: Float[np.ndarray, "F 3"] = np.zeros((0, 3))
        self._reach = gaze_frames(self.rate)
        self.touches: list[Touch] = []
        self.flights: list[BallFlight] = []
        self.ends: list[tuple[str, str]] = []
        self.arrivals: list[Float[np.ndarray, "3"]] = []
        self.events: list[BallEvent] = []

    @property
    def names(self) -> tuple[str, ...]:
        """Of the players."""
        return tuple(player.name for player in self._config.players)

    @property
    def certain(self) -> int:
        """Frames from the beginning that do not change any more."""
        return max(len(self._ball) - self._reach, 0)

    @property
    def waits(self) -> bool:
        """Whether the ball is nobody's, and the next pass begins with a throw."""
        return self._over

    @property
    def ball(self) -> Float[np.ndarray, "F 3"]:
        """The ball's centre in all frames that are known, some of which are not certain, m."""
        return self._ball

    def advance(self, until: int) -> ScenePart | None:
        """Plans until that many frames are certain; returns the new ones, if any.

        Raises:
            ConfigError: a pass that cannot be begun; nothing has changed then.
        """
        before = self.certain
        while self.certain < until:
            wanted = self._next(self.holder) if self._asks else None
            if self._over and wanted is None:
                self._go_on(until + round(_IDLE_S * self.rate) + self._reach)
            elif self._over and wanted is not None:
                self._begin(wanted)
            else:
                self._plan(wanted)
        return None if self.certain == before else self.part(before, self.certain)

    def part(self, start: int, stop: int) -> ScenePart:
        """Frames that are certain."""
        if not 0 <= start < stop <= self.certain:
            raise ConfigError(got=f"frames {start}…{stop}", expected=f"within 0…{self.certain}")
        first, last = max(start - self._reach, 0), min(stop + self._reach, len(self._ball))
        skeleton = self._moves.clips.skeleton
        motions = {
            name: cut(
                look_at(skeleton, actor.part(first, last), self._ball[first:last]),
                start - first,
                stop - first,
            )
            for name, actor in self._rally.actors.items()
        }
        return ScenePart(start=start, motions=motions)

    def scene(self) -> Scene:
        """All that has been planned, as a scene that is over.

        Raises:
            ConfigError: there is no touch yet.
        """
        if not self.touches:
            raise ConfigError(got="no pass yet", expected="at least one to make a scene of")
        passes = tuple(
            Pass(by=by, to=to, bounces=flight.bounces)
            for (by, to), flight in zip(self.ends, self.flights, strict=True)
            if flight.number != THROWN_IN and to
        )
        return make_scene(
            replace(self._config, passes=passes),
            self._moves,
            {name: actor.copy() for name, actor in self._rally.actors.items()},
            touches=self.touches,
            flights=self.flights,
            ends=self.ends,
        )

    @property
    def _asks(self) -> bool:
        """Whether the pass after the next touch is not known yet."""
        return self._over or len(self._rally.touches) == len(self._rally.config.passes)

    def _new_rally(self, first: Pass, actors: Mapping | None, begin: int) -> Rally:
        config = replace(self._config, passes=(first,))
        validate_scene(config)
        return Rally(config, self._moves, self._choose, actors=actors, begin=begin)

    def _begin(self, first: Pass) -> None:
        """A ball will be thrown in to whoever passes it first."""
        self._rally = self._new_rally(first, self._rally.actors, len(self._ball))
        self._over, self.holder = False, first.to
        self._go_on(self._rally.launch_frame)

    def _plan(self, wanted: Pass | None) -> None:
        """Plans the next touch; without a pass after it, it is the last."""
        rally = self._rally
        if wanted is not None:
            rally.extend(wanted)
            self.holder = wanted.to
        plan = rally.plan()
        number, known = len(rally.touches), len(rally.flights)
        offset = len(self.touches) - number
        by = "" if plan.flight.number == THROWN_IN else rally.order[number - 1]
        rally.commit(plan)
        self._add(rally.flights[known], (by, plan.player), offset)
        if plan.touch is not None:
            self.touches.append(replace(plan.touch, number=number + offset))
        self._go_on(rally.launch_frame)
        if rally.done:
            self._over = True
            self._add(rally.flights[-1], (plan.player, ""), offset)
            self._go_on(rally.flights[-1].stop)

    def _add(self, flight: BallFlight, ends: tuple[str, str], offset: int) -> None:
        number = flight.number + offset if flight.number != THROWN_IN else THROWN_IN
        self.flights.append(replace(flight, number=number))
        self.ends.append(ends)

    def _go_on(self, until: int) -> None:
        """Makes everybody's motion certain up to a frame, and the ball's path with it."""
        since = len(self._ball)
        if until <= since:
            return
        for actor in self._rally.actors.values():
            if actor.time < until:
                actor.idle_until(until, since=since)
        self._ball = np.concatenate([self._ball, self._flown(since, until)])

    def _flown(self, since: int, until: int) -> Float[np.ndarray, "F 3"]:
        """The ball in some frames of the newest flight; before the first throw where it will be."""
        if not self.flights:
            return np.tile(self._rally.launch_place, (until - since, 1))
        last, ends = self.flights[-1], self.ends[-1]
        local = replace(last, start=0, stop=last.stop - last.start)
        end = replace(local, start=until - last.start, stop=until - last.start)
        track = track_ball((local, end), (ends, ("", "")), self.rate, self._config.physics)
        if len(self.arrivals) < len(self.flights):
            self.arrivals.append(track.arrivals[0])
        for event in track.events:
            time = event.time + last.start / self.rate
            if event.flight == 0 and since <= time * self.rate + 1e-6 < until:
                self.events.append(replace(event, time=time, flight=len(self.flights) - 1))
        return track.places[since - last.start : until - last.start]
