"""The answer to an attack: the chosen walk, its motion, and the proof that it is clear."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Literal

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.checks.written import SphereTrajectory, WrittenWalk, write_walk
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.parrying import first_parried, others_of
from mgjax.avoidance.choice.results import Choice, Status
from mgjax.avoidance.config import AvoidanceConfig, for_body
from mgjax.avoidance.index.protocol import CandidateIndex
from mgjax.avoidance.parry.parry import Parry
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.avoidance.rates import CLEAR_M, FAR
from mgjax.avoidance.refinement.refine import change_written, refine_walks, retimed
from mgjax.avoidance.timing.walk_warps import both_warps, linear_warp
from mgjax.core.motion import Motion
from mgjax.core.shown import Shown, made_of
from mgjax.core.timing.time_warp import TimeWarp
from mgjax.graph.feet.course import FeetState
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, extend


@dataclass(frozen=True, kw_only=True, eq=False)
class Selection(Choice, Shown):
    """The answer to an attack: a choice, and its motion.

    ``status`` and ``clearance_m`` are those of the motion as it is written; ``walk`` has the scales
    of eq. 3, also where it is played smoothly.

    Attributes:
        warp: how the motion plays the walk: ``linear``, with one speed per edge, where that is
            asked for, where the attack would touch the smooth form, where that would be faster
            than ``E_fast``, and where nothing is avoided.
        timing: which moment of the walk as captured the motion shows when.
        motion: from now until the attack is over, in the planar frame of its first pose.
        trace: the body's spheres over that motion.
    """

    warp: Literal["smooth", "linear"]
    timing: TimeWarp
    motion: Motion
    trace: SphereTrajectory


def select(
    graph: MotionGraph | Prepared,
    node: int,
    attack: Attack,
    *,
    config: AvoidanceConfig | None = None,
    seed: int = 0,
    index: CandidateIndex | None = None,
    begin: FeetState | None = None,
) -> Selection:
    """Chooses and time-scales the walk that avoids an attack with the least movement.

    The character stands at ``node`` now, and the path begins now. Candidates are all walks to an
    avoidance part whose middle is within T_window/2 of the middle of the cropped attack (eq. 1);
    each is scaled in time to meet it (eq. 3) and judged by its energies (eq. 10). In the order of
    their energy they are checked exactly, by forward kinematics, against the whole attack, and the
    first that stays clear wins: as captured and as it is written, with its feet kept. What follows
    its end is chosen so that it stays clear until ``settle_s`` after the attack. Where none does,
    an arm may parry (``config.parry``; :func:`mgjax.avoidance.parry.parry.find_parry`).

    Args:
        graph: a motion graph with labelled avoidance parts, or what
            :func:`~mgjax.avoidance.prepared.prepare` made of one; of a graph it is kept.
        node: where the character stands.
        attack: in the planar frame of the body at the node.
        config: settings.
        seed: for the walk that is taken where there is no candidate.
        index: of the graph (:func:`mgjax.avoidance.build_index`), in which candidates are looked up
            (§5.1); without it, or where it holds none that is clear, they are enumerated.
        begin: what the feet are off now, in the planar frame of the node, from what was played
            before; default: nothing, and the first pose is that of the node.

    Raises:
        AttackError: the attack is not finite, or begins inside the body.
        ConfigError: no such node, or a setting out of range.
    """
    config = config or AvoidanceConfig()
    prepared = prepared_for(graph, config, index)
    made: list[tuple[Walk, Draft]] = []

    def as_written(choice: Choice) -> float:
        draft = draft_of(prepared, attack, choice, config, begin)
        made[:] = [(choice.walk, draft)]
        return _clearance(draft)

    choice = choose(
        prepared, node, attack, config=config, seed=seed, as_written=as_written, begin=begin
    )
    if choice.status == Status.AVOIDED and made and made[0][0] is choice.walk:
        return _selection(prepared, attack, choice, made[0][1])
    selection = write(prepared, attack, choice, config, begin)
    if config.parry == "off" or selection.status == Status.AVOIDED or selection.crop is None:
        return selection
    walks = [selection.walk, *others_of(prepared, node, attack, seed)]
    found = first_parried(prepared, walks, attack, config, begin)
    return selection if found is None else _parried(prepared, attack, selection, *found)


def _parried(
    prepared: Prepared,
    attack: Attack,
    selection: Selection,
    number: int,
    parry: Parry,
    written: WrittenWalk,
) -> Selection:
    """The answer with an arm that meets the attack, on its own walk (number 0) or another."""
    if number:
        nothing = {"path_length": 0, "part": None, "time_scale": None, "energy": None}
        timing = linear_warp(prepared.graph, written.walk)
        selection = replace(selection, **nothing, timing=timing)
    parried = replace(
        selection,
        status=Status.PARRIED,
        parry=parry,
        walk=written.walk,
        motion=written.motion,
        trace=written.trace,
        clearance_m=parry.clearance_m,
        clear_until=None,
    )
    return made_of(parried, prepared.graph, attack)


def write(
    prepared: Prepared,
    attack: Attack,
    choice: Choice,
    config: AvoidanceConfig,
    begin: FeetState | None = None,
) -> Selection:
    """Makes the motion of a choice, and checks that very motion once more.

    Its clearance, and so the status, come from the forward kinematics of what is written. A choice
    that is clear is played smoothly if it is clear then, too.
    """
    return _selection(prepared, attack, choice, draft_of(prepared, attack, choice, config, begin))


@dataclass(frozen=True, kw_only=True, eq=False)
class Draft:
    """A choice as it is written, and how it is played."""

    form: Literal["smooth", "linear"]
    timing: TimeWarp
    choice: Choice
    written: WrittenWalk


def draft_of(
    prepared: Prepared,
    attack: Attack,
    choice: Choice,
    config: AvoidanceConfig,
    begin: FeetState | None,
) -> Draft:
    """Writes a choice: smoothly where it is clear then, else with one speed per edge."""
    fastest = float(config.energy.E_fast) if config.limit_scale else math.inf
    linear, smooth = both_timings(prepared.graph, choice, fastest)
    if config.warp == "smooth" and choice.status == Status.AVOIDED and smooth is not linear:
        fitted = _fitted(prepared, attack, choice, config, smooth, begin)
        if fitted is not None:
            draft = _draft(prepared, attack, fitted, config, "smooth", smooth, begin)
            if _clearance(draft) >= CLEAR_M:
                return draft
    return _draft(prepared, attack, choice, config, "linear", linear, begin)


def _fitted(
    prepared: Prepared,
    attack: Attack,
    choice: Choice,
    config: AvoidanceConfig,
    timing: TimeWarp,
    begin: FeetState | None,
) -> Choice | None:
    """A choice whose refinement, if it has one, suits another timing; None where none does."""
    if choice.refinement is None:
        return choice
    config = for_body(config, prepared.graph.body_scale)
    change = retimed(prepared, choice.walk, timing, choice.refinement, attack, config, begin)
    return None if change is None else replace(choice, refinement=change)


def both_timings(
    graph: MotionGraph, choice: Choice, fastest: float = math.inf
) -> tuple[TimeWarp, TimeWarp]:
    """How a walk is played with one speed per edge, and smoothly, nothing beyond ``fastest``."""
    walk, part, crop = choice.walk, choice.part, choice.crop
    if part is None or crop is None:
        linear = linear_warp(graph, walk)
        return linear, linear
    return both_warps(graph, walk, choice.path_length, part, (crop.start, crop.end), fastest)


def _draft(
    prepared: Prepared,
    attack: Attack,
    choice: Choice,
    config: AvoidanceConfig,
    form: Literal["smooth", "linear"],
    timing: TimeWarp,
    begin: FeetState | None,
) -> Draft:
    refinement, walk, seconds = choice.refinement, choice.walk, attack.end + config.settle_s
    if refinement is not None:
        seconds = max(seconds, refinement.stop)
        walk = extend(prepared.graph, walk, seconds)
    written = write_walk(
        prepared.graph,
        prepared.tables.spheres,
        walk,
        seconds,
        timing if form == "smooth" else None,
        None if choice.part is None else attack,
        begin,
        None if refinement is None else partial(change_written, prepared.graph, refinement),
    )
    return Draft(form=form, timing=timing, choice=choice, written=written)


def _clearance(draft: Draft) -> float:
    return FAR if draft.written.clearance is None else draft.written.clearance


def _selection(prepared: Prepared, attack: Attack, choice: Choice, draft: Draft) -> Selection:
    written = draft.written
    choice = replace(choice, refinement=draft.choice.refinement)
    if written.clearance is not None:
        clear = written.clearance >= CLEAR_M
        if clear and choice.status == Status.HIT:  # by kept feet alone
            dropped = replace(choice.dropped, hit=choice.dropped.hit - 1)
            choice = replace(choice, dropped=dropped, clear_until=None)
        choice = replace(choice, status=Status.AVOIDED if clear else Status.HIT)
    values = {field.name: getattr(choice, field.name) for field in fields(choice)}
    values |= {"clearance_m": written.clearance, "walk": written.walk}
    selection = Selection(
        **values, warp=draft.form, timing=draft.timing, motion=written.motion, trace=written.trace
    )
    return made_of(selection, prepared.graph, attack)


def refine(
    graph: MotionGraph | Prepared,
    selection: Selection,
    attack: Attack,
    *,
    config: AvoidanceConfig | None = None,
) -> Selection:
    """Changes the motion of an answer that is hit as little as it takes to be clear of the attack.

    The root, the trunk, the neck, the arms and feet that stand on nothing are led aside by curves
    that are smooth in time and vanish at both ends; legs follow, and planted feet stay where they
    are. Joints stay within what the graph's clips show of them.

    Args:
        graph: as of :func:`select`.
        selection: the answer.
        attack: what it answers.
        config: settings; of those of the refinement the caps.

    Returns:
        The answer with a changed motion, :attr:`~mgjax.avoidance.Choice.refinement` saying how; the
        answer itself where it avoids the attack anyway, has no candidate, or cannot be made clear
        within ``refine_max_m`` and ``refine_max_deg``.

    Raises:
        ConfigError: a setting out of range.
    """
    config = config or AvoidanceConfig()
    prepared = prepared_for(graph, config)
    if selection.status != Status.HIT or selection.part is None:
        return selection
    own = for_body(config, prepared.graph.body_scale)
    (change,) = refine_walks(prepared, [selection.walk], attack, own)
    if change is None:
        return selection
    refined = write(prepared, attack, replace(_choice_of(selection), refinement=change), config)
    return refined if refined.status == Status.AVOIDED else selection


def _choice_of(selection: Selection) -> Choice:
    """The choice of a selection, as if it avoided."""
    values = {field.name: getattr(selection, field.name) for field in fields(Choice)}
    return Choice(**(values | {"status": Status.AVOIDED, "clear_until": None}))
