"""A rally, planned touch by touch: each is chosen before the pass to it is launched."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.scene.config import Pass, SceneConfig, validate_scene
from mgjax.ballsport.scene.kick import Kick, choose_kick
from mgjax.ballsport.scene.launching import Launcher
from mgjax.ballsport.scene.planning import (
    Plan,
    Request,
    heading_of,
    plan_touch,
    unasked_hits,
    user_hit,
    user_may_decide,
)
from mgjax.ballsport.scene.player import Actor, new_actor
from mgjax.ballsport.scene.types import THROWN_IN, BallFlight, BallStart, Choose, Touch
from mgjax.core.errors import ConfigError

_LAST_DISTANCE_M = 2.0
"""How far the last touch is meant to send the ball, to nobody."""
_TARGET_HEIGHT_M = 0.45
"""Height at which the next touch is expected before it is chosen."""
_REACH_M = 0.4
"""How far ahead of the body a touch is expected before it is chosen."""
_REACTION_S = 0.2
"""From the launch of a ball to the first step of who turns to it."""
_TOLERANCE = np.radians(35.0)
"""Players turn once the ball is further off than this; nearer, the head is enough."""
_BUSY_S = 0.4
"""Who still turns for longer than this after a launch does not turn again for it."""
_LEAD_S = 1.6
"""From the beginning of the scene to the throw."""
_AGAIN_S = 1.0
"""From the end of a pass that could not be to the next throw."""


class Rally:
    """Players, touches and flights so far; :meth:`step` plans the next touch.

    Live: call ``step`` once the user's motion for touch k + 1 is known, at the latest when touch k
    launches the ball; until then its player idles. What has been planned is never changed.

    Args:
        config: the scene.
        moves: what players can do.
        choose: decides hits of passes whose kind is "any".
        actors: players of a rally that is over, who go on; None: they begin where they stand.
        begin: scene frame at which the rally begins, before which nothing changes; None: at 0, and
            the passes are all there are. Else there may come more by :meth:`extend`, and what is
            played before the ball is launched to a touch is certain when that touch is planned.
    """

    def __init__(
        self,
        config: SceneConfig,
        moves: Repertoire,
        choose: Choose | None = None,
        *,
        actors: Mapping[str, Actor] | None = None,
        begin: int | None = None,
    ) -> None:
        self.config, self.moves, self._choose = config, moves, choose
        self.rate = moves.frame_rate
        self._live = begin is not None
        homes = {p.name: np.array([p.x, 0.0, p.z]) for p in config.players}
        self._launcher = Launcher(
            config=config, rate=self.rate, middle=np.mean(list(homes.values()), axis=0)
        )
        self.order = [*(item.by for item in config.passes), config.passes[-1].to]
        self.actors = self._idle_actors(homes) if actors is None else dict(actors)
        self.touches: list[Touch] = []
        self.flights: list[BallFlight] = []
        begin = begin or 0
        self._launch_times = [begin]
        self._start = self._launcher.throw_in(begin + round(_LEAD_S * self.rate))

    def _idle_actors(self, homes: dict[str, np.ndarray]) -> dict[str, Actor]:
        """All players at home, turned to where the ball comes from, at different idle frames."""
        moves, server = self.moves, self.order[0]
        begins = np.linspace(0, 0.5, len(homes) if self._live else len(self.config.passes) + 1)
        run = [moves.starts[moves.idle[0]], moves.stops[moves.idle[-1]]]
        actors: dict[str, Actor] = {}
        for number, (name, home) in enumerate(homes.items()):
            goal = self._launcher.middle if name == server else homes[server]
            stand = (heading_of(goal - home), home[0], home[2])
            begin = int(run[0] + begins[number % len(begins)] * (run[1] - run[0]))
            actors[name] = new_actor(moves, stand, begin)
        return actors

    @property
    def done(self) -> bool:
        """Whether all touches are planned."""
        return len(self.touches) == len(self.order)

    @property
    def launch_frame(self) -> int:
        """Scene frame at which the ball is launched to the next touch; the last one when done."""
        return self._start.time

    @property
    def launch_place(self) -> Float[np.ndarray, "3"]:
        """Where the ball's centre is then, m."""
        return self._start.place

    def extend(self, item: Pass) -> None:
        """Adds a pass after the last one, before the touch that makes it is planned.

        Raises:
            ConfigError: a pass that cannot be, or the rally is over.
        """
        if self.done:
            raise ConfigError(
                f"got a pass by {item.by!r} to a rally that is over, expected a new one"
            )
        config = replace(self.config, passes=(*self.config.passes, item))
        validate_scene(config)
        self.config = config
        self.order.append(item.to)

    def step(self) -> None:
        """Plans the next touch and with it the flight that leads to it, throws included."""
        planned = len(self.touches)
        while len(self.touches) == planned:
            self.commit(self.plan())

    def plan(self) -> Plan:
        """Chooses the next touch, or where no flight meets its player the flight that misses.

        Nothing is changed until :meth:`commit`; but whoever decides hits has been asked.

        Raises:
            ConfigError: a throw that cannot reach the player, or a touch without a usable hit.
        """
        number = len(self.touches)
        player = self.order[number]
        decided = user_hit(
            self.config,
            self.moves,
            self._choose,
            number=number,
            player=player,
            deadline_s=self._start.time / self.rate,
        )
        kick = self._kick(number, decided)
        request = Request(
            number=number,
            player=player,
            kick=kick,
            heading=self._next_touch(number)[0] - kick.aside,
            now=self._launch_times[-1] if decided is None and not self._live else self._start.time,
            by_user=decided is not None,
            start=self._start,
            bystanders=self._bystanders(number),
        )
        return plan_touch(self._launcher, self.actors[player], request)

    def commit(self, plan: Plan) -> None:
        """Makes a plan part of the rally; after a miss a ball is thrown in."""
        self.actors[plan.player] = plan.actor
        self.flights.append(plan.flight)
        if plan.touch is None:
            again = plan.flight.stop + round(_AGAIN_S * self.rate)
            self._start = self._launcher.throw_in(again)
            return
        self._launch_times.append(plan.flight.start)
        self.touches.append(plan.touch)
        self._turn_players(plan.touch.number, plan.flight)
        self._start_from(plan.touch)

    def _start_from(self, touch: Touch) -> None:
        """The next ball starts where a touch meets it; after the last one it goes to nobody."""
        self._start = BallStart(
            number=touch.number,
            time=touch.time,
            place=touch.centre,
            bone=touch.bone,
            bounces=0 if self.done else self.config.passes[touch.number].bounces,
        )
        if self.done:
            self.flights.append(self._launcher.last(touch))

    def _next_touch(self, number: int) -> tuple[float, float]:
        """Direction and length over the floor from a touch's player to the next touch."""
        stands = {name: actor.stand for name, actor in self.actors.items()}
        places = {name: np.array([x, 0.0, z]) for name, (_, x, z) in stands.items()}
        home = places[self.order[number]]
        if number + 1 == len(self.order):
            return heading_of(places[self.order[number - 1]] - home), _LAST_DISTANCE_M
        receiver = places[self.order[number + 1]]
        after = home
        if number + 2 < len(self.order):
            after = places[self.order[number + 2]]
        ahead = after - receiver
        touch = receiver + _REACH_M * ahead / np.linalg.norm(ahead)
        return heading_of(touch - home), float(np.linalg.norm(touch - home))

    def _kick(self, number: int, decided: int | None) -> Kick:
        """The stored hit of a touch and its frame: the one that was decided, or what suits the next
        touch.
        """
        config = self.config
        hits = [decided] if decided is not None else unasked_hits(config, self.moves, number)
        return choose_kick(
            self.moves,
            hits,
            self._next_touch(number)[1],
            height=_TARGET_HEIGHT_M,
            bounces=1 if number == len(config.passes) else config.passes[number].bounces,
            physics=config.physics,
            max_speed=config.max_speed,
        )

    def _bystanders(self, number: int) -> list[np.ndarray]:
        """Where players stand who take no part in the flight to a touch, m."""
        out = {self.order[number]}
        if number and self._start.number != THROWN_IN:
            out.add(self.order[number - 1])
        stands = [actor.stand for name, actor in self.actors.items() if name not in out]
        return [np.array([x, 0.0, z]) for _, x, z in stands]

    def _middle_without(self, name: str) -> Float[np.ndarray, "3"]:
        """Between the others: from there the least has to be turned, whoever gets the ball."""
        places = [(p.x, 0.0, p.z) for p in self.config.players if p.name != name]
        return np.mean(places, axis=0)

    def _turn_players(self, number: int, flight: BallFlight) -> None:
        """After a launch players who are free turn: to where the ball goes, or to be ready.

        Who hits within the next two touches turns only once, into the direction of that hit.
        """
        now = flight.start + round(_REACTION_S * self.rate)
        ready, soon = [*self.order[number + 1 : number + 3], None, None][:2]
        unknown = self._live or user_may_decide(self.config, self._choose, number + 1)
        for name, actor in self.actors.items():
            waits = name == soon or (name == ready and not unknown)
            if name == self.order[number] or waits:
                continue
            if actor.time > now + round(_BUSY_S * self.rate):
                continue
            _, x, z = actor.stand
            if name == ready and self._live and number + 1 == len(self.config.passes):
                heading = heading_of(self._middle_without(name) - np.array([x, 0.0, z]))
            elif name == ready:
                heading = self._next_touch(number + 1)[0]
            else:
                heading = heading_of(flight.target - np.array([x, 0.0, z]))
            actor.face(heading, now=now, tolerance=_TOLERANCE)
            actor.idle_until(max(now, actor.time))
