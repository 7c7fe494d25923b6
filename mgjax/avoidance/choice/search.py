"""From candidates to the best of them in one compiled call: timed, judged, ranked and bounded."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import lru_cache

import jax
import jax.numpy as jnp
from jaxtyping import Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import FRAMES, Shots, frames_of, make_shot
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.body.device_tables import DeviceTables
from mgjax.avoidance.candidates.batch import LENGTH, Walks, pad_candidates
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.checks.bounds import LANES, Bounds, certify
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.avoidance.energy.score import Judged, by_name, judge_all, ranking
from mgjax.avoidance.timing.time_scale import OK
from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register

HOPELESS_M = 0.02
"""Sampled volumes that are touched deeper belong to a motion that is hit: they are within
millimetres of it. Such candidates are not looked at any closer."""

SCORES = ("s_time", "total", "avoidance", "body", "timescale", "penetration", "d", "d0")
"""First rows of :attr:`Found.scores`."""

DEPTH = SCORES.index("d")
STATUS = len(SCORES)
"""Its last row: the status of :mod:`mgjax.avoidance.timing.time_scale`."""


@register()
@dataclass(frozen=True, kw_only=True)
class Found:
    """Candidates judged and ranked, and bounds for the first of them.

    Attributes:
        scores: what each candidate is worth, see ``SCORES`` and ``STATUS``. [9, C]
        scales: factor on the duration of each edge. [L, C]
        order: their numbers, the best first; those without a time scale last. [C]
        bounds: of the first in that order. [K]
    """

    scores: Float[Array, "9 C"]
    scales: Float[Array, "L C"]
    order: Int[Array, " C"]
    bounds: Bounds


def search(
    tables: DeviceTables,
    walks: Walks,
    shots: Shots,
    config: EnergyConfig,
    *,
    frame_rate: float,
    limit_scale: bool,
) -> Found:
    """One attack: from the padded candidates to their order and to bounds for the best of them."""
    judged = judge_all(
        tables, walks, shots, config, half_frame=0.5 / frame_rate, limit_scale=limit_scale
    )
    order = ranking(judged)
    best = order[: min(LANES, order.shape[0])]
    return _found(tables, walks, shots, judged, order, best, frame_rate)


def _found(
    tables: DeviceTables,
    walks: Walks,
    shots: Shots,
    judged: Judged,
    order: Int[Array, " C"],
    best: Int[Array, " K"],
    frame_rate: float,
) -> Found:
    status = judged.timing.status
    lanes = walks.rows(best)
    # Those that cannot be timed are padding.
    length = jnp.where(status[best] == OK, lanes.length, 0)
    lanes = replace(
        lanes, table=jnp.concatenate([lanes.table[:-3], length[None], lanes.table[-2:]])
    )
    values = by_name(judged)
    rows = [values[name] for name in SCORES]
    return Found(
        scores=jnp.stack([*rows, status.astype(jnp.float32)]),
        scales=judged.timing.scales,
        order=order,
        bounds=certify(tables, lanes, judged.timing.scales[:, best], shots, frame_rate=frame_rate),
    )


def search_several(
    tables: DeviceTables,
    walks: Walks,
    shots: Shots,
    first: Int[Array, " A"],
    config: EnergyConfig,
    *,
    frame_rate: float,
    limit_scale: bool,
) -> Found:
    """Several attacks, whose candidates lie one after the other.

    Args:
        tables: of the graph.
        walks: with the attack that each is meant for, in ascending order; padding goes to the last.
        shots: the attacks.
        first: number of the first candidate of each attack.
        config: weights and scales.
        frame_rate, limit_scale: see :func:`search`.

    Returns:
        The same, with candidates in the order of their attacks, and bounds for the first of each:
        that settles 19 of 20 attacks.
    """
    judged = judge_all(
        tables, walks, shots, config, half_frame=0.5 / frame_rate, limit_scale=limit_scale
    )
    order = ranking(judged, walks.owner)
    best = order[jnp.minimum(first, order.shape[0] - 1)]
    return _found(tables, walks, shots, judged, order, best, frame_rate)


_STATIC = ("frame_rate", "limit_scale")
search_one = jax.jit(search, static_argnames=_STATIC)
search_many = jax.jit(search_several, static_argnames=_STATIC)
bound = jax.jit(certify, static_argnames="frame_rate")


def on_device(config: EnergyConfig) -> EnergyConfig:
    """Settings with jax arrays for numbers, since handing numbers over takes time in every call."""
    if any(isinstance(getattr(config, field.name), jax.Array) for field in fields(config)):
        return config
    return _kept(config)


@lru_cache(maxsize=64)
def _kept(config: EnergyConfig) -> EnergyConfig:
    names = [field.name for field in fields(config) if field.name not in ("form", "d0")]
    numbers = {name: jnp.asarray(getattr(config, name), dtype=jnp.float32) for name in names}
    return replace(config, **numbers)


@dataclass(frozen=True, kw_only=True, eq=False)
class Task:
    """One attack with its candidates, padded to compiled shapes."""

    walks: Walks
    shots: Shots


def make_task(
    candidates: Candidates, attack: Attack, crop: Crop, config: AvoidanceConfig, reach: float
) -> Task:
    """Pads candidates and attack to compiled shapes."""
    long = is_long(candidates, attack)
    return Task(
        walks=pad_candidates(candidates, long=long),
        shots=make_shot(attack, crop, config, reach, long=long),
    )


def is_long(candidates: Candidates, attack: Attack) -> bool:
    """Whether walks have so many edges, or an attack so many frames, that both are padded more."""
    first, last = frames_of(attack)
    return int(candidates.length.max(initial=1)) > LENGTH or last - first + 1 > FRAMES
