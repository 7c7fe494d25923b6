"""The two defaults of the avoidance that are measured and not printed in the paper.

- ``E_avoidance`` (eq. 6): the 90th percentile of e' over the clear candidates of a seeded set of
  balls, for each form of the energy.
- ``V_slow`` (§4.1): the success over the largest speed at which an edge may still be sped up, with
  the speed that hands and feet then reach.

    python -m experiments.avoidance.calibrate --graph out/real [--balls 200] [--seed 0]
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from typing import Any

import numpy as np
from tqdm import tqdm

from mgjax.avoidance.attack import Attack, ball_attack, crop_attack
from mgjax.avoidance.candidates import enumerate_candidates
from mgjax.avoidance.config import AvoidanceConfig, SpeedConfig
from mgjax.avoidance.device_tables import search_tables
from mgjax.avoidance.evaluate import judge
from mgjax.avoidance.selection import select
from mgjax.avoidance.tables import edge_tables
from mgjax.avoidance.time_scale import OK
from mgjax.core.compilation import enable_cache
from mgjax.core.errors import AttackError
from mgjax.graph.files import load_graph
from mgjax.graph.types import MotionGraph

V_SLOW = (0.1, 1.0, 2.0, 3.0, 4.0, 6.0, 1000.0)


def seeded_balls(graph: MotionGraph, count: int, seed: int) -> list[tuple[int, Attack]]:
    """Nodes and balls: 10 m/s from any side, 0.5–1.7 m high over the root, there in 1.2 s."""
    rng = np.random.default_rng(seed)
    balls: list[tuple[int, Attack]] = []
    for _ in range(count):
        node = int(rng.integers(graph.num_nodes))
        side = rng.uniform(0, 2 * np.pi)
        at = np.array([0.0, rng.uniform(0.5, 1.7), 0.0])
        start = at + 5.0 * np.array([np.sin(side), 0.0, np.cos(side)])
        balls.append((node, ball_attack(start, at, speed=10.0, arrives=1.2)))
    return balls


def penetrations(graph: MotionGraph, balls: list[tuple[int, Attack]], form: Any) -> np.ndarray:
    """e' of all candidates that stay clear of the cropped attack."""
    config = AvoidanceConfig()
    config = replace(config, energy=replace(config.energy, form=form))
    tables = edge_tables(graph, config.body_rate)
    _, device = search_tables(graph, config.body_rate, config.speed)
    found: list[np.ndarray] = []
    for node, attack in tqdm(balls, desc=f"e' ({form})", leave=False):
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
    avoided, speeds, scales = 0, [], []
    for node, attack in tqdm(balls, desc=f"V_slow {v_slow:g}", leave=False):
        try:
            chosen = select(graph, node, attack, config=config)
        except AttackError:
            continue
        if chosen.status == "avoided":
            avoided += 1
            path = slice(0, chosen.path_length)
            speeds.append(float((top[chosen.walk.edges[path]] / chosen.walk.scales[path]).max()))
            scales.append(chosen.time_scale or 1.0)
    percent = np.percentile(speeds, [50, 95]) if speeds else [np.nan, np.nan]
    return {
        "V_slow": v_slow,
        "avoided": avoided / len(balls),
        "speed_p50": float(percent[0]),
        "speed_p95": float(percent[1]),
        "time_scale_p5": float(np.percentile(scales, 5)) if scales else None,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--graph", required=True)
    parser.add_argument("--balls", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    enable_cache()
    graph = load_graph(arguments.graph)
    balls = seeded_balls(graph, arguments.balls, arguments.seed)
    top = edge_tables(graph, 30.0).top_speed
    result: dict[str, Any] = {
        "balls": len(balls),
        "edge_top_speed_percentiles_5_25_50_75_95": np.percentile(
            top, [5, 25, 50, 75, 95]
        ).tolist(),
        "E_avoidance": {},
        "V_slow": [success(graph, balls, v) for v in V_SLOW],
    }
    for form in ("overlap", "paper"):
        values = penetrations(graph, balls, form)
        result["E_avoidance"][form] = {
            "clear_candidates": len(values),
            "p5_p50_p90_p95": np.percentile(values, [5, 50, 90, 95]).tolist(),
        }
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
