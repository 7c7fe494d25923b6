"""Choosing the walk that avoids an attack (§3, §4): candidates, and the best of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.body.device_tables import search_tables
from mgjax.avoidance.body.poses import body_of
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates
from mgjax.avoidance.choice.continuation import idle
from mgjax.avoidance.choice.results import Choice, Dropped
from mgjax.avoidance.choice.search import make_task, on_device, search_one
from mgjax.avoidance.choice.start import validate_start
from mgjax.avoidance.choice.verify import Settled, better_of, settle
from mgjax.avoidance.config import AvoidanceConfig, validate_config
from mgjax.avoidance.culling.candidates import without_culled
from mgjax.avoidance.index.protocol import CandidateIndex
from mgjax.graph.types import MotionGraph


def choose(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    *,
    config: AvoidanceConfig,
    seed: int = 0,
    index: CandidateIndex | None = None,
) -> Choice:
    """Chooses and time-scales the walk that avoids an attack with the least movement.

    The same as :func:`mgjax.avoidance.choice.selection.select` without making the motion. With an
    ``index`` those whose avoidance volume the attack touches are looked up (§5.1); where none of
    them is clear, the others that are in time follow. Where the index cannot say, all are
    enumerated.
    """
    validate_config(config)
    tables, _ = search_tables(graph, config.body_rate, config.speed)
    validate_start(graph, tables, node, attack)
    crop = crop_attack(attack, radius=config.crop_radius_m, height=config.crop_height_m)
    if crop is None:
        return _nothing(graph, node, attack, config, seed)
    known = None if index is None else _known(index, node, crop, config)
    before, others = None, None
    if index is not None and known is not None:
        touched = index.touched(known, attack, crop)
        if touched is not None:
            looked_up = index.walks(known[touched])
            before = best_of(graph, node, attack, crop, looked_up, config)
            if before.choice is not None and before.choice.status == "avoided":
                return before.choice
        others = index.walks(known if touched is None else known[~touched])
    if others is None:
        others = enumerate_candidates(
            graph, tables, node, crop.middle, window=config.T_window, capacity=config.capacity
        )
    settled = best_of(graph, node, attack, crop, others, config)
    if before is not None:
        settled = better_of(settled, before)
    choice = settled.choice or _nothing(graph, node, attack, config, seed)
    total = len(others.length) + others.overflow if known is None else len(known)
    return replace(choice, candidates=total, dropped=settled.dropped, crop=crop)


def _known(
    index: CandidateIndex, node: int, crop: Crop, config: AvoidanceConfig
) -> Int[np.ndarray, " C"] | None:
    """The paths of the index that satisfy eq. 1; None if it cannot say, or if they are too many."""
    paths = index.in_time(node, crop.middle, config.T_window)
    return None if paths is None or len(paths) > config.capacity else paths


def _nothing(
    graph: MotionGraph, node: int, attack: Attack, config: AvoidanceConfig, seed: int
) -> Choice:
    walk = idle(graph, node, attack, config, seed)
    return Choice(status="no_candidate", node=node, walk=walk)


def best_of(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    crop: Crop,
    candidates: Candidates,
    config: AvoidanceConfig,
) -> Settled:
    """The best of some candidates that stays clear."""
    kept, culled = candidates, 0
    if config.culling != "none":
        kept, culled = without_culled(graph, candidates, attack, crop, config.culling, config)
    if not len(kept.length):
        return Settled(choice=None, dropped=Dropped(culled=culled, overflow=candidates.overflow))
    _, device = search_tables(graph, config.body_rate, config.speed)
    task = make_task(kept, attack, crop, config, body_of(graph)[1])
    found = search_one(
        device,
        task.walks,
        task.shots,
        on_device(config.energy),
        frame_rate=graph.frame_rate,
        limit_scale=config.limit_scale,
    )
    return settle(graph, node, attack, crop, kept, task, found, config, culled=culled)
