"""Many attacks at once, for coverage, sweeps and tables, answered as they would be one by one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, replace
from functools import partial

import jax
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.choosing import can_widen, choose, widened
from mgjax.avoidance.choice.decision import decide
from mgjax.avoidance.choice.results import Choice, Dropped, Status
from mgjax.avoidance.choice.search import (
    DEPTH,
    HOPELESS_M,
    STATUS,
    SearchResult,
    in_32_bits,
    search_input,
    search_many,
)
from mgjax.avoidance.config import AvoidanceConfig, validate_config
from mgjax.avoidance.energy.score import ROWS
from mgjax.avoidance.index.protocol import CandidateIndex
from mgjax.avoidance.many.groups import (
    MOST,
    Asked,
    all_asked,
    firsts_of,
    group_batch,
    groups,
    starts_of,
)
from mgjax.avoidance.many.questions import Questions, ask_all
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.avoidance.rates import CLEAR_M
from mgjax.avoidance.timing.time_scale import OK
from mgjax.core.errors import ConfigError
from mgjax.core.parallel.run import run_all
from mgjax.core.xla.compilation import threads
from mgjax.graph.types import MotionGraph

NO_PART = -1


AHEAD = 4
"""Calls that are under way while the questions of the next one are put."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BatchSelection:
    """The answers to many attacks, in the order they were asked.

    Attributes:
        status: number of a :class:`~mgjax.avoidance.choice.results.Status`. [B]
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


def select_batch(
    graph: MotionGraph | Prepared,
    nodes: Sequence[int] | Int[np.ndarray, " B"],
    attacks: Sequence[Attack],
    *,
    config: AvoidanceConfig | None = None,
    index: CandidateIndex | None = None,
) -> BatchSelection:
    """The choices of :func:`mgjax.avoidance.choice.choosing.choose` for many attacks, without their
    walks.

    Nothing is written, so captured motion decides: feet that are kept differ from it by
    centimetres, which :func:`mgjax.avoidance.select` looks at, too (``docs/limits.md``).

    Attacks that are padded to the same shapes are answered in one compiled call. Candidates are
    enumerated once per node, for the widest window that any of its attacks needs, and for some
    nodes at once.

    Args:
        graph: a motion graph with labelled avoidance parts, or what
            :func:`~mgjax.avoidance.prepared.prepare` made of one.
        nodes: where the character stands, one for each attack.
        attacks: each in the planar frame of its node.
        config: settings.
        index: of the graph, in which candidates are looked up as :func:`mgjax.avoidance.select`
            does; what it holds nothing clear for is chosen one by one. Default: that of what was
            prepared, if any.

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
    prepared = prepared_for(graph, config, index)
    questions = ask_all(prepared, places, attacks, config)
    answers = _no_answers(len(attacks))
    # All candidates of those that are not certain then are judged.
    doubtful = _searched(questions, all_asked(questions, answers), answers, whole=False)
    rest = _searched(questions, (asked for asked, _ in doubtful), answers, whole=True)
    with ThreadPoolExecutor(threads()) as pool:
        for asked, choice in pool.map(partial(_look_closer, questions), *zip(*rest, strict=True)):
            _fill(answers, asked.number, choice)
    if config.refine != "off" or prepared.index is not None:
        _choose_rest(prepared, places, attacks, answers, config)
    elif can_widen(config):
        _try_wide(prepared, places, attacks, answers, config)
    return BatchSelection(**answers)


def _choose_rest(
    prepared: Prepared,
    places: Int[np.ndarray, " B"],
    attacks: Sequence[Attack],
    answers: dict[str, np.ndarray],
    config: AvoidanceConfig,
) -> None:
    """Answers what is not avoided one by one: by what the index left out, near misses that are
    refined, and then a wider window."""
    open_ = (answers["status"] != Status.AVOIDED.code) & np.isfinite(answers["t_attack"])
    for number in np.flatnonzero(open_).tolist():
        choice = choose(prepared, int(places[number]), attacks[number], config=config)
        answers["candidates"][number] = choice.candidates
        if choice.energy is not None:
            _fill(answers, number, choice)


def _try_wide(
    prepared: Prepared,
    places: Int[np.ndarray, " B"],
    attacks: Sequence[Attack],
    answers: dict[str, np.ndarray],
    config: AvoidanceConfig,
) -> None:
    """Answers with the wide window what is not avoided with the usual one."""
    again = np.flatnonzero(
        (answers["status"] != Status.AVOIDED.code) & np.isfinite(answers["t_attack"])
    )
    if not len(again):
        return
    wide = select_batch(
        prepared, places[again], [attacks[i] for i in again.tolist()], config=widened(config)
    )
    none = Status.NO_CANDIDATE.code
    clearer = ~(np.nan_to_num(answers["clearance"][again]) >= np.nan_to_num(wide.clearance))
    better = (wide.status != none) & (
        (wide.status == Status.AVOIDED.code) | (answers["status"][again] == none) | clearer
    )
    for name, values in answers.items():
        found = getattr(wide, name)
        rows = slice(None) if name == "candidates" else better
        values[again[rows]] = found[rows]


def _no_answers(count: int) -> dict[str, np.ndarray]:
    answers = {f.name: np.full(count, np.nan) for f in fields(BatchSelection)}
    answers["status"] = np.full(count, Status.NO_CANDIDATE.code)
    answers["part"] = np.full(count, NO_PART)
    answers["candidates"] = np.zeros(count, dtype=np.int64)
    return answers


def _searched(
    questions: Questions, asked: Iterable[Asked], answers: dict[str, np.ndarray], *, whole: bool
) -> list[tuple[Asked, SearchResult]]:
    """Answers some attacks in groups; those of which more has to be known."""
    doubtful: list[tuple[Asked, SearchResult]] = []
    with ThreadPoolExecutor(threads()) as pool:
        work = partial(_search, questions, whole)
        # While some groups are computed the next ones are laid out.
        for _, (group, result) in run_all(pool, work, groups(asked), ahead=AHEAD):
            doubtful += _decide_by_bounds(group, result, answers, questions.config)
    return doubtful


def _search(
    questions: Questions, whole: bool, group: list[Asked]
) -> tuple[list[Asked], SearchResult]:
    """A group, and what compiled code says of it."""
    prepared, config = questions.prepared, questions.config
    first = firsts_of(group)
    walks, attack_batch = group_batch(group, first)
    result = search_many(
        prepared.device,
        walks,
        attack_batch,
        starts_of(first, walks.table.shape[1]),
        np.full(MOST, whole),
        in_32_bits(config.energy),
        frame_rate=prepared.graph.frame_rate,
        limit_scale=config.limit_scale,
    )
    return group, jax.tree.map(np.asarray, result)


def _decide_by_bounds(
    group: list[Asked],
    result: SearchResult,
    answers: dict[str, np.ndarray],
    config: AvoidanceConfig,
) -> list[tuple[Asked, SearchResult]]:
    """Where the bounds of the first candidate leave no doubt that is the answer; the rest."""
    firsts = firsts_of(group)
    starts, count = firsts[:-1], len(group)
    fit = result.table[STATUS, : firsts[-1]] == OK
    hope = fit & (result.table[DEPTH, : firsts[-1]] >= -HOPELESS_M)
    usable, hopeful = (np.add.reduceat(x.astype(np.int64), starts) for x in (fit, hope))
    hopeful = np.minimum(np.maximum(hopeful, 1), config.checks)
    bounds = jax.tree.map(lambda x: x[:count], result.bounds)
    avoided = (usable > 0) & (bounds.lower_bound >= CLEAR_M)
    hit = (usable > 0) & (hopeful == 1) & (bounds.contact_from < bounds.path_end)
    chosen = result.order[starts]
    values = dict(zip(ROWS, result.table[:STATUS, chosen], strict=True))
    decided = {
        "status": np.where(avoided, Status.AVOIDED.code, Status.HIT.code),
        "time_scale": values["s_time"],
        "clearance": np.asarray(bounds.clearance),
        "energy": values["total"],
        "d": values["d"],
    }
    numbers = np.array([asked.number for asked in group])
    sure = (usable > 0) & (avoided | hit)
    for name, column in decided.items():
        answers[name][numbers[sure]] = column[sure]
    for row in np.flatnonzero(sure).tolist():
        asked = group[row]
        answers["part"][asked.number] = asked.found.part[asked.rows[chosen[row] - starts[row]]]
    doubtful = np.flatnonzero((usable > 0) & ~sure).tolist()
    return [(group[row], _alone(result, firsts, row)) for row in doubtful]


def _alone(result: SearchResult, firsts: Int[np.ndarray, " A1"], row: int) -> SearchResult:
    """What was found for one of several attacks."""
    begin, end = firsts[row], firsts[row + 1]
    return SearchResult(
        table=result.table[:, begin:end].copy(),
        scales=result.scales[:, begin:end].copy(),
        order=result.order[begin:end] - begin,
        bounds=jax.tree.map(lambda x: x[row : row + 1], result.bounds),
    )


def _look_closer(questions: Questions, asked: Asked, result: SearchResult) -> tuple[Asked, Choice]:
    """Decides on one attack alone, with the exact check where bounds leave a doubt."""
    query, candidates = questions.query(asked.number, asked.attack_batch), asked.candidates
    padded = search_input(query, candidates)
    result = replace(result, scales=result.scales[: len(padded.walks.edges)])  # the group's padding
    dropped = Dropped(overflow=candidates.overflow)
    choice = decide(query, padded, result, len(candidates.length), dropped).choice
    assert choice is not None
    return asked, choice


def _fill(answers: dict[str, np.ndarray], number: int, choice: Choice) -> None:
    """The row of one attack."""
    assert choice.energy is not None
    values = {
        "status": choice.status.code,
        "part": choice.part,
        "time_scale": choice.time_scale,
        "clearance": choice.clearance_m,
        "energy": choice.energy.total,
        "d": choice.energy.d,
    }
    for name, value in values.items():
        answers[name][number] = value
