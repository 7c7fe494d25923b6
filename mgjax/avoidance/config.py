"""Settings of the avoidance room. Neither jax nor numpy is imported here."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal
from weakref import WeakValueDictionary

from mgjax.core.body.sized import sized
from mgjax.core.errors import ConfigError
from mgjax.core.ranges import Ranges, check_ranges
from mgjax.core.traced import Number

BALL_RADIUS_M = 0.12
"""Radius of a ball where nothing else is said."""
BALL_SPEED_M_S = 10.0
"""Speed of the balls by which the coverage of a graph is measured."""
HEIGHTS_M = (0.2, 0.5, 0.8, 1.1, 1.4, 1.7)
"""Where they pass the axis of an adult's body: from the shins to the head."""
ARRIVALS_S = (0.8, 1.2, 1.6)
"""When they are there, from now."""
DIRECTIONS = 16
"""How many directions they come from, all around."""
NODES = 256
"""At how many nodes of the graph."""

_ENERGY: Ranges = {
    "E_avoidance": (1e-9, 1e9),
    "D_body": (1e-9, 1e9),
    "D_move": (1e-9, 1e9),
    "E_time": (1.0, 1e6),
    "E_fast": (1.0, 1e6),
    "w_a": (0.0, 1e9),
    "w_b": (0.0, 1e9),
    "w_m": (0.0, 1e9),
    "w_t": (0.0, 1e9),
    "w_speed_up": (0.0, 1e9),
}


@dataclass(frozen=True, kw_only=True)
class EnergyConfig:
    """How a candidate path is judged (Oshita & Masaoka 2011, §4.2, eqs 4–10).

    The numbers are traced, the two strings are static. A search takes ``E_avoidance``, ``D_body``
    and ``D_move`` to be an adult's, and scales them to the body of its graph (:func:`for_body`).

    Attributes:
        form: what counts as penetrating the avoidance volume. ``"paper"``: every sphere that is
            farther from the attack than at the start of the avoidance part, by how much (eq. 5 as
            printed). ``"overlap"``: only the depth to which the attack would have hit.
        d0: what the clearance is compared with. ``"paper"``: the clearance of a body that freezes,
            also where it is negative. ``"clamped"``: the same, at least 0.
        E_avoidance: e' at which an avoidance is perfect, m·s, > 0. Depends on ``form``, the body
            spheres and the crop of the attack. The default is the 90th percentile of e' over the
            clear candidates of 200 seeded balls on motion capture, for ``"overlap"`` and the preset
            spheres (``experiments/avoidance/calibrate.py``; the same for ``"paper"`` is 1.14). The
            paper prints 0.5.
        D_body: clearance beyond ``d0`` at which a movement is as bad as none, m, > 0. The paper
            gives no value.
        D_move: displacement against not reacting that is as bad as the other energies at their
            worst, m, > 0.
        E_time: largest acceptable time scale, > 0.
        E_fast: largest acceptable speed-up of an edge, ≥ 1: where time scales are limited, those
            below 1/E_fast are rejected, too, and nothing is played faster.
        w_a: weight of the avoidance energy.
        w_b: weight of the body energy.
        w_m: weight of the movement energy, which is not the paper's; 0 leaves it out. By the three
            of the paper the walk that is chosen hardly moves less than a clear one drawn at random.
        w_t: weight of the time scale energy.
        w_speed_up: how much more speeding up weighs in it than slowing down by the same factor. At
            1, as in the paper, both weigh the same, but it is speeding up that is seen (Reitsma &
            Pollard 2003). Chosen by measurement, as w_m
            (``experiments/avoidance/minimal_movement.py``).
    """

    form: Literal["paper", "overlap"] = "overlap"
    d0: Literal["clamped", "paper"] = "clamped"
    E_avoidance: Number = 0.0085
    D_body: Number = 0.3
    D_move: Number = 0.3
    E_time: Number = 4.0
    E_fast: Number = 1e6
    w_a: Number = 1.0
    w_b: Number = 1.0
    w_m: Number = 3.0
    w_t: Number = 1.0
    w_speed_up: Number = 4.0

    def validate(self) -> None:
        """Raises :class:`ConfigError` naming the first number that is out of range."""
        check_ranges(self, _ENERGY, "energy.")


@dataclass(frozen=True, kw_only=True)
class SpeedConfig:
    """Which edges may change their speed (§4.1), by their largest end-effector speed, m/s.

    An edge above ``V_fast`` may be slowed down, one between ``V_still`` and ``V_slow`` sped up, one
    below ``V_still`` both; they are an adult's (:func:`for_body`). The printed values are 0.3, 0.1
    and 0.0: no edge is ever still and nearly every edge of real capture may only be slowed down.
    The defaults were chosen by measurement; with them an edge up to ``V_slow`` may also be sped up.
    """

    V_fast: float = 0.3
    V_slow: float = 3.0
    V_still: float = 0.3


@dataclass(frozen=True, kw_only=True)
class AvoidanceConfig:
    """How an avoidance is looked for.

    Attributes:
        energy: how candidates are judged.
        speed: which edges may change speed.
        T_window: width of the window of eq. 1 around the time of the attack, s.
        T_wide: where no candidate of that window is clear, the window is made so wide, s: walks
            that must change their speed more. At most ``T_window``, as in the paper: never.
        crop_radius_m, crop_height_m: the part of an attack within this cylinder around the root
            counts for energies and timing; of an adult, m (:func:`for_body`).
        body_rate: samples per second of the body volume, per edge. The paper's 10 Hz are off by up
            to 14 cm in between; at the capture's rate ranking and final check agree. At a rate
            other than the graph's no bound on clearances is certain: every candidate is then
            checked exactly, which gives the same answers and takes longer.
        evaluation_step_s: longest interval at which volumes are compared.
        limit_scale: rejects time scales outside [1/E_time, E_time] and below 1/E_fast; the paper
            keeps them.
        capacity: most candidates that are judged; those beyond are counted, never silent.
        checks: most candidates that are checked exactly.
        settle_s: how long after the attack the motion still has to stay clear, s.
        warp: how the chosen walk is played. ``"smooth"``: with a continuous speed, unless the
            attack would touch it then. ``"linear"``: each edge at one speed, as the paper has it.
        culling: slices that drop candidates before they are judged (§5.2): of whole edges
            (``"paper"``), of 0.1 s of motion (``"binned"``), or none. They drop good candidates,
            too, and here they take longer than they save.
        refine: ``"near"``: where no candidate is clear, those that the attack touches least are
            changed a little until one is. ``"off"``: never, as in the paper.
        refine_max_m, refine_max_deg: how far any joint may then be moved, of an adult, m, and
            turned in its parent's frame, degrees.
        parry: ``"on"``: where nothing avoids an attack, not even a near miss that is refined, a
            forearm or a hand is led to meet it (:mod:`mgjax.avoidance.parry`). ``"off"``: never.
        parry_radius_m: the largest sphere that an arm turns away, of an adult, m.
    """

    energy: EnergyConfig = EnergyConfig()
    speed: SpeedConfig = SpeedConfig()
    T_window: float = 1.0
    T_wide: float = 2.0
    crop_radius_m: float = 1.0
    crop_height_m: float = 2.3
    body_rate: float = 30.0
    evaluation_step_s: float = 0.05
    limit_scale: bool = True
    capacity: int = 1024
    checks: int = 64
    settle_s: float = 0.2
    warp: Literal["smooth", "linear"] = "smooth"
    culling: Literal["none", "paper", "binned"] = "none"
    refine: Literal["near", "off"] = "near"
    refine_max_m: float = 0.10
    refine_max_deg: float = 20.0
    parry: Literal["off", "on"] = "off"
    parry_radius_m: float = 0.25


_RANGES: Ranges = {
    "T_window": (1e-3, 10.0),
    "T_wide": (0.0, 10.0),
    "crop_radius_m": (1e-3, 100.0),
    "crop_height_m": (1e-3, 100.0),
    "body_rate": (1.0, 1000.0),
    "evaluation_step_s": (1e-3, 1.0),
    "settle_s": (0.0, 10.0),
    "refine_max_m": (0.0, 1.0),
    "refine_max_deg": (0.0, 180.0),
    "parry_radius_m": (0.0, 10.0),
    "capacity": (1, 1_000_000),
    "checks": (1, 1_000_000),
    "speed.V_fast": (0.0, math.inf),
    "speed.V_slow": (0.0, math.inf),
    "speed.V_still": (0.0, math.inf),
}
"""Smallest and largest value of each setting that is a number."""

_SPEEDS = ("V_fast", "V_slow", "V_still")
_ENERGIES = ("E_avoidance", "D_body", "D_move")
"""In m·s and m: times stay."""


def for_body(config: AvoidanceConfig, scale: float) -> AvoidanceConfig:
    """The settings in metres and m/s of one body, from those of an adult.

    Args:
        config: the settings as a user writes them.
        scale: of the body; see :func:`mgjax.core.body.height.body_scale`.
    """
    if scale == 1:
        return config
    return replace(  # all at once: searches call this for every attack
        config,
        crop_radius_m=scale * config.crop_radius_m,
        crop_height_m=scale * config.crop_height_m,
        refine_max_m=scale * config.refine_max_m,
        parry_radius_m=scale * config.parry_radius_m,
        energy=sized(config.energy, _ENERGIES, scale),
        speed=sized(config.speed, _SPEEDS, scale),
    )


_IN_RANGE: WeakValueDictionary[int, AvoidanceConfig] = WeakValueDictionary()
"""Settings that were found in range, by identity: equal ones may differ in type (1 and True), and
traced ones cannot be compared."""


def validate_config(config: AvoidanceConfig) -> None:
    """Raises :class:`ConfigError` naming the first setting that is out of range."""
    if _IN_RANGE.get(id(config)) is config:
        return
    config.energy.validate()
    check_ranges(config, _RANGES, endless=("speed.V_fast", "speed.V_slow", "speed.V_still"))
    for key, value, known in (
        ("energy.form", config.energy.form, ("overlap", "paper")),
        ("energy.d0", config.energy.d0, ("clamped", "paper")),
        ("warp", config.warp, ("smooth", "linear")),
        ("refine", config.refine, ("near", "off")),
        ("parry", config.parry, ("off", "on")),
    ):
        if value not in known:
            raise ConfigError(got=f"{key} = {value!r}", expected=" or ".join(known))
    if config.culling not in ("none", "paper", "binned"):
        raise ConfigError(got=f"culling = {config.culling!r}", expected="none, paper or binned")
    _IN_RANGE[id(config)] = config
