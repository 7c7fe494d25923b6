"""One tab's match: what the page asks for, and what it is told."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.live.open_scene import ScenePart
from mgjax.clips.types import Clip
from mgjax.core.errors import ConfigError
from mgjax.stage.apps.match.beside import Beside
from mgjax.stage.apps.match.export import FILES, exported
from mgjax.stage.apps.match.game import Game
from mgjax.stage.apps.match.passes import as_message
from mgjax.stage.apps.match.pitch import COUNTS, pitch
from mgjax.stage.apps.match.rehearsal import Rehearsal
from mgjax.stage.apps.match.source import ClipSource, SensorSource
from mgjax.stage.apps.match.wishes import BOUNCES, KINDS_OR_ANY, Wishes
from mgjax.stage.serve import fields
from mgjax.stage.serve.session import Message, Send
from mgjax.stage.show.types import show_value

_LONGEST_S = 24 * 3600.0
_MOST_GAMES = 2**31
_MOST_TOLD = 40


class MatchSession:
    """See :class:`mgjax.stage.serve.session.Session`.

    The page's clock drives the match: it says which second it plays, and what is certain is sent
    ahead. So a page that is paused, or looks at the past, holds the match up.

    Args:
        send: to the page.
        moves: what players can do.
        clips: those that can be played as the user, by name.
        folder: of captured kicks; "": none.
        seed: draws what nobody said.
        open_sensor: opens the motion sensor.
        rehearsal: compiles what pitches need before they are played; None: as they are played.

    Attributes:
        game: that is being played.
    """

    def __init__(
        self,
        send: Send,
        moves: Repertoire,
        clips: dict[str, Clip],
        *,
        folder: str = "",
        seed: int = 0,
        open_sensor: Callable[[], SensorSource] = SensorSource,
        rehearsal: Rehearsal | None = None,
    ) -> None:
        self._send, self._moves, self._clips = send, moves, clips
        self._folder, self._open_sensor = folder, open_sensor
        self._rehearsal = rehearsal
        self._rng = np.random.default_rng(seed)
        self._number = 0
        self._time = 0.0
        self._shown: list[str] = []
        self._config = pitch(COUNTS[0], net=True, clips=folder)
        self._on, self._kind, self._bounces = True, "any", "any"
        send({"type": "ready", "app": "match", "title": "Match", "options": {}})
        self._begin()

    def receive(self, message: Message) -> None:
        """See :class:`mgjax.stage.serve.session.Session`."""
        handlers: dict[str, Callable[[Message], None]] = {
            "clock": self._clock,
            "pick": self._pick,
            "unpick": self._unpick,
            "wish": self._wish,
            "pitch": self._pitch,
            "sensor": self._sensor,
            "replay": self._replay,
            "export": self._export,
        }
        handlers[fields.text(message, "type", tuple(handlers))](message)

    def tick(self) -> None:
        """Hears the motion sensor."""
        if self._beside.live:
            self._hear()

    def close(self) -> None:
        """Frees the sensor's port."""
        self._beside.close()

    def _begin(self) -> None:
        """A new match, from its beginning."""
        names = [player.name for player in self._config.players]
        self._wishes = Wishes(
            players=names, rng=self._rng, on=self._on, kind=self._kind, bounces=self._bounces
        )
        if self._rehearsal is not None:
            self._wishes.ready = partial(self._rehearsal.ready, self._config)
        self.game = Game(self._config, self._moves, self._wishes)
        self._beside = Beside(self._moves, self._config, self._send)
        self._number, self._time = self._number + 1, 0.0
        part = self.game.play(0.0)
        assert part is not None
        opening = self.game.opening(part)
        self._shown = [ball.id for ball in opening.balls]
        self._send({"type": "show", "show": show_value(opening)})
        self._note(
            "match",
            game=self._number,
            players=[{"name": p.name, "x": p.x, "z": p.z} for p in self._config.players],
            net=self._config.net is not None,
            clips=list(self._clips),
        )
        self._tell()

    def _note(self, what: str, **values: Any) -> None:
        self._send({"type": "note", "what": what, **values})

    def _clock(self, message: Message) -> None:
        """The page plays a second."""
        number = fields.whole(message, "game", 0, _MOST_GAMES)
        time = fields.number(message, "time", 0.0, _LONGEST_S)
        if number != self._number:
            return  # it has not heard yet of the newest match
        self._time = min(time, self.game.known_s)
        if self._beside.open:
            self._hear()
        part = self.game.play(self._time)
        if part is not None:
            self._send_part(part)

    def _send_part(self, part: ScenePart) -> None:
        for actor in self.game.actors(part):
            frames = show_value(actor.frames)
            self._send({"type": "frames", "actor": actor.id, "frames": frames})
        balls = self.game.balls()
        for gone in set(self._shown) - {ball.id for ball in balls}:
            self._send({"type": "remove", "kind": "balls", "id": gone})
        for ball in balls:
            self._send({"type": "put", "kind": "balls", "item": show_value(ball)})
        self._shown = [ball.id for ball in balls]
        self._tell()

    def _tell(self) -> None:
        """What is known by now: passes, rows of the timeline, figures."""
        game = self.game
        self._note(
            "played",
            game=self._number,
            known=game.known_s,
            passes=[as_message(p) for p in game.passes[-_MOST_TOLD:]],
            bounces=[list(bounce) for bounce in game.bounces()],
            spans=[show_value(span) for span in game.rows()],
            table=[list(row) for row in game.table()],
        )
        self._tell_wishes()

    def _tell_wishes(self) -> None:
        """Who has the ball next, and what will be done with it."""
        wishes, scene = self._wishes, self.game.scene
        self._note(
            "wishes",
            holder=scene.holder,
            waits=scene.waits and not (wishes.on or wishes.picked or wishes.kicked),
            picked=list(wishes.picked),
            on=wishes.on,
            kind=wishes.kind,
            bounces=wishes.bounces,
        )

    def _pick(self, message: Message) -> None:
        self._wishes.pick(fields.text(message, "player"), self.game.scene.holder)
        self._tell_wishes()

    def _unpick(self, message: Message) -> None:
        """Takes back the last click."""
        if not self._wishes.picked:
            raise ConfigError(got="nobody clicked", expected="a click to take back")
        self._wishes.picked.pop()
        self._tell_wishes()

    def _wish(self, message: Message) -> None:
        kind = fields.text(message, "kind", KINDS_OR_ANY)
        bounces = fields.text(message, "bounces", BOUNCES)
        on = fields.flag(message, "on")
        self._kind, self._bounces, self._on = kind, bounces, on
        self._wishes.kind, self._wishes.bounces, self._wishes.on = kind, bounces, on
        self._tell_wishes()

    def _pitch(self, message: Message) -> None:
        """A new match; also the button that begins again."""
        count = fields.whole(message, "players", COUNTS[0], COUNTS[-1])
        if count not in COUNTS:
            raise ConfigError(got=f"{count} players", expected=" or ".join(map(str, COUNTS)))
        self._config = pitch(count, net=fields.flag(message, "net"), clips=self._folder)
        self._note("busy", text="The players warm up")
        if self._rehearsal is not None:
            self._rehearsal.prepare(self._config)
        self._beside.close()
        self._begin()

    def _sensor(self, message: Message) -> None:
        self._beside.close()
        if fields.flag(message, "on"):
            self._beside.listen(self._open_sensor(), live=True)
        else:
            self._beside.say("the sensor is off", "plain")

    def _replay(self, message: Message) -> None:
        name = fields.text(message, "clip", tuple(self._clips))
        clip = self._clips[name]
        source = ClipSource(clip.skeleton, clip.motion, self._time)
        self._beside.close()
        self._beside.listen(source, live=False, name=name)

    def _hear(self) -> None:
        """Takes what the user's body did; a kick decides the next pass."""
        for kick in self._beside.hear(self._time):
            self.game.kicked(kick)
            self._beside.say_kick(kick, self._time, self.game.scene.holder)
            self._tell_wishes()

    def _export(self, message: Message) -> None:
        kind = fields.text(message, "what", FILES)
        name, mime, data = exported(self.game, kind)
        value: dict[str, Any] = {"type": "file", "name": name, "mime": mime}
        self._send({**value, "data": np.frombuffer(data, np.uint8)})
