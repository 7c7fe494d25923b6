"""Where the players of a match stand, and the net between them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.ball.physics import Net
from mgjax.ballsport.scene.config import Pass, Player, SceneConfig
from mgjax.stage.show.types import Colour, Thing

COUNTS = (3, 6)
_THREE = (("Ana", 0.0, -2.2), ("Ben", 1.9, 2.6), ("Cem", -1.9, 2.6))
_RING_M = 3.6
_SIX = ("Ana", "Ben", "Cem", "Dia", "Eli", "Fay")
_NET_M = 1.0
_WIDE_M = {3: 3.2, 6: 3.9}
"""Half the length of the net."""
_BESIDE_M = 1.7
"""From the outermost player to where the user's body stands."""
_USER_Z_M, _MATCHED_Z_M = 2.0, 3.8
_COLOURS: tuple[Colour, ...] = ("blue", "green", "purple", "sky", "yellow", "red")


def pitch(count: int, *, net: bool, clips: str = "") -> SceneConfig:
    """Three players on either side of where a net may be, or six in a ring.

    Args:
        count: 3 or 6.
        net: whether there is one: a ball that crosses it does so above its edge.
        clips: folder with captured kicks; "": the embedded ones alone.
    """
    first = Pass(by=_SIX[0], to=_SIX[1])  # a scene has one; in a match others are asked for
    config = SceneConfig(clips=clips, end_s=1.2, passes=(first,))
    if count == 3:
        players = tuple(Player(name=name, x=x, z=z) for name, x, z in _THREE)
        return replace(config, players=players, net=Net(z=0.4, height=_NET_M) if net else None)
    turns = [math.radians(30 + 60 * k) for k in range(6)]
    players = tuple(
        Player(name=name, x=round(_RING_M * math.sin(a), 2), z=round(_RING_M * math.cos(a), 2))
        for name, a in zip(_SIX, turns, strict=True)
    )
    if not net:
        return replace(config, players=players)
    return replace(
        config,
        players=players,
        net=Net(heading=math.pi / 2, height=_NET_M),
        throw_in=(-0.9, 1.5, 0.0),  # not over the net itself
    )


def colours(config: SceneConfig) -> dict[str, Colour]:
    """A colour for each player; on either side of a net all have one."""
    if config.net is None:
        return {p.name: c for p, c in zip(config.players, _COLOURS, strict=False)}
    return {p.name: "blue" if side(config.net, p.x, p.z) < 0 else "green" for p in config.players}


def side(net: Net, x: float, z: float) -> float:
    """How far a place lies beyond a net, m; negative before it."""
    return float((x - net.x) * math.sin(net.heading) + (z - net.z) * math.cos(net.heading))


def net_thing(config: SceneConfig) -> Thing | None:
    """The net as it is drawn, if there is one."""
    net = config.net
    if net is None:
        return None
    half = _WIDE_M[len(config.players)]
    x, z = half * math.cos(net.heading), -half * math.sin(net.heading)
    return Thing(
        id="net",
        shape="net",
        place=(net.x - x, net.height, net.z - z),
        end=(net.x + x, net.height, net.z + z),
        colour="grey",
    )


def over_net(net: Net, path: Float[np.ndarray, "F 3"], radius: float) -> float | None:
    """How much air is between a ball and the net's edge where it crosses, m; None: it does not.

    Args:
        net: the net.
        path: of the ball's centre, m.
        radius: of the ball, m.
    """
    across = np.array([math.sin(net.heading), 0.0, math.cos(net.heading)])
    away = (path - np.array([net.x, 0.0, net.z])) @ across
    crossed = np.flatnonzero((away[1:] < 0) != (away[:-1] < 0))
    if not len(crossed):
        return None
    k = crossed
    share = away[k] / (away[k] - away[k + 1])
    height = path[k, 1] + share * (path[k + 1, 1] - path[k, 1])
    return float(height.min() - net.height - radius)


def beside(config: SceneConfig) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """Planar frames beside the pitch, facing it: of the user, and of the hit that was matched."""
    x = min(p.x for p in config.players) - _BESIDE_M

    def spot(z: float) -> Float[np.ndarray, "3"]:
        return np.array([math.atan2(-x, -z), x, z])

    return spot(_USER_Z_M), spot(_MATCHED_Z_M)
