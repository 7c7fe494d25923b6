"""What the sliders and switches set."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

from mgjax.avoidance.config import BALL_RADIUS_M, AvoidanceConfig, EnergyConfig
from mgjax.stage.serve.fields import flag, number
from mgjax.stage.serve.session import Message


@dataclass(frozen=True, kw_only=True)
class BallSettings:
    """How balls are thrown.

    Attributes:
        speed: m/s.
        radius: m.
        gravity: m/s²; 0 is a straight line.
        notice: seconds from the throw to the body.
    """

    speed: float = 7.0
    radius: float = BALL_RADIUS_M
    gravity: float = 0.0
    notice: float = 1.5


START = AvoidanceConfig(T_window=2.0, T_wide=0.0)
"""Settings of the search at the beginning: a wide window finds a way out more often."""
BALL_RANGES = {
    "speed": (2.0, 30.0),
    "radius": (0.03, 0.4),
    "gravity": (0.0, 9.8),
    "notice": (0.2, 2.5),
}
SEARCH_RANGES = {
    "E_avoidance": (0.001, 1.0),
    "D_body": (0.02, 2.0),
    "T_window": (0.1, 3.0),
    "w_a": (0.0, 5.0),
    "w_b": (0.0, 5.0),
    "w_m": (0.0, 10.0),
    "w_t": (0.0, 5.0),
}
"""Least and most of each slider."""


def with_ball(settings: BallSettings, message: Message) -> BallSettings:
    """Settings with those that a message has changed; :class:`ConfigError` out of range."""
    changed = {n: number(message, n, *BALL_RANGES[n]) for n in BALL_RANGES if n in message}
    return replace(settings, **changed)


def with_search(config: AvoidanceConfig, message: Message) -> AvoidanceConfig:
    """Settings of the search with those that a message has changed."""
    changed = {n: number(message, n, *SEARCH_RANGES[n]) for n in SEARCH_RANGES if n in message}
    energy = {f.name for f in fields(EnergyConfig)}
    if "parry" in message:
        config = replace(config, parry="on" if flag(message, "parry") else "off")
    return replace(
        config,
        energy=replace(config.energy, **{n: v for n, v in changed.items() if n in energy}),
        **{n: v for n, v in changed.items() if n not in energy},
    )


def settings_json(ball: BallSettings, config: AvoidanceConfig) -> dict[str, Any]:
    """All sliders: value, least and most; of the switch whether it is on."""
    found: dict[str, Any] = {"parry": {"value": config.parry == "on"}}
    for ranges, sources in ((BALL_RANGES, (ball,)), (SEARCH_RANGES, (config, config.energy))):
        for name, (low, high) in ranges.items():
            source = next(s for s in sources if hasattr(s, name))
            found[name] = {"value": float(getattr(source, name)), "low": low, "high": high}
    return found
