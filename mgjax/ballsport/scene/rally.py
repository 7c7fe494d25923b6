"""A rally, planned touch by touch: each is chosen before the pass to it is launched."""

from __future__ import annotations

import numpy as np

from mgjax.ballsport.aiming.passes import aim
from mgjax.ballsport.aiming.solve import OK
from mgjax.ballsport.aiming.timed import aim_timed
from mgjax.ballsport.ball.trajectory import fly
from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.scene.config import SceneConfig
from mgjax.ballsport.scene.flight_cost import cheapest, flight_cost
from mgjax.ballsport.scene.kick import Kick, choose_kick
from mgjax.ballsport.scene.link_paths import Chains
from mgjax.ballsport.scene.player import Actor, new_actor
from mgjax.ballsport.scene.types import THROWN, Asked, Choose, Launch, Leg, Touch
from mgjax.core import planar
from mgjax.core.errors import ConfigError

_LAST_WAY_M = 2.0
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
_SHORTEST_S, _LONGEST_S, _EVERY = 0.3, 4.0, 2
"""Flight times that are looked at, the last in frames."""
_CHOICE_S = 3.0
"""Ways to a hit are to last up to this and more; else the player idles before."""
_TRIES = 12
"""Arrivals that are tried with the exact place, in rising order of their cost."""
_LEAD_S = 1.6
"""From the beginning of the scene to the throw."""
_AGAIN_S = 1.0
"""From the end of a pass that could not be to the next throw."""


class Rally:
    """Players, touches and legs so far; :meth:`step` plans the next touch.

    Live: call ``step`` once the user's motion for touch k + 1 is known, at the latest when touch k
    launches the ball; until then its player idles. What has been planned is never changed.

    Args:
        config: the scene.
        moves: what players can do.
        choose: decides hits of passes whose kind is "any".
    """

    def __init__(
        self, config: SceneConfig, moves: Repertoire, choose: Choose | None = None
    ) -> None:
        self.config, self.moves, self._choose = config, moves, choose
        self.rate = moves.frame_rate
        self.homes = {p.name: np.array([p.x, 0.0, p.z]) for p in config.players}
        self.middle = np.mean(list(self.homes.values()), axis=0)
        names = [item.by for item in config.passes]
        self.order = [*names, config.passes[-1].to]
        begins = np.linspace(0, 0.5, len(names) + 1)
        begins = {n: begins[i % len(begins)] for i, n in enumerate(self.homes)}
        run = [moves.starts[moves.idle[0]], moves.stops[moves.idle[-1]]]
        first = self.homes[self.order[0]]
        self.actors: dict[str, Actor] = {}
        for name, home in self.homes.items():
            to = self.middle if name == self.order[0] else first
            stand = (_heading(to - home), home[0], home[2])
            begin = int(run[0] + begins[name] * (run[1] - run[0]))
            self.actors[name] = new_actor(moves, stand, begin)
        self.touches: list[Touch] = []
        self.legs: list[Leg] = []
        self._launches = [0]
        self._launch = self._throw(round(_LEAD_S * self.rate))

    @property
    def done(self) -> bool:
        """Whether all touches are planned."""
        return len(self.touches) == len(self.order)

    def step(self) -> None:
        """Plans the next touch and with it the leg that leads to it."""
        number = len(self.touches)
        player = self.order[number]
        given = self._given(number, player)
        now = self._launch.time if given is not None else self._launches[-1]
        kick = self._kick(number, given)
        heading = self._way(number)[0] - kick.aside
        if not self._arrive(number, kick, heading, now, given is not None):
            if self._launch.number == THROWN:
                raise ConfigError(
                    f"got a throw from {_shown(self._launch.place)} to {player}, expected one that"
                    f" reaches the player at up to {self.config.max_speed:g} m/s"
                )
            self._miss(number, kick, heading)
            return self.step()
        self._launches.append(self._launch.time)
        self._turn_all(number)
        touch = self.touches[-1]
        last = number + 1 == len(self.order)
        bounces = 0 if last else self.config.passes[number].bounces
        self._launch = Launch(
            number=number, time=touch.time, place=touch.centre, bone=touch.bone, bounces=bounces
        )
        if last:
            self._end(touch)
        return None

    def _throw(self, time: int) -> Launch:
        place = self.config.throw_in
        over = self.middle + np.array([0.0, 1.3, 0.0])
        over = over if place is None else np.array(place, np.float64)
        return Launch(number=THROWN, time=time, place=over, bone=None, bounces=0)

    def _end(self, touch: Touch) -> None:
        """The last ball goes as the bone sends it."""
        stop = touch.time + round(self.config.end_s * self.rate)
        time = np.array([(stop - touch.time) / self.rate], np.float32)
        flown = fly(
            touch.centre.astype(np.float32),
            touch.bone.astype(np.float32),
            time,
            physics=self.config.physics,
        )
        self.legs.append(
            Leg(
                number=touch.number,
                start=touch.time,
                stop=stop,
                place=touch.centre,
                velocity=touch.bone,
                target=np.asarray(flown, np.float64)[0],
                bounces=0,
                status=OK,
                miss=0.0,
            )
        )

    def _given(self, number: int, player: str) -> int | None:
        """The hit that the user's motion decides."""
        if self._choose is None or not self._by_user(number):
            return None
        hits = self._hits(number)
        deadline = self._launch.time / self.rate
        hit = self._choose(
            Asked(touch=number, player=player, deadline_s=deadline, hits=tuple(hits))
        )
        if hit is not None and hit not in hits:
            raise ConfigError(f"touch {number + 1}: got hit {hit}, expected one of {hits}")
        return hit

    def _by_user(self, number: int) -> bool:
        """Whether the user's motion may decide a touch."""
        passes = self.config.passes
        return self._choose is not None and number < len(passes) and passes[number].kind == "any"

    def _hits(self, number: int) -> list[int]:
        """Stored hits that a touch may be."""
        last = number == len(self.config.passes)
        kind = "toss" if last else self.config.passes[number].kind
        bone = "any" if last else self.config.passes[number].bone
        clips = self.moves.clips
        found = [
            hit
            for hit in self.moves.touch
            if kind in ("any", clips.hit_kind[hit]) and bone in ("any", clips.hit_bone[hit])
        ]
        if not found:
            raise ConfigError(f"touch {number + 1}: got no stored {kind} by {bone}, expected one")
        return found

    def _way(self, number: int) -> tuple[float, float]:
        """Direction and length over the floor from a touch's player to the next touch."""
        stands = {name: actor.stand for name, actor in self.actors.items()}
        places = {name: np.array([x, 0.0, z]) for name, (_, x, z) in stands.items()}
        home = places[self.order[number]]
        if number + 1 == len(self.order):
            return _heading(places[self.order[number - 1]] - home), _LAST_WAY_M
        there = places[self.order[number + 1]]
        after = home
        if number + 2 < len(self.order):
            after = places[self.order[number + 2]]
        ahead = after - there
        there = there + _REACH_M * ahead / np.linalg.norm(ahead)
        return _heading(there - home), float(np.linalg.norm(there - home))

    def _kick(self, number: int, given: int | None) -> Kick:
        config = self.config
        last = number == len(config.passes)
        hits = [given] if given is not None else self._hits(number)
        if given is None and not last and config.passes[number].kind == "any":
            kinds = self.moves.clips.hit_kind
            hits = [hit for hit in hits if kinds[hit] != "attack"] or hits
        return choose_kick(
            self.moves,
            hits,
            self._way(number)[1],
            height=_TARGET_HEIGHT_M,
            bounces=1 if last else config.passes[number].bounces,
            physics=config.physics,
            max_speed=config.max_speed,
        )

    def _ways(self, actor: Actor, kick: Kick, heading: float, now: int) -> Chains:
        actor.settle(now)
        targets = self.moves.before[kick.hit]
        chains = actor.ways(targets, now=now, turn=actor.turn_to(heading))
        least = now - actor.time + round(_CHOICE_S * self.rate)
        if chains.frames.max(initial=0) < least:  # the link motion after a hit is soon over
            actor.idle_until(max(now, actor.time))
            chains = actor.ways(targets, now=now, turn=actor.turn_to(heading))
        if not len(chains.frames):
            raise ConfigError(f"got no link motion into hit {kick.hit}, expected one")
        return chains

    def _arrive(self, number: int, kick: Kick, heading: float, now: int, by_user: bool) -> bool:
        """Chooses flight time and links together; False where no flight meets the player."""
        actor, launch = self.actors[self.order[number]], self._launch
        start = int(self.moves.clips.hit_starts[kick.hit])
        chains = self._ways(actor, kick, heading, now)
        begin = max(now, actor.time)
        # Frames that may be warped, and those from the first frame of S_H to the contact.
        free = chains.frames + (start - chains.entry) - (begin - actor.time)
        fixed = kick.frame - start
        times = np.arange(
            launch.time + round(_SHORTEST_S * self.rate),
            launch.time + round(_LONGEST_S * self.rate),
            _EVERY,
        )
        target = self._expected(actor, kick, heading)
        velocities, met = self._launches_at(np.tile(target, (len(times), 1)), times)
        seconds = (times - launch.time) / self.rate
        flight = flight_cost(
            launch, velocities, met, seconds, self._others(number), self.config.physics
        )
        order = cheapest(chains, free, fixed, begin, times, flight)
        tried: set[int] = set()
        for row, column in order:
            if len(tried) >= _TRIES or column in tried:
                continue
            tried.add(column)
            place = actor.placed(chains.hops[row])
            centre = self._centre(place, kick)
            one = times[column : column + 1]
            velocity, hits = self._launches_at(centre[None], one)
            if not hits[0]:
                continue
            plane = self.moves.clips.planes[start].astype(np.float64)
            turn = np.array([place[0] + plane[0], 0.0, 0.0])
            warp = actor.hit(chains, row, kick, now=now, time=int(one[0]))
            self.touches.append(
                Touch(
                    number=number,
                    player=self.order[number],
                    kick=kick,
                    time=int(one[0]),
                    centre=centre,
                    bone=np.asarray(planar.apply(turn, kick.velocity)),
                    warp=warp,
                    cost=float(chains.cost[row]),
                    by_user=by_user,
                )
            )
            self._fly(int(one[0]), velocity[0], centre, OK, 0.0)
            return True
        return False

    def _fly(
        self, stop: int, velocity: np.ndarray, target: np.ndarray, status: int, miss: float
    ) -> None:
        launch = self._launch
        self.legs.append(
            Leg(
                number=launch.number,
                start=launch.time,
                stop=stop,
                place=launch.place,
                velocity=velocity.astype(np.float64),
                target=target,
                bounces=launch.bounces,
                status=status,
                miss=miss,
            )
        )

    def _miss(self, number: int, kick: Kick, heading: float) -> None:
        """A pass that cannot be: it goes as near as it can, and a ball is thrown in."""
        launch, config = self._launch, self.config
        assert launch.bone is not None
        target = self._expected(self.actors[self.order[number]], kick, heading)
        nearest = aim(
            launch.place.astype(np.float32),
            target.astype(np.float32),
            bounces=launch.bounces,
            guess=launch.bone.astype(np.float32),
            physics=config.physics,
            max_speed=config.max_speed,
            net=config.net,
        )
        stop = launch.time + max(1, round(float(nearest.time) * self.rate))
        self._fly(
            stop, np.asarray(nearest.velocity), target, int(nearest.status), float(nearest.miss)
        )
        self._launch = self._throw(stop + round(_AGAIN_S * self.rate))

    def _centre(self, placement: np.ndarray, kick: Kick) -> np.ndarray:
        """Where the ball is at the contact if the hit's clip is placed so."""
        row = int(np.flatnonzero(self.moves.touch[kick.hit].frames == kick.frame)[0])
        return np.asarray(planar.apply(placement, self.moves.touch[kick.hit].centres[row]))

    def _expected(self, actor: Actor, kick: Kick, heading: float) -> np.ndarray:
        """The same before it is known how the player gets there."""
        _, x, z = actor.stand
        return np.asarray(planar.apply(np.array([heading, x, z]), kick.centre))

    def _launches_at(self, targets: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        launch, config = self._launch, self.config
        seconds = (times - launch.time) / self.rate
        guess = launch.bone
        if guess is None:
            guess = (targets[0] - launch.place) + np.array([0.0, 2.0, 0.0])
        return aim_timed(
            np.tile(launch.place, (len(times), 1)),
            targets,
            seconds,
            bounces=launch.bounces,
            guesses=np.tile(guess, (len(times), 1)),
            physics=config.physics,
            max_speed=config.max_speed,
            net=config.net,
        )

    def _others(self, number: int) -> list[np.ndarray]:
        """Where players stand who take no part in the leg to a touch."""
        out = {self.order[number]}
        if number and self._launch.number != THROWN:
            out.add(self.order[number - 1])
        stands = [actor.stand for name, actor in self.actors.items() if name not in out]
        return [np.array([x, 0.0, z]) for _, x, z in stands]

    def _turn_all(self, number: int) -> None:
        """After a launch players who are free turn: to where the ball goes, or to be ready.

        Who hits within the next two touches turns only once, into the direction of that hit.
        """
        leg, receiver = self.legs[-1], self.order[number]
        now = leg.start + round(_REACTION_S * self.rate)
        ready, soon = [*self.order[number + 1 : number + 3], None, None][:2]
        for name, actor in self.actors.items():
            waits = name == soon or (name == ready and not self._by_user(number + 1))
            if name == receiver or waits:
                continue
            if actor.time > now + round(_BUSY_S * self.rate):
                continue
            _, x, z = actor.stand
            if name == ready:
                heading = self._way(number + 1)[0]
            else:
                heading = _heading(leg.target - np.array([x, 0.0, z]))
            actor.face(heading, now=now, tolerance=_TOLERANCE)
            actor.idle_until(max(now, actor.time))


def _heading(way: np.ndarray) -> float:
    return float(np.arctan2(way[0], way[2]))


def _shown(place: np.ndarray) -> str:
    return "(" + ", ".join(f"{x:.2f}" for x in place) + ")"
