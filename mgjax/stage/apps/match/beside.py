"""What stands beside the pitch: the user's body, and the stored hit that its kick resembles."""

from __future__ import annotations

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.live.recogniser import PassDecision
from mgjax.ballsport.scene.config import SceneConfig
from mgjax.stage.apps.match.pitch import beside
from mgjax.stage.apps.match.source import SensorSource, Source
from mgjax.stage.apps.match.user import UserBody, kick_words, matched_actor
from mgjax.stage.serve.session import Send
from mgjax.stage.show.types import Actor, show_value

_BODY = 1
"""The user's place among the bodies of the page; the players' is 0."""
_LATER_S = 0.2
"""From a kick's being matched to the stored hit's beginning, s."""


class Beside:
    """The user's body, if there is one.

    Args:
        moves: the stored hits.
        config: of the match.
        send: to the page.
    """

    def __init__(self, moves: Repertoire, config: SceneConfig, send: Send) -> None:
        self._moves, self._send = moves, send
        self._spot, self._matched_spot = beside(config)
        self._user: UserBody | None = None
        self._name, self._drawn = "", False
        self._silence = ""
        self.live = False

    @property
    def open(self) -> bool:
        """Whether there is a source."""
        return self._user is not None

    def listen(self, source: Source, *, live: bool, name: str = "you") -> None:
        """From now on takes a source's body."""
        self._user = UserBody(source, self._moves, self._spot)
        self._name, self.live, self._drawn = name, live, False
        if isinstance(source, SensorSource):
            self.say(f"listening for a VMC sender on {source.place}", "busy")
        else:
            self.say(f"{name} is sent as if by a sensor", "busy")

    def close(self) -> None:
        """Takes the body away, and frees its source."""
        if self._user is None:
            return
        self._user.source.close()
        self._user, self.live = None, False
        for actor in ("user", "matched"):
            self._send({"type": "remove", "kind": "actors", "id": actor})

    def hear(self, now_s: float) -> list[PassDecision]:
        """Takes what has come by a second of the match, shows it, and returns the kicks."""
        user = self._user
        if user is None:
            return []
        kicks = user.hear(now_s)
        if user.source.over:
            kicks += user.finish()
        self._show(user)
        if self.live and not self._drawn:
            self._say_silence(user.source.silence)
        return kicks

    def say(self, text: str, tone: str) -> None:
        """A sentence of the user's part of the panel."""
        self._send({"type": "note", "what": "user", "text": text, "tone": tone})

    def say_kick(self, kick: PassDecision, now_s: float, holder: str) -> None:
        """A kick was matched: its stored hit is played beside the user's body."""
        actor = matched_actor(self._moves, kick.hit, self._matched_spot, now_s + _LATER_S)
        self._send({"type": "put", "kind": "actors", "item": show_value(actor)})
        self.say(f"{kick_words(kick)}; {holder} passes like that", "good")

    def _say_silence(self, text: str) -> None:
        if text and text != self._silence:
            self.say(text, "busy")
        self._silence = text

    def _show(self, user: UserBody) -> None:
        frames = user.shown()
        if frames is None:
            return
        if self._drawn:
            self._send({"type": "frames", "actor": "user", "frames": show_value(frames)})
            return
        body = {**show_value(user.body), "index": _BODY}
        self._send({"type": "put", "kind": "bodies", "item": body})
        actor = Actor(id="user", body=_BODY, frames=frames, colour="grey", note=self._name)
        self._send({"type": "put", "kind": "actors", "item": show_value(actor)})
        self._drawn = True
