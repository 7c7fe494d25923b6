"""The two defaults of the avoidance that are measured and not printed in the paper.

- ``E_avoidance`` (eq. 6): the 90th percentile of e' over the clear candidates of a seeded set of
  balls, for each form of the energy.
- ``V_slow`` (§4.1): the success over the largest speed at which an edge may still be sped up, with
  the speed that hands and feet then reach.

    python -m experiments.avoidance.calibrate --config configs/avoidance/calibrate.toml \\
        --set clips=capture --out out/avoidance/calibrate

Without a graph it uses the embedded clips.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from experiments.avoidance.graphs import graph_of
from experiments.avoidance.throws import percentiles
from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.crop import crop_attack
from mgjax.avoidance.body.edge_tables import edge_tables
from mgjax.avoidance.candidates.enumerate import enumerate_candidates
from mgjax.avoidance.choice.selection import select
from mgjax.avoidance.config import AvoidanceConfig, SpeedConfig, for_body
from mgjax.avoidance.energy.evaluate import judge
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.timing.time_scale import OK
from mgjax.core.errors import AttackError
from mgjax.graph.types import MotionGraph
from mgjax.runs.experiment import Results, experiment
from mgjax.runs.points import Points

FORMS: tuple[Literal["overlap", "paper"], ...] = ("overlap", "paper")


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is thrown at which graph."""

    graph: str = ""
    """Folder of a graph; empty: that of the embedded clips."""
    clips: str = ""
    """Folder of clips with its labels.json, of which a graph is built; empty: the graph."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    balls: int = 200
    """10 m/s from any side, 0.5–1.7 m high over the root, there in 1.2 s, at random nodes."""
    seed: int = 0
    """Draws the balls."""
    V_slow: tuple[float, ...] = (0.1, 1.0, 2.0, 3.0, 4.0, 6.0, 1000.0)
    """Largest speeds at which an edge may still be sped up, m/s."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"graph": "", "clips": "", "balls": 3, "V_slow": (0.1, 3.0)}


def run(config: Config, points: Points) -> Results:
    """Measures both; what an interrupted run has measured is taken over."""
    graph = graph_of(config.graph, config.clips, config.exclude)
    balls = seeded_balls(graph, config.balls, config.seed)
    top = edge_tables(graph, AvoidanceConfig().body_rate).top_speed
    metrics: dict[str, Any] = {
        "edge_top_speed_p5_p25_p50_p75_p95": np.percentile(top, [5, 25, 50, 75, 95]),
        "E_avoidance": {
            form: points.measure(f"E_avoidance/{form}", lambda f=form: scale(graph, balls, f))
            for form in FORMS
        },
        "V_slow": [
            points.measure(f"V_slow/{v:g}", lambda v=v: success(graph, balls, v))
            for v in config.V_slow
        ],
    }
    return Results(metrics=metrics, lines=tuple(_lines(metrics)))


def seeded_balls(graph: MotionGraph, count: int, seed: int) -> list[tuple[int, Attack]]:
    """Nodes and balls."""
    rng = np.random.default_rng(seed)
    balls: list[tuple[int, Attack]] = []
    for _ in range(count):
        node = int(rng.integers(graph.num_nodes))
        side = rng.uniform(0, 2 * np.pi)
        balls.append((node, ball_from(side, rng.uniform(0.5, 1.7))))
    return balls


def scale(
    graph: MotionGraph, balls: list[tuple[int, Attack]], form: Literal["overlap", "paper"]
) -> dict[str, Any]:
    """How large e' is; ``E_avoidance`` is its 90th percentile."""
    values = penetrations(graph, balls, form)
    return {
        "clear_candidates": len(values),
        "p5_p50_p90_p95": percentiles(values.tolist(), (5, 50, 90, 95)),
    }


def penetrations(
    graph: MotionGraph, balls: list[tuple[int, Attack]], form: Literal["overlap", "paper"]
) -> np.ndarray:
    """e' of all candidates that stay clear of the cropped attack."""
    config = AvoidanceConfig()
    config = replace(config, energy=replace(config.energy, form=form))
    prepared = prepared_for(graph, config)
    config = for_body(config, graph.body_scale)
    tables, device = prepared.tables, prepared.device
    found: list[np.ndarray] = []
    for node, attack in balls:
        crop = crop_attack(attack, radius=config.crop_radius_m, height=config.crop_height_m)
        if crop is None:
            continue
        candidates = enumerate_candidates(
            graph, tables, node, crop.middle, window=config.T_window, capacity=config.capacity
        )
        if len(candidates.length):
            rate = graph.frame_rate
            judged = judge(device, candidates, attack, crop, config, frame_rate=rate)
            clear = (judged["status"] == OK) & (judged["d"] >= 0)
            found.append(judged["penetration"][clear])
    return np.concatenate(found) if found else np.zeros(0)


def success(graph: MotionGraph, balls: list[tuple[int, Attack]], v_slow: float) -> dict[str, Any]:
    """Share avoided, and the largest end-effector speed of the paths chosen, as they are played."""
    config = AvoidanceConfig(speed=SpeedConfig(V_fast=0.3, V_slow=v_slow, V_still=min(0.3, v_slow)))
    top = edge_tables(graph, config.body_rate).top_speed
    avoided = 0
    speeds: list[float] = []
    scales: list[float] = []
    for node, attack in balls:
        try:
            chosen = select(graph, node, attack, config=config)
        except AttackError:
            continue
        if chosen.status == "avoided":
            avoided += 1
            path = slice(0, chosen.path_length)
            speeds.append(float((top[chosen.walk.edges[path]] / chosen.walk.scales[path]).max()))
            scales.append(chosen.time_scale or 1.0)
    return {
        "V_slow": v_slow,
        "avoided": avoided / len(balls),
        "speed_p50_p95": percentiles(speeds, (50, 95)),
        "time_scale_p5": (percentiles(scales, (5,)) or [None])[0],
    }


def _lines(metrics: dict[str, Any]) -> list[str]:
    lines: list[str] = []
    for form, row in metrics["E_avoidance"].items():
        if row["p5_p50_p90_p95"] is not None:
            lines.append(
                f"E_avoidance, {form}: {row['p5_p50_p90_p95'][2]:.4g} m·s"
                f" ({row['clear_candidates']} clear candidates)"
            )
    for row in metrics["V_slow"]:
        speed = row["speed_p50_p95"]
        fastest = f", hands and feet up to {speed[1]:.1f} m/s (p95)" if speed else ""
        lines.append(f"V_slow = {row['V_slow']:g} m/s: {row['avoided']:.0%} avoided{fastest}")
    return lines


if __name__ == "__main__":
    experiment(run, Config)
