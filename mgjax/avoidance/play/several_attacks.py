"""A path for the newest of several attacks that is also clear of the others."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.transform import in_frame
from mgjax.avoidance.checks.fast import clearance_between
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.continuation import continue_clear
from mgjax.avoidance.choice.parrying import others_of
from mgjax.avoidance.choice.results import Choice, Status
from mgjax.avoidance.choice.start import ask
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.energy.evaluate import judge
from mgjax.avoidance.parry.parry import Parry
from mgjax.avoidance.play.parried import find_parried, played_clearance
from mgjax.avoidance.play.timeline import Piece, PlacedChange, line_of
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.rates import CLEAR_M, EXPORT_RATE
from mgjax.avoidance.refinement.refine import refined_clearance
from mgjax.avoidance.refinement.refinement import Refinement
from mgjax.core.errors import AttackError
from mgjax.graph.feet.course import FeetState
from mgjax.graph.walk import Walk, make_walk


@dataclass(frozen=True, kw_only=True, eq=False)
class JointPath:
    """What a search for the newest of several attacks found.

    Attributes:
        status: as of :class:`mgjax.avoidance.choice.choosing.Choice`, for the newest attack;
            ``hit`` also if it reaches the body before the path can begin.
        walk: what to play; None if nothing avoids better than any other walk.
        joint: whether the walk is clear of the other attacks, too.
        choice: the answer to the newest attack alone; None if it is in the body already.
        parry: how an arm meets the newest attack on the walk, or None.
        seconds: how long the search took.
    """

    status: Status
    walk: Walk | None
    joint: bool
    choice: Choice | None = None
    parry: Parry | None = None
    seconds: float = 0.0

    @property
    def change(self) -> Refinement | Parry | None:
        """What is done to the motion of the walk, if anything."""
        return self.parry or self.refinement

    @property
    def refinement(self) -> Refinement | None:
        """How the walk is refined; None where it is not, or is another than the choice's."""
        if self.choice is None or self.walk is not self.choice.walk:
            return None
        return self.choice.refinement


def find_path(
    prepared: Prepared,
    node: int,
    attack: Attack,
    others: Sequence[Attack],
    config: AvoidanceConfig,
    rest: Piece,
    feet: FeetState | None = None,
    wanted: Callable[[], bool] | None = None,
) -> JointPath:
    """The path of :func:`mgjax.avoidance.choice.choosing.choose`, or one that is clear of all
    attacks.

    If the selected walk is not clear of the others, the best candidate takes its place that is; if
    there is none the newest attack counts and the selected walk stays. Where nothing avoids the
    newest an arm may parry it, if the settings say so.

    Args:
        prepared: of the graph.
        node: where the path begins.
        attack: the newest, in the planar frame of the node, from the beginning of the path on.
        others: those that are still under way, in the same frame.
        config: settings.
        rest: what is still played until the path begins, in the same frame, and since when (a time
            before 0).
        feet: what the feet are off where the path begins, in the same frame.
        wanted: whether the answer is still waited for; where it is not, the search ends early.
    """
    begin = time.perf_counter()
    path = _find_path(prepared, node, attack, others, config, rest, feet, wanted)
    return replace(path, seconds=time.perf_counter() - begin)


def _find_path(
    prepared: Prepared,
    node: int,
    attack: Attack,
    others: Sequence[Attack],
    config: AvoidanceConfig,
    rest: Piece,
    feet: FeetState | None,
    wanted: Callable[[], bool] | None,
) -> JointPath:
    def as_written(choice: Choice) -> float:
        line = line_of(prepared.graph, node, choice.walk, feet)
        if choice.refinement is not None:
            line.change(PlacedChange(change=choice.refinement, begins=0.0, angle=0.0), 0.0)
        piece = line.between(0.0, attack.end + 1 / EXPORT_RATE, feet=True)
        return played_clearance(prepared.graph, piece, attack, 0.0)

    begun = in_frame(attack, rest.start, rest.begins)
    near = clearance_between(prepared.posed, begun, rest.walk, 0.0, -rest.begins)
    touched = near < CLEAR_M and not rest.changes  # what is changed is clearer than its walk
    try:
        chosen = choose(
            prepared,
            node,
            attack,
            config=config,
            as_written=as_written,
            begin=feet,
            wanted=wanted,
        )
    except AttackError:  # it is in the body where the path would begin
        return JointPath(status=Status.HIT, walk=None, joint=False)
    status = Status.HIT if touched else chosen.status
    lost = chosen.status != Status.AVOIDED and chosen.crop is not None
    if config.parry == "on" and lost and not touched:
        walks = [chosen.walk, *others_of(prepared, node, attack, 0)]
        parried = find_parried(prepared, node, walks, attack, config, feet)
        if parried is not None:
            walk, parry = parried
            joint = _clear(prepared, walk, others)
            found = {"walk": walk, "parry": parry, "joint": joint, "choice": chosen}
            return JointPath(status=Status.PARRIED, **found)
    if chosen.status == Status.NO_CANDIDATE:
        return JointPath(status=status, walk=None, joint=False, choice=chosen)
    if chosen.refinement is None:
        joint = _clear(prepared, chosen.walk, others)
    else:
        joint = all(
            refined_clearance(prepared.graph, chosen.walk, chosen.refinement, other, feet)
            >= CLEAR_M
            for other in others
        )
    if chosen.status == Status.AVOIDED and not joint:
        walk = _clear_of_all(prepared, node, attack, others, config)
        if walk is not None:
            return JointPath(status=status, walk=walk, joint=True, choice=chosen)
    return JointPath(status=status, walk=chosen.walk, joint=joint, choice=chosen)


def _clear(prepared: Prepared, walk: Walk, attacks: Sequence[Attack]) -> bool:
    end = float(walk.starts(prepared.graph)[-1])
    return all(clearance_between(prepared.posed, a, walk, 0.0, end) >= CLEAR_M for a in attacks)


def _clear_of_all(
    prepared: Prepared,
    node: int,
    attack: Attack,
    others: Sequence[Attack],
    config: AvoidanceConfig,
) -> Walk | None:
    """The candidate of least energy whose walk, with what follows it, no attack touches."""
    query = ask(prepared, node, attack, config)
    if query is None or not len(query.in_time.length):
        return None
    graph, candidates = prepared.graph, query.in_time
    judged = judge(
        prepared.device,
        candidates,
        attack,
        query.crop,
        query.config,
        frame_rate=graph.frame_rate,
        unmoved=query.unmoved,
    )
    for index in judged["order"][: config.checks]:
        length = int(candidates.length[index])
        path = make_walk(graph, candidates.edges[index, :length], judged["scales"][index, :length])
        if not _clear(prepared, path, others):
            continue
        played = continue_clear(prepared.posed, attack, path, config)
        clear = played.clearance >= CLEAR_M and played.clear_until is None
        if clear and _clear(prepared, played.walk, others):
            return played.walk
    return None
