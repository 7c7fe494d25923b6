"""Balls under many settings at once, and how each setting's answers differ from the reference."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.avoidance.throws import OUTCOMES, Throws, percentiles, summary
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.avoidance.many.settings import Swept, sweep_energies
from mgjax.core.errors import AttackError
from mgjax.graph.types import MotionGraph

SATURATED = ("avoidance_0", "avoidance_1", "body_1")
"""An avoidance energy of 0 and of 1, a body energy of 1."""


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What one setting chose against one ball; NaN and () where nothing was chosen."""

    outcome: str
    path: tuple[int, ...]
    """The avoidance part, then the edges up to it."""
    clearance: float
    time_scale: float
    avoidance: float
    body: float
    apart: int
    saturated: tuple[int, ...]
    candidates: int
    timed: int


REFUSED = Answer(
    outcome="refused",
    path=(),
    clearance=np.nan,
    time_scale=np.nan,
    avoidance=np.nan,
    body=np.nan,
    apart=0,
    saturated=(0, 0, 0),
    candidates=0,
    timed=0,
)


def measure(
    graph: MotionGraph,
    throws: Throws,
    energies: dict[str, EnergyConfig],
    config: AvoidanceConfig,
    reference: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """One row for each setting of the energies, compared with the reference.

    Args:
        graph, throws: what is thrown at.
        energies: by name, all of one form.
        config: the other settings.
        reference: ``balls`` of an earlier call; None: the first setting of this one.

    Returns:
        ``rows`` by name, ``balls`` of the reference (per ball: path, clearance, outcome) where
        there was none, and ``seconds``.
    """
    start = time.perf_counter()
    answers: list[list[Answer]] = [[] for _ in energies]
    for number in range(len(throws)):
        node, attack = throws.node_of(number, graph), throws.attack(number)
        try:
            swept = sweep_energies(graph, node, attack, list(energies.values()), config=config)
        except AttackError:
            for column in answers:
                column.append(REFUSED)
            continue
        for setting, column in enumerate(answers):
            column.append(_answer(swept, setting))
    seconds = time.perf_counter() - start
    own = {} if reference is not None else {"balls": _balls(answers[0])}
    balls = reference or own["balls"]
    rows = {
        name: _row(graph, column, balls) for name, column in zip(energies, answers, strict=True)
    }
    return {"rows": rows, "seconds": seconds, **own}


def _answer(swept: Swept, setting: int) -> Answer:
    part = swept.part(setting)
    found = swept.candidates
    candidates = 0 if found is None else len(found.length) + found.overflow
    outcome = tuple(Status)[swept.status[setting]]
    if outcome == "no_candidate":
        outcome = "not_near" if swept.crop is None else outcome
        outcome = "no_time_scale" if candidates else outcome
    return Answer(
        outcome=outcome,
        path=() if part is None else (part, *swept.path(setting)),
        clearance=float(swept.clearance[setting]),
        time_scale=float(swept.time_scale[setting]),
        avoidance=float(swept.avoidance[setting]),
        body=float(swept.body[setting]),
        apart=int(swept.apart[setting]),
        saturated=tuple(swept.saturated[setting].tolist()),
        candidates=candidates,
        timed=int(swept.usable[setting]),
    )


def _balls(answers: list[Answer]) -> dict[str, Any]:
    return {
        "path": [list(answer.path) for answer in answers],
        "clearance_m": [answer.clearance for answer in answers],
        "outcome": [OUTCOMES.index(answer.outcome) for answer in answers],
    }


def _row(graph: MotionGraph, answers: list[Answer], balls: dict[str, Any]) -> dict[str, Any]:
    """What the answers of one setting amount to; shares are of all balls."""
    count = len(answers)
    shares = summary([a.outcome for a in answers], [a.clearance for a in answers])
    avoided = [a for a in answers if a.outcome == "avoided"]
    here = np.array([a.outcome == "avoided" for a in answers])
    there = np.array(balls["outcome"]) == OUTCOMES.index("avoided")
    change = [
        a.clearance - before
        for a, before, both in zip(answers, balls["clearance_m"], here & there, strict=True)
        if both
    ]
    parts = [a.path[0] for a in avoided]
    scales = np.array([a.time_scale for a in avoided])
    return {
        **{key: x for key, x in shares.items() if key not in ("outcome", "clearance_m")},
        "changed": sum(list(a.path) != path for a, path in zip(answers, balls["path"], strict=True))
        / count,
        "gained": float((here & ~there).mean()),
        "lost": float((there & ~here).mean()),
        "clearance_m_p5_p50_p95": percentiles([a.clearance for a in avoided], (5, 50, 95)),
        "clearance_change_m_mean": float(np.mean(change)) if change else None,
        "time_scale_p5_p50_p95": percentiles(scales.tolist(), (5, 50, 95)),
        "scaling_p50_p95": percentiles(np.maximum(scales, 1 / scales).tolist(), (50, 95)),
        "candidates_mean": float(np.mean([a.candidates for a in answers])),
        "apart_mean": float(np.mean([a.apart for a in answers])),
        "with_two_or_more_apart": sum(a.apart > 1 for a in answers) / count,
        "timed_mean": float(np.mean([a.timed for a in answers])),
        "avoided_by_a_genuine_part": float(graph.label_genuine[parts].sum()) / count,
        "avoided_by_kind": {
            kind: n / count
            for kind, n in sorted(Counter(graph.label_kind[part] for part in parts).items())
        },
        "saturated_chosen": _of_chosen(avoided),
        "saturated_candidates": _of_candidates(answers),
    }


def _of_chosen(avoided: list[Answer]) -> dict[str, float] | None:
    """How often the energies of the walks chosen are saturated."""
    if not avoided:
        return None
    first, second = (np.array([getattr(a, key) for a in avoided]) for key in ("avoidance", "body"))
    shares = (first <= 0).mean(), (first >= 1).mean(), (second >= 1).mean()
    return dict(zip(SATURATED, map(float, shares), strict=True))


def _of_candidates(answers: list[Answer]) -> dict[str, float] | None:
    """The same over all timed candidates that the ball does not touch by their samples."""
    count = sum(a.apart for a in answers)
    if not count:
        return None
    totals = np.sum([a.saturated for a in answers], axis=0) / count
    return dict(zip(SATURATED, totals.tolist(), strict=True))
