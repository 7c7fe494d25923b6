"""Choosing the walk that avoids an attack (§3, §4): candidates, and the best of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.candidates.enumerate import enumerate_candidates
from mgjax.avoidance.choice.decision import Decision, better_of, decide
from mgjax.avoidance.choice.results import Choice, Dropped, Status
from mgjax.avoidance.choice.search import Query, in_32_bits, search_input, search_one
from mgjax.avoidance.choice.start import validate_start
from mgjax.avoidance.config import AvoidanceConfig, validate_config
from mgjax.avoidance.culling.cull import without_culled
from mgjax.avoidance.index.protocol import CandidateIndex
from mgjax.avoidance.prepared import Prepared, prepared_for
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
) -> Choice:
    """Chooses and time-scales the walk that avoids an attack with the least movement.

    It answers as :func:`mgjax.avoidance.choice.selection.select` does, without making the motion;
    its arguments are described there. With an ``index`` candidates whose avoidance volume the
    attack touches are looked up (§5.1); where none of them is clear, the others that are in time
    follow. Where the index cannot say, all are enumerated.
    """
    validate_config(config)
    prepared = prepared_for(graph, config, index)
    index = prepared.index
    validate_start(prepared, node, attack)
    crop = crop_attack(attack, radius=config.crop_radius_m, height=config.crop_height_m)
    if crop is None:
        return _nothing(prepared, node, attack, config, seed)
    in_time = None if index is None else _in_time(index, node, crop, config)
    before, candidates = None, None
    if index is not None and in_time is not None:
        touched = index.touched(in_time, attack, crop)
        if touched is not None:
            looked_up = index.walks(in_time[touched])
            query = Query(node=node, attack=attack, crop=crop, candidates=looked_up)
            before = best_of(prepared, query, config)
            if before.choice is not None and before.choice.status == Status.AVOIDED:
                return before.choice
        candidates = index.walks(in_time if touched is None else in_time[~touched])
    if candidates is None:
        candidates = enumerate_candidates(
            prepared.graph,
            prepared.tables,
            node,
            crop.middle,
            window=config.T_window,
            capacity=config.capacity,
        )
    query = Query(node=node, attack=attack, crop=crop, candidates=candidates)
    decision = best_of(prepared, query, config)
    if before is not None:
        decision = better_of(decision, before)
    choice = decision.choice or _nothing(prepared, node, attack, config, seed)
    total = len(candidates.length) + candidates.overflow if in_time is None else len(in_time)
    return replace(choice, candidates=total, dropped=decision.dropped, crop=crop)


def _in_time(
    index: CandidateIndex, node: int, crop: Crop, config: AvoidanceConfig
) -> Int[np.ndarray, " C"] | None:
    """The paths of the index that satisfy eq. 1; None if it cannot say, or if they are too many."""
    paths = index.in_time(node, crop.middle, config.T_window)
    return None if paths is None or len(paths) > config.capacity else paths


def _nothing(
    prepared: Prepared, node: int, attack: Attack, config: AvoidanceConfig, seed: int
) -> Choice:
    # What plays where nothing avoids, until the attack is over.
    walk = random_walk(prepared.graph, node, attack.end + config.settle_s, seed)
    return Choice(status=Status.NO_CANDIDATE, node=node, walk=walk)


def best_of(prepared: Prepared, query: Query, config: AvoidanceConfig) -> Decision:
    """The best of the candidates of a query that stays clear."""
    kept, culled = query.candidates, 0
    if config.culling != "none" and prepared.slices is not None:
        kept, culled = without_culled(
            prepared.slices,
            prepared.device,
            kept,
            query.attack,
            query.crop,
            config,
            frame_rate=prepared.graph.frame_rate,
        )
    if not len(kept.length):
        return Decision(choice=None, dropped=Dropped(culled=culled, overflow=kept.overflow))
    query = replace(query, candidates=kept)
    padded = search_input(query, config, prepared.posed.reach)
    result = search_one(
        prepared.device,
        padded.walks,
        padded.attack_batch,
        in_32_bits(config.energy),
        frame_rate=prepared.graph.frame_rate,
        limit_scale=config.limit_scale,
    )
    return decide(prepared, query, padded, result, config, culled=culled)
