"""Choosing the walk that avoids an attack (§3, §4): candidates, and the best of them."""

from __future__ import annotations

from dataclasses import replace

from mgjax.avoidance.answer import Choice, Dropped
from mgjax.avoidance.attack import Attack
from mgjax.avoidance.candidates import Candidates, enumerate_candidates, without
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.crop import Crop, crop_attack
from mgjax.avoidance.culling import without_culled
from mgjax.avoidance.device_tables import search_tables
from mgjax.avoidance.exact import body_of
from mgjax.avoidance.follow import idle
from mgjax.avoidance.grid_index import GridIndex, lookup
from mgjax.avoidance.search import make_task, on_device, search_one
from mgjax.avoidance.settle import Settled, better_of, settle
from mgjax.avoidance.swept_cells import swept_cells
from mgjax.avoidance.validate import validate_config, validate_start
from mgjax.graph.types import MotionGraph


def choose(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    *,
    config: AvoidanceConfig,
    seed: int = 0,
    index: GridIndex | None = None,
) -> Choice:
    """Chooses and time-scales the walk that avoids an attack with the least movement.

    The same as :func:`mgjax.avoidance.selection.select` without making the motion. With an
    ``index`` the candidates are looked up (§5.1); where it holds none, or cannot say, and where
    none of them is clear, they are enumerated.
    """
    validate_config(config)
    tables, _ = search_tables(graph, config.body_rate, config.speed)
    validate_start(graph, tables, node, attack)
    crop = crop_attack(attack, radius=config.crop_radius_m, height=config.crop_height_m)
    if crop is None:
        return _nothing(graph, node, attack, config, seed)
    looked_up = None if index is None else lookup_candidates(index, node, attack, crop, config)
    before = None
    if looked_up is not None:
        before = best_of(graph, node, attack, crop, looked_up, config)
        if before.choice is not None and before.choice.status == "avoided":
            return before.choice
    every = enumerate_candidates(
        graph, tables, node, crop.middle, window=config.T_window, capacity=config.capacity
    )
    others = every if looked_up is None else without(every, looked_up)
    settled = best_of(graph, node, attack, crop, others, config)
    if before is not None:
        settled = better_of(settled, before)
    choice = settled.choice or _nothing(graph, node, attack, config, seed)
    total = len(every.length) + every.overflow
    return replace(choice, candidates=total, dropped=settled.dropped, crop=crop)


def _nothing(
    graph: MotionGraph, node: int, attack: Attack, config: AvoidanceConfig, seed: int
) -> Choice:
    walk = idle(graph, node, attack, config, seed)
    return Choice(status="no_candidate", node=node, walk=walk)


def lookup_candidates(
    index: GridIndex, node: int, attack: Attack, crop: Crop, config: AvoidanceConfig
) -> Candidates | None:
    """The candidates whose avoidance volume the attack touches (§5.1), or None if unknown."""
    return lookup(index, node, swept_cells(attack, crop), crop.middle, config.T_window)


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
