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
from mgjax.avoidance.check import EXPORT_RATE
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

WINDOWS = (64, 256, 1024)
"""Written frames at which an attack may be near; a call is compiled for each."""


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
    window: int,
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
        window=window,
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


_STATIC = ("frame_rate", "limit_scale", "window")
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
    window: int,
) -> Found:
    """Many attacks of equal shapes at once, each with its own candidates."""
    one = partial(search, frame_rate=frame_rate, limit_scale=limit_scale, window=window)
    return jax.vmap(one, in_axes=(None, 0, 0, 0, 0, 0, None))(
        tables, edges, length, part, problems, flights, config
    )


bound = jax.jit(certify, static_argnames=("frame_rate", "window"))


@dataclass(frozen=True, kw_only=True, eq=False)
class Task:
    """One attack with its candidates, padded to compiled shapes."""

    edges: Int[np.ndarray, "C L"]
    length: Int[np.ndarray, " C"]
    part: Int[np.ndarray, " C"]
    problem: Problem
    flight: Flight
    window: int


def make_task(
    candidates: Candidates, attack: Attack, crop: Crop, config: AvoidanceConfig, reach: float
) -> Task:
    """Pads candidates and attack to compiled shapes."""
    flight = make_flight(attack, reach)
    edges, length, part = pad_candidates(candidates)
    problem = make_problem(attack, crop, config)
    window = _window(attack, flight)
    return Task(
        edges=edges, length=length, part=part, problem=problem, flight=flight, window=window
    )


def _window(attack: Attack, flight: Flight) -> int:
    """Times for which an attack that passes a body is near it, with some to spare."""
    way = np.linalg.norm(np.diff(attack.centres, axis=0), axis=-1).sum(axis=0)
    speed = float(way.min()) / max(attack.end - attack.start, 1e-6)
    reach = 2 * float(flight.margin) + 2 * float(flight.radii.max())
    frames = 1.15 * reach / max(speed, 1e-6) * EXPORT_RATE
    sizes = [w for w in WINDOWS if w <= len(flight.times)]
    return next((w for w in sizes if w >= frames), sizes[-1])
