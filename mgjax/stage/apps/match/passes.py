"""What came of each pass, in figures and in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mgjax.ballsport.aiming.solve import OK, STATUS_TEXT
from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.live.open_scene import OpenScene
from mgjax.ballsport.scene.config import SceneConfig
from mgjax.ballsport.scene.kick import kick_change
from mgjax.ballsport.scene.types import THROWN_IN, Touch
from mgjax.stage.apps.match.pitch import over_net
from mgjax.stage.show.types import Colour, Span

COLOURS: dict[str, Colour] = {"toss": "sky", "pass": "green", "attack": "orange", "throw": "grey"}
"""Of hits by their kind."""
_SEEN_WARP, _NOTABLE_WARP = 5e-4, 0.02


@dataclass(frozen=True, kw_only=True)
class PassMade:
    """One flight of the ball.

    Attributes:
        by, to: names; by nobody: thrown in; to nobody: the last of a rally.
        kind: toss, pass, attack or throw.
        bone: what kicks, such as ``"left_foot"``; "" for a throw.
        bounces: on the way.
        start_s, stop_s: s.
        speed_m_s: of the ball as it leaves.
        status: why there is nobody to hit it; "" where somebody does.
        miss_m: how far from its target it then ends.
        arrival_m: how far from where it was to be it arrives.
        warp: how much faster than captured the way to the receiving hit is played; 0.01: 1 %.
        change: of the kick, as a share of the bone's speed.
        net_m: air over the net where it crosses it, m.
        by_user: whether the user's body decided the kick.
    """

    by: str
    to: str
    kind: str
    bone: str
    bounces: int
    start_s: float
    stop_s: float
    speed_m_s: float
    status: str
    miss_m: float
    arrival_m: float
    warp: float
    change: float
    net_m: float | None
    by_user: bool

    @property
    def words(self) -> str:
        """One sentence."""
        if not self.to:
            return f"{self.by} stops the ball ({self.kind}) and waits: click who gets it"
        ends = f"thrown in to {self.to}" if not self.by else f"{self.by} to {self.to}: {self.kind}"
        bounces = "no bounce" if not self.bounces else "1 bounce"
        bounces = bounces if self.bounces < 2 else f"{self.bounces} bounces"
        if self.status:
            return f"{ends}, {bounces}: missed, {self.status}, {self.miss_m:.2f} m off"
        parts = [ends, bounces, f"arrives within {_millimetres(self.arrival_m)}"]
        parts.append(_warp_words(self.warp))
        if self.net_m is not None:
            parts.append(f"{self.net_m:.2f} m over the net")
        if self.by_user:
            parts.append("kicked as you did")
        return ", ".join(parts)

    @property
    def tone(self) -> str:
        return "bad" if self.status else "good" if self.to else "plain"


def pass_made(scene: OpenScene, moves: Repertoire, number: int, config: SceneConfig) -> PassMade:
    """What came of a flight of an open scene, as its number there."""
    flight, (by, to) = scene.flights[number], scene.ends[number]
    rate, clips = scene.rate, moves.clips
    kicks: Touch | None = None if flight.number == THROWN_IN else scene.touches[flight.number]
    meets = next((t for t in reversed(scene.touches) if t.time == flight.stop), None)
    path = scene.ball[flight.start : flight.stop + 1]
    arrival = scene.arrivals[number]
    change = 0.0
    if kicks is not None:
        change = float(kick_change(flight.velocity[None], kicks.bone[None])[0])
    status = "" if flight.status == OK else STATUS_TEXT[flight.status]
    if to and meets is None and not status:
        status = "nobody gets there in time"
    return PassMade(
        by=by,
        to=to,
        kind="throw" if kicks is None else clips.hit_kind[kicks.kick.hit],
        bone="" if kicks is None else clips.hit_bone[kicks.kick.hit],
        bounces=flight.bounces,
        start_s=flight.start / rate,
        stop_s=flight.stop / rate,
        speed_m_s=float(np.linalg.norm(flight.velocity)),
        status=status,
        miss_m=flight.miss,
        arrival_m=float(np.linalg.norm(arrival - flight.target)),
        warp=0.0 if meets is None else meets.warp - 1,
        change=change,
        net_m=None if config.net is None else over_net(config.net, path, config.physics.radius),
        by_user=kicks is not None and kicks.by_user,
    )


def figures(passes: Sequence[PassMade]) -> list[tuple[str, str]]:
    """The table: how many were made and missed, and the worst of them."""
    real = [p for p in passes if p.by and p.to]
    made = [p for p in real if not p.status]
    rows = [("passes made", str(len(made))), ("missed", str(len(real) - len(made)))]
    if not made:
        return rows
    warp = max((p.warp for p in passes), key=abs)
    changes = [p.change for p in made]
    return [
        *rows,
        ("arrives within", _millimetres(max(p.arrival_m for p in made))),
        ("largest warp", f"{100 * warp:+.1f} %"),
        ("kick changed by", f"{100 * np.mean(changes):.0f} %, most {100 * max(changes):.0f} %"),
        ("ball speed", f"up to {max(p.speed_m_s for p in made):.1f} m/s"),
    ]


def spans(
    scene: OpenScene, moves: Repertoire, passes: Sequence[PassMade], since_s: float
) -> list[Span]:
    """Rows of the timeline: the ball with its passes, and each player with links and hits."""
    return [*_ball_row(passes, since_s), *_player_rows(scene, moves, since_s)]


def _ball_row(passes: Sequence[PassMade], since_s: float) -> list[Span]:
    return [
        Span(
            row="ball",
            start=p.start_s,
            end=p.stop_s,
            text=_short(p),
            colour="red" if p.status else COLOURS[p.kind],
        )
        for p in passes
        if p.stop_s > since_s
    ]


def _player_rows(scene: OpenScene, moves: Repertoire, since_s: float) -> list[Span]:
    rate, clips = scene.rate, moves.clips
    rows: list[Span] = []
    launches = {flight.stop: flight.start for flight in scene.flights}
    for touch in reversed(scene.touches):
        if touch.time / rate < since_s:
            break
        hit = touch.kick.hit
        first = touch.time + int(clips.hit_starts[hit]) - touch.kick.frame
        stop = touch.time + int(clips.hit_stops[hit]) - touch.kick.frame
        warp = touch.warp - 1
        begin = launches.get(touch.time, first)
        text = f"{100 * warp:+.1f} %" if abs(warp) >= _SEEN_WARP else "link"
        colour: Colour = "yellow" if abs(warp) >= _NOTABLE_WARP else "grey"
        if begin < first:
            rows.append(
                Span(
                    row=touch.player, start=begin / rate, end=first / rate, text=text, colour=colour
                )
            )
        kind = clips.hit_kind[hit]
        rows.append(
            Span(
                row=touch.player,
                start=first / rate,
                end=stop / rate,
                text=kind,
                colour=COLOURS[kind],
            )
        )
    order = list(scene.names)
    return sorted(rows, key=lambda span: (order.index(span.row), span.start))


def _millimetres(distance: float) -> str:
    """Rounded up to hundredths."""
    return f"{max(math.ceil(1e5 * distance), 1) / 100:.2f} mm"


def _warp_words(warp: float) -> str:
    return f"warp {100 * warp:+.1f} %" if abs(warp) >= _SEEN_WARP else "no warp"


def _short(p: PassMade) -> str:
    if not p.to:
        return "to nobody"
    return f"→ {p.to}" if not p.by else f"{p.by} → {p.to}{', missed' if p.status else ''}"


def as_message(p: PassMade) -> dict[str, Any]:
    """A pass as the page keeps it."""
    return {
        "by": p.by,
        "to": p.to,
        "kind": p.kind,
        "bounces": p.bounces,
        "start": p.start_s,
        "stop": p.stop_s,
        "words": p.words,
        "tone": p.tone,
    }
