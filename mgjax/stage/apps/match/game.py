"""A match as it goes on: the scene, what is wished for it, and what came of its passes."""

from __future__ import annotations

import numpy as np

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.live.open_scene import OpenScene, ScenePart
from mgjax.ballsport.live.recogniser import PassDecision
from mgjax.ballsport.scene.config import SceneConfig
from mgjax.ballsport.scene.types import Asked
from mgjax.stage.apps.match.passes import PassMade, figures, pass_made, spans
from mgjax.stage.apps.match.pitch import colours, net_thing
from mgjax.stage.apps.match.wishes import Wishes
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Ball, Show, Span

AHEAD_S = 0.5
"""How much longer than what is played the match is certain."""
KEPT_S = 60.0
"""How much of the past can be looked at again on the page."""


class Game:
    """One match from its beginning.

    Args:
        config: players, net, physics.
        moves: what the players can do.
        wishes: whose passes are made.
    """

    def __init__(self, config: SceneConfig, moves: Repertoire, wishes: Wishes) -> None:
        self.config, self.moves, self.wishes = config, moves, wishes
        self.kick: PassDecision | None = None
        self.passes: list[PassMade] = []
        self.scene = OpenScene(
            config,
            moves,
            first=config.players[0].name,
            next_pass=wishes.next_pass,
            choose=self._choose,
        )

    @property
    def known_s(self) -> float:
        """Until when everything is certain, s."""
        return max(self.scene.certain - 1, 0) / self.scene.rate

    def play(self, time_s: float) -> ScenePart | None:
        """Plans as far as is needed while a second is played; returns what became certain.

        Raises:
            ConfigError: a pass that cannot be begun.
        """
        part = self.scene.advance(round((time_s + AHEAD_S) * self.scene.rate))
        while len(self.passes) < len(self.scene.arrivals):
            made = pass_made(self.scene, self.moves, len(self.passes), self.config)
            self.passes.append(made)
        return part

    def kicked(self, kick: PassDecision) -> None:
        """The user has kicked: the next pass is made like that."""
        self.kick, self.wishes.kicked = kick, True

    def _choose(self, asked: Asked) -> int | None:
        if self.kick is None or self.kick.hit not in asked.hits:
            return None
        hit, self.kick = self.kick.hit, None
        return hit

    def opening(self, part: ScenePart) -> Show:
        """All that is seen at the beginning."""
        net = net_thing(self.config)
        return Show(
            title="Match",
            seconds=self.known_s,
            bodies=[body_of(self.moves.clips.skeleton)],
            actors=self.actors(part),
            balls=self.balls(),
            things=[] if net is None else [net],
        )

    def actors(self, part: ScenePart) -> list[Actor]:
        """The players, with some frames."""
        hues = colours(self.config)
        start, rate = part.start / self.scene.rate, self.scene.rate
        return [
            Actor(
                id=name,
                body=0,
                frames=frames_of(motion, start=start, rate=rate, delta=False),
                colour=hues[name],
                note=name,
            )
            for name, motion in part.motions.items()
        ]

    def balls(self, *, whole: bool = False) -> list[Ball]:
        """The ball of this throw and the one before, as far as it is kept; or of all throws."""
        scene, rate = self.scene, self.scene.rate
        throws = [(n, f) for n, f in enumerate(scene.flights) if not scene.ends[n][0]]
        throws = throws if whole else throws[-2:]
        balls: list[Ball] = []
        for k, (number, flight) in enumerate(throws):
            last = k + 1 == len(throws)
            stop = len(scene.ball) if last else throws[k + 1][1].start
            kept = 0 if whole else len(scene.ball) - round(KEPT_S * rate)
            first = max(flight.start, kept)
            if stop - first < 2:
                continue
            balls.append(
                Ball(
                    id=f"ball {number}",
                    radius=float(self.config.physics.radius),
                    times=(np.arange(first, stop) / rate).astype(np.float32),
                    places=scene.ball[first:stop].astype(np.float32),
                )
            )
        return balls

    def rows(self, *, whole: bool = False) -> list[Span]:
        """The timeline of what can be looked at, or of everything."""
        since = 0.0 if whole else max(0.0, self.known_s - KEPT_S)
        return spans(self.scene, self.moves, self.passes, since)

    def bounces(self) -> list[tuple[float, float, float]]:
        """When and where the ball bounces, s, x and z in m, as far as is kept."""
        since = max(0.0, self.known_s - KEPT_S)
        return [
            (event.time, float(event.place[0]), float(event.place[2]))
            for event in self.scene.events
            if event.what == "bounce" and event.time > since
        ]

    def table(self) -> list[tuple[str, str]]:
        """Figures of all passes."""
        return figures(self.passes)
