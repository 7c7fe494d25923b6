"""How many of the balls that hit in spite of refinement are parried, and by how large a change.

    python -m experiments.avoidance.parry --config configs/avoidance/parry.toml \\
        --set clips=capture --out out/avoidance/parry

Standard balls that are there in 0.4 … 1.2 s. Every parry is checked once more in the BVH that is
written of it, 240 times a second: a forearm or a hand is the first that the ball touches, and until
then nothing else is.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from experiments.avoidance.attack_strips import Strip, drawn_results
from experiments.avoidance.graphs import built, graph_of
from experiments.avoidance.throws import (
    OUTCOMES,
    arriving_in,
    outcome_of,
    percentiles,
    standard_throws,
)
from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.selection import Selection, select
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.parry.checked import met, track_of
from mgjax.avoidance.parry.guard import guard_of
from mgjax.avoidance.parry.parry import Parry
from mgjax.core.errors import AttackError
from mgjax.graph.types import MotionGraph
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import load_motion
from mgjax.runs.experiment import Results, experiment


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is thrown at which graph, and how soon."""

    graph: str = ""
    """Folder of a graph; empty: built from the clips at the automatic threshold."""
    clips: str = ""
    """Folder of clips with its labels.json; empty: the graph, or the embedded clips."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    balls: int = 100
    """Standard balls per time of arrival."""
    arrives: tuple[float, ...] = (0.4, 0.6, 0.8, 1.2)
    """When balls are there, s from now."""
    strips: int = 5
    """Parries that are drawn."""
    seed: int = 0
    """Draws nodes, sides and heights; the same for all times."""
    avoidance: AvoidanceConfig = field(default_factory=lambda: AvoidanceConfig(parry="on"))
    """Settings of the search."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"graph": "", "clips": "", "balls": 4, "arrives": (0.4,), "strips": 1}


def run(config: Config) -> Results:
    """Throws all balls and measures the parries."""
    graph = built(config.clips, config.exclude, threshold_m=None) if config.clips else None
    graph = graph or graph_of(config.graph or None)
    rows: list[dict[str, Any]] = []
    drawn: list[Strip] = []
    for arrives in config.arrives:
        row, found = _measured(config, graph, arrives)
        rows.append(row)
        drawn += found
    return drawn_results(rows, drawn, config.strips, _line)


def _measured(
    config: Config, graph: MotionGraph, arrives: float
) -> tuple[dict[str, Any], list[Strip]]:
    """What became of the balls of one time of arrival, and all its parries."""
    throws = arriving_in(standard_throws(config.balls, config.seed), arrives)
    counts: dict[str, int] = dict.fromkeys(OUTCOMES, 0)
    strips: list[Strip] = []
    parries: list[Parry] = []
    checks: list[float | None] = []
    for number in range(len(throws)):
        attack, node = throws.attack(number), throws.node_of(number, graph)
        try:
            chosen = select(graph, node, attack, config=config.avoidance)
        except AttackError:
            counts["refused"] += 1
            continue
        counts[outcome_of(chosen)] += 1
        if chosen.parry is not None:
            title = (
                f"ball {number}, there in {arrives:g} s: {chosen.parry.limb.replace('_', ' ')},"
                f" {100 * chosen.parry.largest_m:.0f} cm, {chosen.parry.largest_deg:.0f}°"
            )
            strips.append(
                Strip(
                    title=title,
                    skeleton=graph.skeleton,
                    motion=chosen.motion,
                    attack=attack,
                    time=chosen.parry.time,
                    sphere=chosen.parry.sphere,
                )
            )
            parries.append(chosen.parry)
            checks.append(in_file(graph, attack, chosen))
    row = {
        "arrives": arrives,
        **counts,
        "confirmed_in_the_file": sum(off is not None for off in checks),
        "contact_off_s": max((off for off in checks if off is not None), default=None),
        "limbs": {limb: sum(p.limb == limb for p in parries) for limb in sorted(_LIMBS)},
        "largest_cm_p5_p50_p95": percentiles([100 * p.largest_m for p in parries], (5, 50, 95)),
        "largest_deg_p5_p50_p95": percentiles([p.largest_deg for p in parries], (5, 50, 95)),
        "moved_less_than_3_cm": sum(p.largest_m < 0.03 for p in parries),
        "square_p5_p50_p95": percentiles([p.square for p in parries], (5, 50, 95)),
    }
    return row, strips


_LIMBS = tuple(f"{side}_{part}" for side in ("left", "right") for part in ("forearm", "hand"))


def in_file(graph: MotionGraph, attack: Attack, selection: Selection) -> float | None:
    """By how much the contact in the written BVH is earlier or later, s; None without one there."""
    parry, guard = selection.parry, guard_of(graph)
    assert parry is not None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "motion.bvh"
        save_bvh(path, graph.skeleton, selection.motion)
        skeleton, motion = load_motion(path)
    order = [skeleton.index(name) for name in graph.skeleton.names]
    motion = replace(motion, local_rotations=np.asarray(motion.local_rotations)[:, order])
    (arm,) = [arm for arm in guard.arms if arm.side == parry.side]
    found = met(guard, arm, *track_of(guard, motion), attack, parry.sphere)
    if found is None or found.limb != parry.limb:
        return None
    return abs(found.contact.time - parry.time)


def _line(row: dict[str, Any]) -> str:
    left = row["parried"] + row["hit"] + row["no_candidate"] + row["no_time_scale"]
    text = (
        f"{row['arrives']:g} s: {row['avoided']} avoided; {row['parried']} of the other {left}"
        f" parried, {row['confirmed_in_the_file']} of them confirmed in the file"
    )
    if row["parried"]:
        low, middle, high = row["largest_cm_p5_p50_p95"]
        text += (
            f"; largest move {middle:.0f} cm ({low:.0f} … {high:.0f}),"
            f" turn {row['largest_deg_p5_p50_p95'][1]:.0f}°"
        )
    return text


if __name__ == "__main__":
    experiment(run, Config)
