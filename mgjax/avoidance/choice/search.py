"""From candidates to the best of them in one compiled call: timed, judged, ranked and bounded."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attacks.batch import AttackBatch, AttackColumn
from mgjax.avoidance.body.device_tables import DeviceTables
from mgjax.avoidance.candidates.batch import EDGE_BUCKET, CandidateBatch, pad_candidates
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.checks.bounds import FIRST_LANES, Bounds, clearance_bounds
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy.evaluate import Judged, judge_all, ranking
from mgjax.avoidance.energy.promise import judge_promising
from mgjax.avoidance.energy.score import ROWS, stacked
from mgjax.avoidance.timing.time_scale import OK
from mgjax.core.arrays import Array
from mgjax.core.xla.exported import exported
from mgjax.core.xla.pytree import register

HOPELESS_M = 0.02
"""Sampled volumes that are touched deeper belong to a motion that is hit: they are within
millimetres of it. Such candidates are not looked at any closer."""

DEPTH = ROWS.index("d")
STATUS = len(ROWS)
"""Row of :attr:`SearchResult.table` with the status of :mod:`mgjax.avoidance.timing.time_scale`;
before it come the measures and scores that ``ROWS`` names."""


@register()
@dataclass(frozen=True, kw_only=True)
class SearchResult:
    """Candidates judged and ranked, and bounds for the first of them.

    Attributes:
        table: measures and scores of each candidate, a row each as ``ROWS`` of
            :mod:`mgjax.avoidance.energy.score` names them, and ``STATUS``. [R, C]
        scales: factor on the duration of each edge. [L, C]
        order: their numbers, the best first; those without a time scale last. [C]
        bounds: of the first in that order. [K]
    """

    table: Float[Array, "R C"]
    scales: Float[Array, "L C"]
    order: Int[Array, " C"]
    bounds: Bounds


def search(
    tables: DeviceTables,
    walks: CandidateBatch,
    attack_batch: AttackBatch,
    config: EnergyConfig,
    *,
    frame_rate: float,
    limit_scale: bool,
) -> SearchResult:
    """One attack: from the padded candidates to their order and to bounds for the best of them.

    Args:
        tables: of the graph.
        walks: the candidates, padded.
        attack_batch: the attack.
        config: forms, scales and weights of the energies.
        frame_rate: of the graph.
        limit_scale: rejects time scales outside [1/E_time, E_time] and below 1/E_fast.
    """
    judged = judge_all(
        tables, walks, attack_batch, config, half_frame=0.5 / frame_rate, limit_scale=limit_scale
    )
    order = ranking(judged)
    best = order[: min(FIRST_LANES, order.shape[0])]
    return _result(tables, walks, attack_batch, judged, order, best, frame_rate)


def _result(
    tables: DeviceTables,
    walks: CandidateBatch,
    attack_batch: AttackBatch,
    judged: Judged,
    order: Int[Array, " C"],
    best: Int[Array, " K"],
    frame_rate: float,
) -> SearchResult:
    status = judged.timing.status
    lanes = walks.rows(best)
    # Those that cannot be timed are padding.
    length = jnp.where(status[best] == OK, lanes.length, 0)
    lanes = replace(
        lanes, table=jnp.concatenate([lanes.table[:-3], length[None], lanes.table[-2:]])
    )
    rows = stacked(judged.measures, judged.scores)
    return SearchResult(
        table=jnp.concatenate([rows, status.astype(jnp.float32)[None]]),
        scales=judged.timing.scales,
        order=order,
        bounds=clearance_bounds(
            tables, lanes, judged.timing.scales[:, best], attack_batch, frame_rate=frame_rate
        ),
    )


def search_several(
    tables: DeviceTables,
    walks: CandidateBatch,
    attack_batch: AttackBatch,
    first: Int[Array, " A"],
    whole: Bool[Array, " A"],
    config: EnergyConfig,
    *,
    frame_rate: float,
    limit_scale: bool,
) -> SearchResult:
    """Several attacks, whose candidates lie one after the other.

    Args:
        tables: of the graph.
        walks: with the attack that each is meant for, in ascending order; padding goes to the last.
        attack_batch: the attacks.
        first: number of the first candidate of each attack.
        whole: attacks whose candidates are all judged. Of others those are left out that cannot be
            the first; where one is clear, so that they follow after all that are.
        config: weights and scales.
        frame_rate, limit_scale: see :func:`search`.

    Returns:
        Candidates in the order of their attacks, and bounds for the first of each: that decides on
        19 of 20 attacks.
    """
    judged = judge_promising(
        tables,
        walks,
        attack_batch,
        first,
        whole,
        config,
        half_frame=0.5 / frame_rate,
        limit_scale=limit_scale,
    )
    order = ranking(judged, walks.owner)
    best = order[jnp.minimum(first, order.shape[0] - 1)]
    return _result(tables, walks, attack_batch, judged, order, best, frame_rate)


_STATIC = ("frame_rate", "limit_scale")
search_one = jax.jit(exported(*_STATIC)(search), static_argnames=_STATIC)
search_many = jax.jit(exported(*_STATIC)(search_several), static_argnames=_STATIC)
bound = jax.jit(exported("frame_rate")(clearance_bounds), static_argnames="frame_rate")


def in_32_bits(config: EnergyConfig) -> EnergyConfig:
    """Settings whose numbers are of 32 bits, as compiled code reads them; tracers stay."""
    names = [field.name for field in fields(config) if field.name not in ("form", "d0")]
    numbers = {name: getattr(config, name) for name in names}
    if any(isinstance(number, jax.Array) for number in numbers.values()):
        return config
    return replace(config, **{name: np.float32(number) for name, number in numbers.items()})


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchInput:
    """Candidates and attack padded to compiled shapes, the larger ones if either is long."""

    walks: CandidateBatch
    attack_batch: AttackBatch


def search_input(query: Query, candidates: Candidates) -> SearchInput:
    """Pads candidates, and the attack of a query, to compiled shapes."""
    attack_batch = attack_batch_for(query, candidates)
    walks = pad_candidates(candidates, long=attack_batch.is_long)
    return SearchInput(walks=walks, attack_batch=attack_batch)


def attack_batch_for(query: Query, candidates: Candidates) -> AttackBatch:
    """The attack of a query, padded to the larger size if some candidate has many edges."""
    long = candidates.length.max(initial=1) > EDGE_BUCKET
    return query.attack_batch.as_long() if long else query.attack_batch


def search_candidates(query: Query, candidates: Candidates) -> tuple[SearchInput, SearchResult]:
    """Candidates as compiled code reads them, and what it says of them."""
    padded = search_input(query, candidates)
    return padded, search_shifted(query, padded, 0.0)


def search_shifted(query: Query, padded: SearchInput, shift: float) -> SearchResult:
    """The same for candidates whose avoidance parts come so much later than eq. 3 has it, s."""
    attack_batch = padded.attack_batch
    if shift:
        numbers = np.array(attack_batch.numbers)
        numbers[:, AttackColumn.T_ATTACK] += np.float32(shift)
        attack_batch = replace(attack_batch, numbers=numbers)
    return search_one(
        query.prepared.device,
        padded.walks,
        attack_batch,
        in_32_bits(query.config.energy),
        frame_rate=query.prepared.graph.frame_rate,
        limit_scale=query.config.limit_scale,
    )
