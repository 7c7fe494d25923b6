"""Many attacks at once, for coverage, sweeps and tables: the same answers as one by one."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace

import jax
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import Shots, make_shot
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.body.device_tables import search_tables
from mgjax.avoidance.body.poses import body_of
from mgjax.avoidance.candidates.batch import LENGTH, empty_walks, pad_candidates
from mgjax.avoidance.candidates.enumerate import (
    Candidates,
    enumerate_candidates,
    natural_times,
)
from mgjax.avoidance.choice.search import (
    DEPTH,
    HOPELESS_M,
    SCORES,
    STATUS,
    Found,
    Task,
    is_long,
    search_many,
)
from mgjax.avoidance.choice.start import validate_start
from mgjax.avoidance.choice.verify import settle
from mgjax.avoidance.config import AvoidanceConfig, validate_config
from mgjax.avoidance.rates import CLEAR_M
from mgjax.avoidance.timing.time_scale import OK
from mgjax.core.errors import ConfigError
from mgjax.core.xla.padding import bucket_size
from mgjax.graph.types import MotionGraph

STATUSES = ("avoided", "hit", "no_candidate")
"""Statuses of :class:`BatchSelection`, by number."""

AVOIDED, HIT, NO_CANDIDATE = 0, 1, 2
NO_PART = -1

TOGETHER = 2048
"""Candidates of one call, of as many attacks as have room."""

MOST = 64
"""Attacks of one call."""

AHEAD = 4
"""Calls that are under way while the questions of the next one are put."""

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
    shots: Shots


def select_batch(
    graph: MotionGraph,
    nodes: Sequence[int] | Int[np.ndarray, " B"],
    attacks: Sequence[Attack],
    *,
    config: AvoidanceConfig | None = None,
) -> BatchSelection:
    """The choices of :func:`mgjax.avoidance.choice.choosing.choose` for many attacks, without their
    walks.

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
    asked: deque[tuple[list[_Question], Found]] = deque()
    doubtful: list[tuple[_Question, Found]] = []
    for group in _groups(_questions(graph, places, attacks, answers, config)):
        asked.append((group, _search(graph, group, config)))
        if len(asked) > AHEAD:  # the others are computed while this one is looked at
            doubtful += _decide(*asked.popleft(), answers, config)
    for group, found in asked:
        doubtful += _decide(group, found, answers, config)
    for question, found in doubtful:  # last, since each waits for what is under way
        _settle(graph, question, found, answers, config)
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
                long = is_long(some, attack)
                shots = make_shot(attack, crop, config, body_of(graph)[1], long=long)
                yield _Question(
                    number=i, node=int(node), attack=attack, crop=crop, candidates=some, shots=shots
                )


def _groups(questions: Iterator[_Question]) -> Iterator[list[_Question]]:
    """Questions that are answered in one call: of equal shapes, as many as have room."""
    waiting: dict[tuple, tuple[list[_Question], int]] = {}
    for question in questions:
        count = len(question.candidates.length)
        shape = question.shots.frames.shape
        group, together = waiting.get(shape, ([], 0))
        if group and (len(group) == MOST or together + count > TOGETHER):
            yield group
            group, together = [], 0
        waiting[shape] = [*group, question], together + count
    yield from (group for group, _ in waiting.values())


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


def _firsts(questions: list[_Question]) -> Int[np.ndarray, " A1"]:
    """Where the candidates of each question begin and, last, where they end."""
    counts = [len(question.candidates.length) for question in questions]
    return np.concatenate([[0], np.cumsum(counts)])


def _search(graph: MotionGraph, questions: list[_Question], config: AvoidanceConfig) -> Found:
    _, device = search_tables(graph, config.body_rate, config.speed)
    firsts = _firsts(questions)
    size = bucket_size(int(firsts[-1]), TOGETHER, 4)
    long = is_long(questions[-1].candidates, questions[-1].attack)
    longest = max(question.candidates.edges.shape[1] for question in questions)
    longest = max(longest, LENGTH + 1 if long else 0)
    walks = empty_walks(bucket_size(longest, LENGTH, 4), size, shared=False)
    table = walks.table
    table[-1] = MOST - 1
    first = np.full(MOST, size - 1, np.int32)
    first[: len(questions)] = firsts[:-1]
    for number, (question, begin) in enumerate(zip(questions, firsts, strict=False)):
        some = question.candidates
        rows = slice(begin, begin + len(some.length))
        table[: some.edges.shape[1], rows] = some.edges.T
        table[-3, rows], table[-2, rows], table[-1, rows] = some.length, some.part, number
    filled = [question.shots for question in questions]
    filled += [filled[-1]] * (MOST - len(filled))
    return search_many(
        device,
        walks,
        jax.tree.map(lambda *x: np.concatenate(x), *filled),
        first,
        config.energy,
        frame_rate=graph.frame_rate,
        limit_scale=config.limit_scale,
    )


def _decide(
    questions: list[_Question],
    found: Found,
    answers: dict[str, np.ndarray],
    config: AvoidanceConfig,
) -> list[tuple[_Question, Found]]:
    """Where the bounds of the first candidate leave no doubt that is the answer; the rest."""
    found = jax.tree.map(np.asarray, found)
    firsts = _firsts(questions)
    starts, count = firsts[:-1], len(questions)
    fit = found.scores[STATUS, : firsts[-1]] == OK
    hope = fit & (found.scores[DEPTH, : firsts[-1]] >= -HOPELESS_M)
    usable, hopeful = (np.add.reduceat(x.astype(np.int64), starts) for x in (fit, hope))
    hopeful = np.minimum(np.maximum(hopeful, 1), config.checks)
    bounds = jax.tree.map(lambda x: x[:count], found.bounds)
    avoided = (usable > 0) & (bounds.least >= CLEAR_M)
    hit = (usable > 0) & (hopeful == 1) & (bounds.touched_from < bounds.path_end)
    chosen = found.order[starts]
    scores = dict(zip(SCORES, found.scores[:STATUS, chosen], strict=True))
    settled = {
        "status": np.where(avoided, AVOIDED, HIT),
        "time_scale": scores["s_time"],
        "clearance": np.asarray(bounds.clearance),
        "energy": scores["total"],
        "d": scores["d"],
    }
    rest = []
    for row, question in enumerate(questions):
        if not usable[row]:
            continue
        if not avoided[row] and not hit[row]:
            rest.append((question, _alone(found, firsts, row)))
            continue
        for name, values in settled.items():
            answers[name][question.number] = values[row]
        part = question.candidates.part[chosen[row] - starts[row]]
        answers["part"][question.number] = part
    return rest


def _alone(found: Found, firsts: Int[np.ndarray, " A1"], row: int) -> Found:
    """What was found for one of several attacks."""
    begin, end = firsts[row], firsts[row + 1]
    return Found(
        scores=found.scores[:, begin:end],
        scales=found.scales[:, begin:end],
        order=found.order[begin:end] - begin,
        bounds=jax.tree.map(lambda x: x[row : row + 1], found.bounds),
    )


def _settle(
    graph: MotionGraph,
    question: _Question,
    found: Found,
    answers: dict[str, np.ndarray],
    config: AvoidanceConfig,
) -> None:
    """One attack by looking closer."""
    q = question
    walks = pad_candidates(q.candidates, long=is_long(q.candidates, q.attack))
    task = Task(walks=walks, shots=q.shots)
    found = replace(found, scales=found.scales[: len(walks.edges)])  # padded for the whole group
    choice = settle(graph, q.node, q.attack, q.crop, q.candidates, task, found, config).choice
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
