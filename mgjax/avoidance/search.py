"""From candidates to the best of them in one compiled call: timed, judged, ranked and bounded."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.attack import Attack, Crop
from mgjax.avoidance.candidates import Candidates
from mgjax.avoidance.certify import LANES, Bounds, Flight, certify, make_flight
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.avoidance.device_tables import DeviceTables
from mgjax.avoidance.evaluate import (
    Problem,
    by_name,
    judge_all,
    make_problem,
    pad_candidates,
    ranking,
)
from mgjax.avoidance.time_scale import OK, PADDING
from mgjax.core.arrays import Array
from mgjax.core.pytree import register

HOPELESS_M = 0.02
"""Sampled volumes that are touched deeper belong to a motion that is hit: they are within
millimetres of it. Such candidates are not looked at any closer."""

SCORES = ("s_time", "total", "avoidance", "body", "timescale", "penetration", "d", "d0")
"""Columns of :attr:`Found.scores`."""


@register()
@dataclass(frozen=True, kw_only=True)
class Found:
    """Candidates judged and ranked, and bounds for the first of them.

    Attributes:
        scores: what each candidate is worth, see ``SCORES``. [C, 8]
        scales: factor on the duration of each edge. [C, L]
        order: their numbers, the best first; those without a time scale last. [C]
        counts: how many have each status of :mod:`mgjax.avoidance.time_scale`. [4]
        hopeful: how many of the first are not touched deeper than ``HOPELESS_M``.
        bounds: of the first in that order. [K]
    """

    scores: Float[Array, "C 8"]
    scales: Float[Array, "C L"]
    order: Int[Array, " C"]
    counts: Int[Array, " 4"]
    hopeful: Int[Array, ""]
    bounds: Bounds


def search(
    tables: DeviceTables,
    edges: Int[Array, "C L"],
    length: Int[Array, " C"],
    part: Int[Array, " C"],
    problem: Problem,
    flight: Flight,
    config: EnergyConfig,
    *,
    frame_rate: float,
    limit_scale: bool,
) -> Found:
    """One attack: from the padded candidates to their order and to bounds for the best of them."""
    judged = judge_all(
        tables,
        edges,
        length,
        part,
        problem,
        config,
        half_frame=0.5 / frame_rate,
        limit_scale=limit_scale,
    )
    order = ranking(judged)
    usable = judged.timing.status == OK
    first = order[: min(LANES, len(order))]
    bounds = certify(
        tables,
        edges[first],
        judged.timing.scales[first],
        jnp.where(usable[first], length[first], 0),
        flight,
        frame_rate=frame_rate,
    )
    values = by_name(judged)
    kinds = jnp.arange(PADDING + 1)[:, None]
    hopeful = usable & (judged.energies.d >= -HOPELESS_M)
    return Found(
        scores=jnp.stack([values[name] for name in SCORES], axis=1),
        scales=judged.timing.scales,
        order=order,
        counts=jnp.sum((judged.timing.status[None] == kinds).astype(jnp.int32), axis=1),
        hopeful=jnp.sum(hopeful.astype(jnp.int32)),
        bounds=bounds,
    )


_STATIC = ("frame_rate", "limit_scale")
search_one = jax.jit(search, static_argnames=_STATIC)


@partial(jax.jit, static_argnames=_STATIC)
def search_many(
    tables: DeviceTables,
    edges: Int[Array, "B C L"],
    length: Int[Array, "B C"],
    part: Int[Array, "B C"],
    problems: Problem,
    flights: Flight,
    config: EnergyConfig,
    *,
    frame_rate: float,
    limit_scale: bool,
) -> Found:
    """Many attacks of equal shapes at once, each with its own candidates."""
    one = partial(search, frame_rate=frame_rate, limit_scale=limit_scale)
    return jax.vmap(one, in_axes=(None, 0, 0, 0, 0, 0, None))(
        tables, edges, length, part, problems, flights, config
    )


bound = jax.jit(certify, static_argnames="frame_rate")


@dataclass(frozen=True, kw_only=True, eq=False)
class Task:
    """One attack with its candidates, padded to compiled shapes."""

    edges: Int[np.ndarray, "C L"]
    length: Int[np.ndarray, " C"]
    part: Int[np.ndarray, " C"]
    problem: Problem
    flight: Flight


def make_task(
    candidates: Candidates, attack: Attack, crop: Crop, config: AvoidanceConfig, reach: float
) -> Task:
    """Pads candidates and attack to compiled shapes."""
    flight = make_flight(attack, reach)
    edges, length, part = pad_candidates(candidates)
    problem = make_problem(attack, crop, config)
    return Task(edges=edges, length=length, part=part, problem=problem, flight=flight)
