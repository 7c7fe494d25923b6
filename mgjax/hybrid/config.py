"""Settings of the hybrid room, of its path search and of reaching.

Neither jax nor numpy is imported here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from mgjax.core.body.sized import sized
from mgjax.core.errors import ConfigError
from mgjax.core.ranges import Ranges, check_ranges

WIDEST = 4096
"""Partial walks of the widest beam."""


@dataclass(frozen=True, kw_only=True)
class PathConfig:
    """How a walk along a sketched path is searched.

    ``near_m``, ``end_radius_m`` and ``margin_m`` are those of an adult (:func:`path_for_body`).

    Deviation: the paper's error (eq. 7) is all that counts only with ``blend_weight`` 0. The search
    then follows the path within a centimetre, but mostly by transitions between windows that differ
    a lot: on a straight line transitions are 4.6 cm apart and planted feet slide 2.0 mm a frame;
    with 1 they are 1.1 cm apart, feet slide 1.0 mm, and the root is off by 1.2 cm instead of 0.7.

    Attributes:
        method: ``"exact"``: branch and bound over a bounded horizon, again and again. ``"beam"``:
            only the best partial walks are kept, over the whole path at once; quicker, no optimum.
        horizon_s: how far the exact search looks ahead, s.
        keep_s: how much of what it found is kept before it looks again, s.
        near_m: a walk may nowhere be farther from the place on the path that it belongs to, m.
        beam_width: partial walks that the beam keeps; the exact search starts from its result.
        expansions: most partial walks that the exact search extends for one horizon. Beyond them
            the best so far is taken and the horizon does not count as proven.
        time_limit_s: after this the best so far is returned, s; 0 for none. With a limit the beam
            is widened until nothing more is gained or the time is over.
        blend_weight: a frame blended from windows that are D apart counts like one that is
            √weight·D off the path; 0 for the paper's error alone.
        speed_weight: weight of (v − wanted speed)² beside the squared distance, s².
        end_weight: frames for which the error at a given end counts.
        end_radius_m: a heading wrong by 1 rad at a given end counts as being off by this, m.
        margin_m: distance kept between the root and obstacles on the floor, m.
    """

    method: Literal["exact", "beam"] = "exact"
    horizon_s: float = 4.0
    keep_s: float = 1.0
    near_m: float = 1.0
    beam_width: int = 32
    expansions: int = 5000
    time_limit_s: float = 0.0
    blend_weight: float = 1.0
    speed_weight: float = 0.05
    end_weight: float = 10.0
    end_radius_m: float = 0.5
    margin_m: float = 0.3


@dataclass(frozen=True, kw_only=True)
class ReachConfig:
    """How hands and head reach on a walk.

    ``drop_m`` and ``radius_m`` are those of an adult (:func:`reach_for_body`).

    Attributes:
        limits: keep the joint limits of :mod:`mgjax.hybrid.body.limb_limits`.
        extend: walk towards a target that is out of reach.
        stop: stand still for a target that the walk passes too quickly to hold it.
        blend_s: over this time the walk's pose gives way to the reaching one, and returns, s; 0
            for at once. It is lengthened where a joint would turn too fast.
        turn_deg_s: joints turn at most so fast, or as fast as in the walk itself, degrees/s.
        drop_m: the pelvis goes down by at most so much, m.
        hold_m: the end of a limb counts as staying on its target within this distance, m.
        radius_m: radius of the turns on the way to a target, m.
    """

    limits: bool = True
    extend: bool = True
    stop: bool = True
    blend_s: float = 0.6
    turn_deg_s: float = 720.0
    drop_m: float = 0.5
    hold_m: float = 0.005
    radius_m: float = 0.7


@dataclass(frozen=True, kw_only=True)
class WalkConfig:
    """All settings of ``mgjax walk``, as the sections of its configuration file.

    Attributes:
        path: of the search.
        reach: of the reaches on the way.
    """

    path: PathConfig = field(default_factory=PathConfig)
    reach: ReachConfig = field(default_factory=ReachConfig)


def path_for_body(config: PathConfig, scale: float) -> PathConfig:
    """The settings in metres of one body, from those of an adult.

    Args:
        config: as a user writes them.
        scale: of the body; see :func:`mgjax.core.body.height.body_scale`.
    """
    return sized(config, ("near_m", "end_radius_m", "margin_m"), scale)


def reach_for_body(config: ReachConfig, scale: float) -> ReachConfig:
    """As :func:`path_for_body`; how exactly an end holds its target has nothing to do with size."""
    return sized(config, ("drop_m", "radius_m"), scale)


_PATH_RANGES: Ranges = {
    "horizon_s": (1, 60),
    "keep_s": (0.1, 60),
    "near_m": (0.05, 100),
    "beam_width": (1, WIDEST),
    "expansions": (1, 10**8),
    "time_limit_s": (0, math.inf),
    "blend_weight": (0, math.inf),
    "speed_weight": (0, math.inf),
    "end_weight": (0, math.inf),
    "end_radius_m": (0, math.inf),
    "margin_m": (0, 10),
}
"""Least and largest value of each number; infinity itself is none of them."""

_REACH_RANGES: Ranges = {
    "blend_s": (0, 10),
    "turn_deg_s": (1, math.inf),
    "drop_m": (0, 1),
    "hold_m": (1e-4, 1),
    "radius_m": (0.05, 100),
}


def validate_path_config(config: PathConfig) -> None:
    """Raises :class:`ConfigError` naming the first setting of a path search out of range."""
    if config.method not in ("exact", "beam"):
        raise ConfigError(got=f"method = {config.method!r}", expected="exact or beam")
    check_ranges(config, _PATH_RANGES, whole=("beam_width", "expansions"))
    if config.keep_s > config.horizon_s:
        got, expected = f"keep_s = {config.keep_s!r}", f"at most horizon_s = {config.horizon_s:g}"
        raise ConfigError(got=got, expected=expected)


def validate_reach_config(config: ReachConfig) -> None:
    """Raises :class:`ConfigError` naming the first setting of the reaches out of range."""
    for name in ("limits", "extend", "stop"):
        value = getattr(config, name)
        if not isinstance(value, bool):
            raise ConfigError(got=f"{name} = {value!r}", expected="true or false")
    check_ranges(config, _REACH_RANGES)
