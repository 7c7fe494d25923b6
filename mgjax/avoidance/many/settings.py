"""One attack under many settings of the energies: each answer is that of a search of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.start import ask
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig, for_body, validate_config
from mgjax.avoidance.energy.score import Energy
from mgjax.avoidance.many.lazy_checks import ScoredAttack, score_attack
from mgjax.avoidance.many.reweight import NONE, Certainty, Picked
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.core.errors import ConfigError
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.graph.types import MotionGraph


@dataclass(frozen=True, kw_only=True, eq=False)
class Swept:
    """What each setting chooses against one attack.

    Attributes:
        status: number of a :class:`~mgjax.avoidance.choice.results.Status`. [G]
        number: the chosen candidate, or −1. [G]
        time_scale, clearance: of the chosen walk, as a search reports them; NaN without one. [G]
        penetration, d, d0, displacement: of the chosen walk (eqs 4–7); NaN without one. [G]
        avoidance, body, movement, timescale, total: its energies; NaN without one. [G]
        usable: candidates that can be timed. [G]
        apart: those of them whose sampled clearance is not negative. [G]
        saturated: how many of the latter have an avoidance energy of 0, of 1, and a body energy of
            1. [G, 3]
        candidates: those that satisfy eq. 1; None where the attack never comes near.
        crop: the part of the attack that counted, or None.
    """

    status: Int[np.ndarray, " G"]
    number: Int[np.ndarray, " G"]
    time_scale: Float[np.ndarray, " G"]
    clearance: Float[np.ndarray, " G"]
    penetration: Float[np.ndarray, " G"]
    d: Float[np.ndarray, " G"]
    d0: Float[np.ndarray, " G"]
    displacement: Float[np.ndarray, " G"]
    avoidance: Float[np.ndarray, " G"]
    body: Float[np.ndarray, " G"]
    movement: Float[np.ndarray, " G"]
    timescale: Float[np.ndarray, " G"]
    total: Float[np.ndarray, " G"]
    usable: Int[np.ndarray, " G"]
    apart: Int[np.ndarray, " G"]
    saturated: Int[np.ndarray, "G 3"]
    candidates: Candidates | None
    crop: Crop | None

    def part(self, setting: int) -> int | None:
        """The avoidance part that a setting chooses, or None."""
        number = self.number[setting]
        return None if number < 0 or self.candidates is None else int(self.candidates.part[number])

    def path(self, setting: int) -> tuple[int, ...]:
        """The edges of the path that a setting chooses; none without a candidate."""
        number = self.number[setting]
        if number < 0 or self.candidates is None:
            return ()
        length = self.candidates.length[number]
        return tuple(self.candidates.edges[number, :length].tolist())


def sweep_energies(
    graph: MotionGraph | Prepared,
    node: int,
    attack: Attack,
    energies: Sequence[EnergyConfig],
    *,
    config: AvoidanceConfig | None = None,
) -> Swept:
    """What :func:`mgjax.avoidance.choice.choosing.choose` answers under each of many settings, at
    once.

    Candidates are enumerated, timed and judged once, and bounded once; one compiled call ranks them
    again for all settings. Only candidates that a setting would choose and whose bounds leave a
    doubt are looked at closer, each of them once.

    Args:
        graph: a motion graph with labelled avoidance parts, or what
            :func:`~mgjax.avoidance.prepared.prepare` made of one.
        node: where the character stands.
        attack: in the planar frame of the body at the node.
        energies: the settings, all with the same ``form`` and ``d0``.
        config: all other settings; its ``energy`` is not used, no wider window than
            ``T_window`` is tried, and near misses are not refined.

    Raises:
        AttackError: the attack is not finite, or begins inside the body.
        ConfigError: no such node, a setting out of range, slices, or settings of more than one
            form.
    """
    config = config or AvoidanceConfig()
    if config.culling != "none":
        raise ConfigError(f"got culling = {config.culling!r}, expected none in a sweep")
    prepared = prepared_for(graph, config)
    grid = _stack(energies, config, prepared.graph.body_scale)
    # Candidates are judged once for all settings, so by every measure.
    query = ask(prepared, node, attack, replace(config, energy=EnergyConfig()))
    count = len(energies)
    if query is None:
        return _no_answers(count, None, None)
    if not len(query.in_time.length):
        return _no_answers(count, query.in_time, query.crop)
    scored = score_attack(query, energies[0].form, float(np.max(grid.E_time)))
    picked = scored.pick(grid)
    while True:
        numbers = np.setdiff1d(np.asarray(picked.number), [NONE])
        doubtful = numbers[scored.certainty[numbers] == Certainty.UNKNOWN]
        if not len(doubtful):
            return _answers(scored, picked, count)
        scored.look_closer(doubtful)
        picked = scored.pick(grid)


def _stack(energies: Sequence[EnergyConfig], config: AvoidanceConfig, scale: float) -> EnergyConfig:
    """Settings of a body's size as one whose numbers are arrays, padded to few by the last."""
    if not energies:
        raise ConfigError("got no settings of the energies, expected one or more")
    kinds = {(energy.form, energy.d0) for energy in energies}
    if len(kinds) > 1:
        raise ConfigError(f"got settings of {len(kinds)} forms, expected one form and one d0")
    for energy in energies:
        validate_config(replace(config, energy=energy))
    energies = [for_body(replace(config, energy=energy), scale).energy for energy in energies]
    size = bucket_size(len(energies), 8)
    names = [field.name for field in fields(EnergyConfig) if field.name not in ("form", "d0")]
    columns = {
        name: pad_axis(np.array([getattr(e, name) for e in energies], dtype=np.float32), size)
        for name in names
    }
    # The form is that of the judged candidates; here it would only compile anew.
    return replace(EnergyConfig(d0=energies[0].d0), **columns)


def _no_answers(count: int, candidates: Candidates | None, crop: Crop | None) -> Swept:
    counts = {"status": Status.NO_CANDIDATE.code, "number": NONE, "usable": 0, "apart": 0}
    numbers = {name: np.full(count, np.nan) for name in ("time_scale", "clearance", *_VALUES)}
    return Swept(
        **{name: np.full(count, value) for name, value in counts.items()},
        **numbers,
        saturated=np.zeros((count, 3), np.int64),
        candidates=candidates,
        crop=crop,
    )


_VALUES = tuple(
    field.name for field in fields(Swept) if field.name in {other.name for other in fields(Energy)}
)
"""Measures and scores that a sweep reports."""


def _answers(scored: ScoredAttack, picked: Picked, count: int) -> Swept:
    """What was picked, without the padding."""
    number = np.asarray(picked.number)[:count].astype(np.int64)
    real = number != NONE
    measures = scored.judged.measures
    values = {
        "time_scale": np.asarray(measures.s_time)[number],
        "clearance": scored.clearance[number],
    }
    for name in _VALUES:
        if hasattr(measures, name):
            values[name] = np.asarray(getattr(measures, name))[number]
        else:
            values[name] = np.asarray(getattr(picked.scores, name))[:count]
    clear = scored.certainty[number] == Certainty.CLEAR
    status = np.where(clear, Status.AVOIDED.code, Status.HIT.code)
    return Swept(
        status=np.where(real, status, Status.NO_CANDIDATE.code),
        number=number,
        **{name: np.where(real, x, np.nan).astype(np.float64) for name, x in values.items()},
        usable=np.asarray(picked.usable)[:count],
        apart=np.asarray(picked.apart)[:count],
        saturated=np.asarray(picked.saturated)[:count],
        candidates=scored.candidates,
        crop=scored.query.crop,
    )
