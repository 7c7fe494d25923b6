"""Many attacks at once, for coverage, sweeps and tables: the same answers as one by one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import jax
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.attack import Attack, Crop, crop_attack
from mgjax.avoidance.candidates import Candidates, enumerate_candidates, natural_times
from mgjax.avoidance.check import CLEAR_M
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.device_tables import search_tables
from mgjax.avoidance.exact import body_of
from mgjax.avoidance.search import SCORES, Found, Task, make_task, search_many
from mgjax.avoidance.settle import settle
from mgjax.avoidance.time_scale import OK
from mgjax.avoidance.validate import validate_config, validate_start
from mgjax.core.errors import ConfigError
from mgjax.graph.types import MotionGraph

STATUSES = ("avoided", "hit", "no_candidate")
"""Statuses of :class:`BatchSelection`, by number."""

AVOIDED, HIT, NO_CANDIDATE = 0, 1, 2
NO_PART = -1

GROUP = 512
"""Padded candidates of one call: attacks of up to 32 candidates are answered sixteen at a time."""

_LIMIT = 1_000_000


@dataclass(frozen=True, kw_only=True, eq=False)
class BatchSelection:
    """The answers to many attacks, in the order they were asked.

    Attributes:
        status: ``AVOIDED``, ``HIT`` or ``NO_CANDIDATE``. [B]
        part: the avoidance part that was chosen, or ``NO_PART``. [B]
        candidates: how many satisfy eq. 1. [B]
        time_scale, clearance, energy, d: of the chosen walk; NaN without one. [B]
        t_attack: the time of the attack, s; NaN where it never comes near. [B]
    """

    status: Int[np.ndarray, " B"]
    part: Int[np.ndarray, " B"]
    candidates: Int[np.ndarray, " B"]
    time_scale: Float[np.ndarray, " B"]
    clearance: Float[np.ndarray, " B"]
    energy: Float[np.ndarray, " B"]
    d: Float[np.ndarray, " B"]
    t_attack: Float[np.ndarray, " B"]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Question:
    """One attack that has candidates."""

    number: int
    node: int
    attack: Attack
    crop: Crop
    candidates: Candidates
    task: Task


def select_batch(
    graph: MotionGraph,
    nodes: Sequence[int] | Int[np.ndarray, " B"],
    attacks: Sequence[Attack],
    *,
    config: AvoidanceConfig | None = None,
) -> BatchSelection:
    """The choices of :func:`mgjax.avoidance.choice.choose` for many attacks, without their walks.

    Attacks that are padded to the same shapes are answered in one compiled call. Candidates are
    enumerated once per node, for the widest window that any of its attacks needs.

    Args:
        graph: a motion graph with labelled avoidance parts.
        nodes: where the character stands, one for each attack.
        attacks: each in the planar frame of its node.
        config: settings.

    Raises:
        AttackError: an attack is not finite, or begins inside the body.
        ConfigError: no such node, a setting out of range, slices, or not one node for each attack.
    """
    config = config or AvoidanceConfig()
    validate_config(config)
    if config.culling != "none":
        raise ConfigError(f"got culling = {config.culling!r}, expected none where attacks are many")
    places = np.asarray(nodes, dtype=np.int64)
    if places.shape != (len(attacks),):
        raise ConfigError(f"got {places.size} nodes for {len(attacks)} attacks, expected one each")
    tables, _ = search_tables(graph, config.body_rate, config.speed)
    for node, attack in zip(places, attacks, strict=True):
        validate_start(graph, tables, int(node), attack)
    answers = _no_answers(len(attacks))
    waiting: dict[tuple, list[_Question]] = {}
    asked: list[tuple[list[_Question], Found]] = []
    for question in _questions(graph, places, attacks, answers, config):
        shapes = tuple(np.shape(x) for x in jax.tree.leaves(_inputs(question.task)))
        size = max(GROUP // shapes[0][0], 1)
        group = waiting.setdefault((size, shapes), [])
        group.append(question)
        if len(group) == size:  # computed while the next questions are put
            asked.append(([*group], _search(graph, group, config)))
            group.clear()
    for (size, _), group in waiting.items():
        if group:
            filled = group + [group[-1]] * (size - len(group))
            asked.append((group, _search(graph, filled, config)))
    for group, found in asked:
        _decide(graph, group, jax.tree.map(np.asarray, found), answers, config)
    return BatchSelection(**answers)


def _no_answers(count: int) -> dict[str, np.ndarray]:
    answers = {f.name: np.full(count, np.nan) for f in fields(BatchSelection)}
    answers["status"] = np.full(count, NO_CANDIDATE)
    answers["part"] = np.full(count, NO_PART)
    answers["candidates"] = np.zeros(count, dtype=np.int64)
    return answers


def _questions(
    graph: MotionGraph,
    nodes: Int[np.ndarray, " B"],
    attacks: Sequence[Attack],
    answers: dict[str, np.ndarray],
    config: AvoidanceConfig,
) -> Iterator[_Question]:
    """The attacks that have candidates; those of one node are enumerated together."""
    tables, _ = search_tables(graph, config.body_rate, config.speed)
    crops: dict[int, Crop] = {}
    for i, attack in enumerate(attacks):
        crop = crop_attack(attack, radius=config.crop_radius_m, height=config.crop_height_m)
        if crop is not None:
            crops[i] = crop
            answers["t_attack"][i] = crop.middle
    for node in np.unique(nodes[list(crops)] if crops else nodes[:0]):
        here = [i for i in np.flatnonzero(nodes == node).tolist() if i in crops]
        middles = [crops[i].middle for i in here]
        low, high = min(middles), max(middles)
        wide = enumerate_candidates(
            graph,
            tables,
            int(node),
            0.5 * (low + high),
            window=config.T_window + high - low,
            capacity=_LIMIT,
        )
        times = natural_times(tables, wide)
        for i, middle in zip(here, middles, strict=True):
            some = _within(wide, times, middle, config)
            answers["candidates"][i] = len(some.length) + some.overflow
            if len(some.length):
                attack, crop = attacks[i], crops[i]
                task = make_task(some, attack, crop, config, body_of(graph)[1])
                yield _Question(
                    number=i, node=int(node), attack=attack, crop=crop, candidates=some, task=task
                )


def _within(
    wide: Candidates, times: Float[np.ndarray, " C"], middle: float, config: AvoidanceConfig
) -> Candidates:
    """Those of some candidates that satisfy eq. 1 for an attack at ``middle``."""
    off = np.abs(times - middle)
    fits = np.flatnonzero(off < config.T_window / 2)
    beyond = max(len(fits) - config.capacity, 0)
    if beyond:
        fits = np.sort(fits[np.argsort(off[fits], kind="stable")[: config.capacity]])
    length = wide.length[fits]
    return Candidates(
        edges=wide.edges[fits, : int(length.max(initial=1))],
        length=length,
        part=wide.part[fits],
        overflow=wide.overflow + beyond,
    )


def _inputs(task: Task) -> tuple:
    return task.edges, task.length, task.part, task.problem, task.flight


def _search(graph: MotionGraph, questions: list[_Question], config: AvoidanceConfig) -> Found:
    _, device = search_tables(graph, config.body_rate, config.speed)
    inputs = [_inputs(question.task) for question in questions]
    return search_many(
        device,
        *jax.tree.map(lambda *x: np.stack(x), *inputs),
        config.energy,
        frame_rate=graph.frame_rate,
        limit_scale=config.limit_scale,
    )


def _decide(
    graph: MotionGraph,
    questions: list[_Question],
    found: Found,
    answers: dict[str, np.ndarray],
    config: AvoidanceConfig,
) -> None:
    """Where bounds leave no doubt about the first candidates that is the answer."""
    count = len(questions)
    usable = np.asarray(found.counts)[:count, OK]
    hopeful = np.minimum(np.maximum(np.asarray(found.hopeful)[:count], 1), config.checks)
    least, clearance, touched_from, path_end = (
        np.asarray(getattr(found.bounds, name))[:count]
        for name in ("least", "clearance", "touched_from", "path_end")
    )
    lanes = least.shape[1]
    there = (np.arange(lanes) < hopeful[:, None]) & (usable > 0)[:, None]
    clear = there & (least >= CLEAR_M)
    doubt = there & ~clear & ~(touched_from < path_end)
    first_clear = np.where(clear.any(axis=1), clear.argmax(axis=1), lanes)
    first_doubt = np.where(doubt.any(axis=1), doubt.argmax(axis=1), lanes)
    avoided = first_clear < first_doubt
    hit = ~clear.any(axis=1) & ~doubt.any(axis=1) & (usable > 0) & (hopeful <= lanes)
    nearest = np.where(there, clearance, -np.inf).argmax(axis=1)
    lane = np.where(avoided, np.minimum(first_clear, lanes - 1), nearest)
    rows = np.arange(count)
    chosen = np.asarray(found.order)[:count][rows, lane]
    scores = dict(zip(SCORES, np.asarray(found.scores)[rows, chosen].T, strict=True))
    for row, question in enumerate(questions):
        if not usable[row]:
            continue
        if not (avoided[row] or hit[row]):
            one = jax.tree.map(lambda x, row=row: x[row], found)
            _settle(graph, question, one, answers, config)
            continue
        i = question.number
        answers["status"][i] = AVOIDED if avoided[row] else HIT
        answers["part"][i] = question.task.part[chosen[row]]
        answers["time_scale"][i] = scores["s_time"][row]
        answers["clearance"][i] = clearance[row, lane[row]]
        answers["energy"][i] = scores["total"][row]
        answers["d"][i] = scores["d"][row]


def _settle(
    graph: MotionGraph,
    question: _Question,
    found: Found,
    answers: dict[str, np.ndarray],
    config: AvoidanceConfig,
) -> None:
    """One attack by looking closer."""
    q = question
    choice = settle(graph, q.node, q.attack, q.crop, q.candidates, q.task, found, config).choice
    assert choice is not None
    assert choice.energy is not None
    values = {
        "status": STATUSES.index(choice.status),
        "part": choice.part,
        "time_scale": choice.time_scale,
        "clearance": choice.clearance_m,
        "energy": choice.energy.total,
        "d": choice.energy.d,
    }
    for name, value in values.items():
        answers[name][q.number] = value
