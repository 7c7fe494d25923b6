"""Choosing the walk that avoids an attack (§3, §4): which candidates, and in which order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.decision import Decision, best_of, better_of
from mgjax.avoidance.choice.near_misses import refined_miss
from mgjax.avoidance.choice.results import Choice, Status
from mgjax.avoidance.choice.start import Query, ask
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.index.found_paths import FoundPaths
from mgjax.avoidance.index.protocol import CandidateIndex
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.graph.feet.course import FeetState
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import random_walk


def choose(
    graph: MotionGraph | Prepared,
    node: int,
    attack: Attack,
    *,
    config: AvoidanceConfig,
    seed: int = 0,
    index: CandidateIndex | None = None,
    as_written: Callable[[Choice], float] | None = None,
    begin: FeetState | None = None,
    wanted: Callable[[], bool] | None = None,
) -> Choice:
    """Chooses and time-scales the walk that avoids an attack with the least movement.

    It answers as :func:`mgjax.avoidance.choice.selection.select` does, without making the motion;
    its arguments are described there. With an ``index`` candidates whose avoidance volume the
    attack touches are looked up (§5.1); where none of them is clear, the others that are in time
    follow. Where the index cannot say, all are enumerated. Where none within ``T_window`` is clear,
    the nearest misses are refined, if the settings say so; and where that does not help either, the
    same goes for all within ``T_wide``.

    It judges captured motion, which the feet of a written one differ from by centimetres; with
    ``as_written``, the clearance of a choice as it would be written (m), a candidate has to be
    clear as that, too. ``begin`` is what the feet are off now, for refinement.
    Once ``wanted`` says no, nothing more is refined: the answer is not waited for any longer.
    """
    prepared = prepared_for(graph, config, index)
    query = ask(prepared, node, attack, config, as_written, begin)
    if query is None:
        return _nothing(prepared, node, attack, config, seed)
    query = replace(query, wanted=wanted)
    tried: set[bytes] = set()
    decision = _refined(query, _decided(query), tried)
    if not _avoids(decision) and can_widen(config):
        wider = with_wide_window(query)
        wide = _refined(wider, _decided(wider), tried)
        # Those of the narrow window are among them.
        decision = replace(wide, choice=better_of(decision, wide).choice)
    choice = decision.choice or _nothing(prepared, node, attack, config, seed)
    return replace(
        choice, candidates=decision.candidates, dropped=decision.dropped, crop=query.crop
    )


def widened(config: AvoidanceConfig) -> AvoidanceConfig:
    """The settings with the window that is tried where no candidate of the usual one is clear."""
    return replace(config, T_window=config.T_wide)


def can_widen(config: AvoidanceConfig) -> bool:
    """Whether a wider window is to be tried at all."""
    return config.T_wide > config.T_window


def with_wide_window(query: Query) -> Query:
    """The same query with the wider window."""
    return query.widened(widened(query.config))


def query_decided(query: Query) -> Query:
    """The query whose candidates :func:`choose` settles on: with the wider window where it must."""
    if not can_widen(query.config) or _avoids(_decided(query)):
        return query
    return with_wide_window(query)


def _refined(query: Query, decision: Decision, tried: set[bytes]) -> Decision:
    """What was decided or, where that avoids nothing, a near miss that a change makes clear."""
    if _avoids(decision) or query.config.refine == "off":
        return decision
    choice = refined_miss(query, tried)
    return decision if choice is None else replace(decision, choice=choice)


def _avoids(decision: Decision) -> bool:
    return decision.choice is not None and decision.choice.status == Status.AVOIDED


def _decided(query: Query) -> Decision:
    """The best of the candidates within T_window, looked up or enumerated."""
    paths = paths_in_time(query)
    return best_of(query, query.in_time) if paths is None else _looked_up(query, paths)


def paths_in_time(query: Query) -> FoundPaths | None:
    """The paths of the index that satisfy eq. 1; None without one, if it cannot say, or if they
    are too many."""
    index, config = query.prepared.index, query.config
    if index is None:
        return None
    paths = index.in_time(query.node, query.crop.middle, config.T_window)
    return None if paths is None or len(paths) > config.capacity else paths


def _looked_up(query: Query, paths: FoundPaths) -> Decision:
    """The best of those paths of the index that the attack touches or, if none is clear, of all."""
    index = query.prepared.index
    assert index is not None, "the paths are its"
    touched = index.touched(paths, query.attack, query.crop)
    if touched is None:
        return best_of(query, index.walks(paths))
    first = best_of(query, index.walks(paths[touched]))
    if _avoids(first):
        return first
    return better_of(best_of(query, index.walks(paths[~touched])), first)


def _nothing(
    prepared: Prepared, node: int, attack: Attack, config: AvoidanceConfig, seed: int
) -> Choice:
    # What plays where nothing avoids, until the attack is over.
    walk = random_walk(prepared.graph, node, attack.end + config.settle_s, seed)
    return Choice(status=Status.NO_CANDIDATE, node=node, walk=walk)
