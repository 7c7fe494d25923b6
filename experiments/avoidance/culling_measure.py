"""What the experiment on culling counts and times."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from experiments.avoidance.throws import Throws
from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.attacks.transform import of_size
from mgjax.avoidance.body.edge_tables import EdgeTables
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates
from mgjax.avoidance.choice.continuation import continue_clear
from mgjax.avoidance.choice.decision import best_of
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.config import AvoidanceConfig, for_body
from mgjax.avoidance.culling.cull import cull, timing_of
from mgjax.avoidance.culling.overlap import overlap_pixels
from mgjax.avoidance.culling.pictures import Form, Slices
from mgjax.avoidance.culling.rasterise import draw_attack
from mgjax.avoidance.energy.evaluate import judge
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.rates import CLEAR_M
from mgjax.avoidance.timing.time_scale import OK
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import make_walk

FORMS: tuple[Form, ...] = ("paper", "binned")
SIZES = (1, 9, 33, 129, 4097)
"""Times are reported for balls whose candidates number from one of these up to the next."""

ALONE = ("judge", "search", "timing")
"""Times that do not depend on the form."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """A graph, its slices, and how they are used."""

    graph: MotionGraph
    tables: EdgeTables
    slices: Slices
    settings: AvoidanceConfig
    thresholds: dict[Form, int]


@dataclass(frozen=True, kw_only=True, eq=False)
class Ball:
    """An attack with its candidates."""

    node: int
    attack: Attack
    crop: Crop
    candidates: Candidates


def balls_of(scene: Scene, throws: Throws) -> list[Ball]:
    """The balls that have candidates."""
    settings, found = for_body(scene.settings, scene.graph.body_scale), []
    for number in range(len(throws)):
        attack, node = throws.attack(number), throws.node_of(number, scene.graph)
        crop = crop_attack(attack, radius=settings.crop_radius_m, height=settings.crop_height_m)
        if crop is None:
            continue
        candidates = enumerate_candidates(
            scene.graph,
            scene.tables,
            node,
            crop.middle,
            window=settings.T_window,
            capacity=settings.capacity,
        )
        if len(candidates.length):
            found.append(Ball(node=node, attack=attack, crop=crop, candidates=candidates))
    return found


def check_all(scene: Scene, balls: list[Ball], most: int, seed: int) -> dict[str, np.ndarray]:
    """Ball, pixels in both forms and whether it is clear, of candidates that can be timed."""
    rng = np.random.default_rng(seed)
    rows: dict[str, list] = {"ball": [], "clear": [], **{form: [] for form in FORMS}}
    for number, ball in enumerate(balls):
        status, scales = timed(scene, ball)
        drawn = draw_attack(of_size(ball.attack, 1 / scene.graph.body_scale), ball.crop)
        assert drawn is not None
        pixels = {
            form: overlap_pixels(scene.slices, ball.candidates, scales, drawn, ball.crop, form=form)
            for form in FORMS
        }
        for row in np.sort(rng.permutation(np.flatnonzero(status == OK))[:most]):
            length = int(ball.candidates.length[row])
            walk = make_walk(scene.graph, ball.candidates.edges[row, :length], scales[row, :length])
            posed = prepared_for(scene.graph, scene.settings).posed
            played = continue_clear(posed, ball.attack, walk, scene.settings)
            rows["ball"].append(number)
            rows["clear"].append(played.clearance >= CLEAR_M and played.clear_until is None)
            for form in FORMS:
                rows[form].append(int(pixels[form][row]))
    kinds = {"ball": np.int64, "clear": np.bool_}
    return {name: np.array(values, kinds.get(name, np.int64)) for name, values in rows.items()}


def timed(scene: Scene, ball: Ball) -> tuple[np.ndarray, np.ndarray]:
    """Status and scales of the candidates (eqs 2–3): culling needs to know when edges play."""
    device = prepared_for(scene.graph, scene.settings).device
    rate = scene.graph.frame_rate
    return timing_of(device, ball.candidates, ball.crop, scene.settings, frame_rate=rate)


def culled(scene: Scene, ball: Ball, scales: np.ndarray, form: Form) -> Candidates:
    """The candidates that are kept."""
    keep = cull(
        scene.slices,
        ball.candidates,
        scales,
        ball.attack,
        ball.crop,
        form=form,
        threshold=scene.thresholds[form],
    )
    return replace(
        ball.candidates,
        edges=ball.candidates.edges[keep],
        length=ball.candidates.length[keep],
        part=ball.candidates.part[keep],
    )


def _search(scene: Scene, ball: Ball, candidates: Candidates) -> bool:
    """Judges candidates and checks the best; whether one of them avoids the ball."""
    if not len(candidates.length):
        return False
    query = Query(
        prepared=prepared_for(scene.graph, scene.settings),
        config=scene.settings,
        node=ball.node,
        attack=ball.attack,
        crop=ball.crop,
    )
    settled = best_of(query, candidates)
    return settled.choice is not None and settled.choice.status == "avoided"


def answers_of(scene: Scene, balls: list[Ball]) -> dict[str, dict[str, float]]:
    """Shares of the balls that are avoided without culling, and with it, and how many are kept."""
    without = np.array([_search(scene, ball, ball.candidates) for ball in balls])
    found: dict[str, dict[str, float]] = {"none": {"avoided": float(without.mean())}}
    for form in FORMS:
        kept = [culled(scene, ball, timed(scene, ball)[1], form) for ball in balls]
        avoided = np.array(
            [_search(scene, ball, some) for ball, some in zip(balls, kept, strict=True)]
        )
        found[form] = {
            "avoided": float(avoided.mean()),
            "lost": float((without & ~avoided).mean()),
            "kept": sum(len(some.length) for some in kept)
            / sum(len(ball.candidates.length) for ball in balls),
        }
    return found


def times_of(scene: Scene, balls: list[Ball], repeats: int) -> list[dict[str, Any]]:
    """Median milliseconds over balls, by number of candidates; all forms take turns."""
    counts = np.array([len(ball.candidates.length) for ball in balls])
    rows = [_times_of_ball(scene, ball, repeats) for ball in balls]
    found: list[dict[str, Any]] = []
    for least, after in zip(SIZES[:-1], SIZES[1:], strict=True):
        some = [r for r, c in zip(rows, counts, strict=True) if least <= c < after]
        if not some:
            continue
        row: dict[str, Any] = {"least": least, "most": after - 1, "balls": len(some)}
        row |= {k: float(np.median([r[k] for r in some])) for k in (f"{name}_ms" for name in ALONE)}
        for form in FORMS:
            row[form] = {k: float(np.median([r[form][k] for r in some])) for k in some[0][form]}
        found.append(row)
    return found


def _times_of_ball(scene: Scene, ball: Ball, repeats: int) -> dict[str, Any]:
    """Judging and the whole search after the enumeration, without culling and with it.

    Judging times the candidates too; within one program culling could share that, so it is a
    figure of its own.
    """
    scales = timed(scene, ball)[1]
    kept = {form: culled(scene, ball, scales, form) for form in FORMS}
    device = prepared_for(scene.graph, scene.settings).device

    def judged(candidates: Candidates) -> None:
        if len(candidates.length):
            rate = scene.graph.frame_rate
            judge(device, candidates, ball.attack, ball.crop, scene.settings, frame_rate=rate)

    work: dict[str, Callable[[], Any]] = {
        "judge": lambda: judged(ball.candidates),
        "search": lambda: _search(scene, ball, ball.candidates),
        "timing": lambda: timed(scene, ball),
    }
    for form in FORMS:
        work[f"{form} cull"] = partial(culled, scene, ball, scales, form)
        work[f"{form} judge"] = partial(judged, kept[form])
        work[f"{form} search"] = partial(_search, scene, ball, kept[form])
    for task in work.values():
        task()  # compiled, or read from the cache
    taken = {name: [_milliseconds(task)] for name, task in work.items()}
    for _ in range(repeats - 1):
        for name, task in work.items():
            taken[name].append(_milliseconds(task))
    medians = {name: float(np.median(values)) for name, values in taken.items()}
    found: dict[str, Any] = {f"{name}_ms": medians[name] for name in ALONE}
    for form in FORMS:
        steps = {name: medians[f"{form} {name}"] for name in ("cull", "judge", "search")}
        spent = medians["timing"] + steps["cull"]
        found[form] = {
            "kept": len(kept[form].length) / len(ball.candidates.length),
            **{f"{name}_ms": value for name, value in steps.items()},
            "judge_saved_ms": medians["judge"] - steps["judge"] - spent,
            "judge_saved_without_timing_ms": medians["judge"] - steps["judge"] - steps["cull"],
            "search_saved_ms": medians["search"] - steps["search"] - spent,
        }
    return found


def _milliseconds(task: Callable[[], Any]) -> float:
    start = time.perf_counter()
    task()
    return 1000 * (time.perf_counter() - start)
