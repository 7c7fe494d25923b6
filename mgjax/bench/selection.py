"""Time from an attack to the chosen path, with and without index and slices (Table 1 of §7)."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import numpy as np
from tqdm import tqdm

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.crop import crop_attack
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.decision import best_of
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.start import ask
from mgjax.avoidance.config import AvoidanceConfig, for_body
from mgjax.avoidance.culling.cull import PIXELS
from mgjax.avoidance.energy.evaluate import judge
from mgjax.avoidance.index.protocol import CandidateIndex
from mgjax.avoidance.many.attacks import select_batch
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.graph.types import NO_EDGE, MotionGraph

CONDITIONS = ((True, True), (False, True), (True, False), (False, False))
"""Index and slices, in the order of the paper's table."""

MANY = 100
"""Candidates from which an enumeration counts as large."""

DISTANCE_M = 8.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Ball:
    """An attack on a character at a node."""

    node: int
    attack: Attack


def random_balls(graph: MotionGraph, count: int, seed: int) -> list[Ball]:
    """10 m/s from any side, there in 1.2 s, at random nodes: 0.5–1.7 m high at an adult's axis."""
    rng = np.random.default_rng(seed)
    balls = []
    for _ in range(count):
        side, height = rng.uniform(0, 2 * np.pi), graph.body_scale * rng.uniform(0.5, 1.7)
        node = int(rng.integers(graph.num_nodes))
        balls.append(Ball(node=node, attack=ball_from(side, height, distance=DISTANCE_M)))
    return balls


def condition_rows(
    graph: MotionGraph,
    index: CandidateIndex,
    balls: Sequence[Ball],
    *,
    repeats: int = 3,
    progress: bool = False,
) -> list[dict[str, Any]]:
    """The four conditions of Table 1, taken in turns for all balls.

    A time runs from the attack to the chosen path, its exact check included, and is the median of
    ``repeats`` calls; ``cpu_median_ms`` is processor time, which other work on the machine hardly
    changes. ``candidates`` is the mean of what the condition starts from: those looked up
    where the index holds some, else those enumerated; the slices then drop some.
    """
    plain = AvoidanceConfig(refine="off")
    configs = {True: replace(plain, culling="binned"), False: plain}
    prepared = {sliced: prepared_for(graph, config) for sliced, config in configs.items()}
    first, seconds = np.zeros(4), np.zeros((4, repeats, len(balls)))
    busy = np.zeros_like(seconds)
    statuses = np.zeros((4, len(balls)), dtype=object)
    counts = np.zeros((2, len(balls)), dtype=np.int64)
    answered = np.zeros(len(balls), bool)
    for turn in tqdm(range(-1, repeats), desc="turns", leave=False, disable=not progress):
        for c, (looked_up, sliced) in enumerate(CONDITIONS):
            for b, ball in enumerate(balls):
                begin, worked = time.perf_counter(), time.process_time()
                choice = choose(
                    prepared[sliced],
                    ball.node,
                    ball.attack,
                    config=configs[sliced],
                    index=index if looked_up else None,
                )
                passed = time.perf_counter() - begin
                if turn < 0:  # compiles
                    first[c] += passed
                    statuses[c, b] = choice.status
                else:
                    seconds[c, turn, b] = passed
                    busy[c, turn, b] = time.process_time() - worked
    for b, ball in enumerate(balls):
        counts[:, b], answered[b] = _counts(prepared[False], index, ball, configs[False])
    times = np.median(seconds, axis=1) * 1e3
    rows = []
    for c, (looked_up, sliced) in enumerate(CONDITIONS):
        counted = np.where(counts[0] > 0, counts[0], counts[1]) if looked_up else counts[1]
        row = _row(times[c])
        row |= {
            "cpu_median_ms": float(np.median(np.median(busy[c], axis=0))) * 1e3,
            "index": looked_up,
            "slices": sliced,
            "candidates": float(counted.mean()),
            "compile_s": max(float(first[c] - np.median(seconds[c], axis=0).sum()), 0.0),
            "avoided": float((statuses[c] == "avoided").mean()),
            "index_holds_candidates": float((counts[0] > 0).mean()),
            "balls": len(balls),
        }
        groups = {"answered_by_the_index": answered, f"from_{MANY}_candidates": counts[1] >= MANY}
        group = "answered_by_the_index" if looked_up else f"from_{MANY}_candidates"
        if groups[group].any():
            row[group] = _row(times[c][groups[group]]) | {
                "share": float(groups[group].mean()),
                "candidates": float(counted[groups[group]].mean()),
            }
        rows.append(row)
    return rows


def _counts(
    prepared: Prepared, index: CandidateIndex, ball: Ball, config: AvoidanceConfig
) -> tuple[tuple[int, int], bool]:
    """Candidates looked up and enumerated; whether the index answers."""
    query = ask(prepared, ball.node, ball.attack, config)
    assert query is not None
    every = query.in_time
    known = index.in_time(ball.node, query.crop.middle, config.T_window)
    touched = None if known is None else index.touched(known, ball.attack, query.crop)
    if known is None or touched is None or not touched.any():
        return (0, len(every.length)), False
    looked_up = index.walks(known[touched])
    decision = best_of(query, looked_up)
    # Where the index holds nothing that is clear, the other candidates are enumerated after all.
    answered = decision.choice is not None and decision.choice.status == Status.AVOIDED
    return (len(looked_up.length), len(every.length)), answered


def _row(times_ms: np.ndarray) -> dict[str, Any]:
    return {
        "median_ms": float(np.median(times_ms)),
        "p95_ms": float(np.percentile(times_ms, 95)),
    }


def evaluation_rows(
    graph: MotionGraph, ball: Ball, *, sizes: Sequence[int] = (8, 128, 10_000), repeats: int = 15
) -> list[dict[str, Any]]:
    """The evaluation alone (timing and energies) of given numbers of candidates."""
    device = prepared_for(graph, AvoidanceConfig()).device
    config = for_body(AvoidanceConfig(), graph.body_scale)
    crop = crop_attack(ball.attack, radius=config.crop_radius_m, height=config.crop_height_m)
    assert crop is not None
    pool = _many_candidates(graph, max(sizes), crop.middle)
    rows = []
    for size in sizes:
        candidates = Candidates(
            edges=pool.edges[:size], length=pool.length[:size], part=pool.part[:size], overflow=0
        )

        def work(candidates: Candidates = candidates) -> Any:
            return judge(device, candidates, ball.attack, crop, config, frame_rate=graph.frame_rate)

        row = _timed(work, repeats)
        rows.append({"case": "evaluation alone", "candidates": size, **row})
    return rows


def _many_candidates(graph: MotionGraph, count: int, t_attack: float) -> Candidates:
    """Real candidates of as many nodes as it takes."""
    config = AvoidanceConfig()
    tables = prepared_for(graph, config).tables
    rng = np.random.default_rng(0)
    edges, length, part, total = [], [], [], 0
    while total < count:
        selected = enumerate_candidates(
            graph,
            tables,
            int(rng.integers(graph.num_nodes)),
            t_attack,
            window=config.T_window,
            capacity=config.capacity,
        )
        padded = np.full((len(selected.length), 48), NO_EDGE)
        width = min(selected.edges.shape[1], 48)
        short = selected.length <= width
        padded[:, :width] = selected.edges[:, :width]
        edges.append(padded[short])
        length.append(selected.length[short])
        part.append(selected.part[short])
        total += int(short.sum())
    return Candidates(
        edges=np.concatenate(edges)[:count],
        length=np.concatenate(length)[:count],
        part=np.concatenate(part)[:count],
        overflow=0,
    )


def batch_row(
    graph: MotionGraph, *, attacks: int = 4096, nodes: int = 128, repeats: int = 3, seed: int = 1
) -> dict[str, Any]:
    """Many attacks at once, candidates and exact checks included, at a given number of nodes."""
    balls = random_balls(graph, attacks, seed)
    places = np.array([ball.node for ball in balls])
    places = np.random.default_rng(seed).choice(places, nodes)[np.arange(attacks) % nodes]
    attacks_thrown = [ball.attack for ball in balls]
    selected = None

    def work() -> Any:
        nonlocal selected
        selected = select_batch(graph, places, attacks_thrown)
        return selected.clearance

    row = _timed(work, repeats)
    assert selected is not None
    return {
        "case": "many attacks at once",
        "attacks": attacks,
        "nodes": nodes,
        "candidates": float(selected.candidates.mean()),
        "per_attack_ms": row["median_ms"] / attacks,
        **row,
    }


def _timed(work: Callable[[], Any], repeats: int) -> dict[str, Any]:
    begin = time.perf_counter()
    jax.block_until_ready(work())
    first = time.perf_counter() - begin
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        jax.block_until_ready(work())
        times.append(1e3 * (time.perf_counter() - begin))
    return _row(np.array(times)) | {"compile_s": max(first - float(np.median(times)) / 1e3, 0.0)}


def selection_rows(
    graph: MotionGraph, index: CandidateIndex, *, balls: int = 200, progress: bool = False
) -> dict[str, Any]:
    """Everything ``mgjax bench selection`` prints."""
    thrown = random_balls(graph, balls, 0)
    return {
        "rows": condition_rows(graph, index, thrown, progress=progress),
        "figures": [*evaluation_rows(graph, thrown[0]), batch_row(graph)],
        "slices_pixels": PIXELS["binned"],
    }
