"""FABRIK: time of single and batched solves, success on sets of targets, limits, gradients.

Chains of nine joints and uneven bones, to 1 mm. The sets: random targets anywhere within reach;
straight chains with the target on their line, in front or behind, the root at the origin; targets
at 94–99 % of full reach; targets out of reach (for lengths and gradients). With limits, targets are
ends of random poses inside them. Times of a batch are also given as a ratio to one bare pass over
its joints, measured in turns with it. Run: ``python -m experiments.benchmarks.fabrik``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from mgjax.bench.timing import interleaved
from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core import kinematics, quaternion
from mgjax.core.body.joint_limits import JointLimits, clamp, random_rotations
from mgjax.core.skeleton import Skeleton
from mgjax.hybrid import LIMBS, REACHED, fabrik, fabrik_tree, find_limb, joint_limits, reach_pose
from mgjax.runs.experiment import Results, experiment

PUBLISHED = {
    "caliko_4_links_us": 2.9,
    "caliko_8_links_us": 13.3,
    "pyfabrik_4_links_us": 147.0,
    "pyfabrik_8_links_us": 360.0,
    "mink_8_bones_ms": 0.19,
    "pyroki_8_bones_single_ms": 0.27,
    "jax_ik_fabrik_with_limits_reached": 0.096,
}
"""Figures of others, as published or as measured once elsewhere; not measured here."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Settings.

    Attributes:
        chains: in a batch and in each set.
        joints: of a chain.
        tolerance: m.
        iterations: of FABRIK at most, before the closed form.
        limited: poses with limits.
        bodies: poses with both hands and the head at once.
        repeats: of each timing.
        seed: of all random numbers.
    """

    chains: int = 4096
    joints: int = 9
    tolerance: float = 1e-3
    iterations: int = 4
    limited: int = 1024
    bodies: int = 256
    repeats: int = 40
    seed: int = 0

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"chains": 64, "joints": 5, "limited": 16, "bodies": 4, "repeats": 3}


def run(config: Config) -> Results:
    solve = partial(fabrik, tolerance=config.tolerance, max_iterations=config.iterations)

    @jax.jit
    def slope(joints: jax.Array, targets: jax.Array, weights: jax.Array) -> tuple:
        return jax.grad(lambda j, t: jnp.sum(weights * solve(j, t)[0]), argnums=(0, 1))(
            joints, targets
        )

    sets = {name: judge(solve, slope, *pair, config) for name, pair in chain_sets(config).items()}
    timings = {"chains": chain_times(solve, config)}
    limited, timings["limits"] = with_limits(config)
    bodies, timings["bodies"] = both_hands_and_head(config)
    metrics = {"sets": sets, "limits": limited, "bodies": bodies, "published": PUBLISHED}
    return Results(metrics=metrics, timings=timings, lines=lines(metrics, timings))


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def chain_sets(config: Config) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Joints and targets of each set."""
    rng = np.random.default_rng(config.seed)
    count, bones = config.chains, config.joints - 1
    lengths = rng.uniform(0.03, 0.3, (count, bones))
    far = lengths.sum(axis=1, keepdims=True)
    near = np.maximum(2 * lengths.max(axis=1, keepdims=True) - far, 0)
    bent = unit(rng.normal(size=(count, 1, 3)) + rng.normal(size=(count, bones, 3)))
    straight = np.repeat(unit(rng.normal(size=(count, 1, 3))), bones, axis=1)
    even = np.full_like(lengths, 1 / bones)
    ahead = unit(rng.normal(size=(count, 3)))
    side = rng.choice([-1.0, 1.0], (count, 1))

    def joints(ways: np.ndarray, sizes: np.ndarray) -> np.ndarray:
        places = np.cumsum(ways * sizes[..., None], axis=1)
        return np.concatenate([np.zeros((count, 1, 3)), places], axis=1).astype(np.float32)

    def between(low: np.ndarray | float, high: np.ndarray | float) -> np.ndarray:
        return low + rng.uniform(size=(count, 1)) * (high - low)

    pairs = {
        "random reachable": (joints(bent, lengths), ahead * between(near, far)),
        "collinear": (joints(straight, lengths), side * straight[:, 0] * between(near, far)),
        "collinear, even bones": (joints(straight, even), side * straight[:, 0] * between(0, 1)),
        "94-99 % of full reach": (joints(bent, lengths), ahead * far * between(0.94, 0.99)),
        "too far": (joints(bent, lengths), ahead * far * between(1.01, 2.0)),
    }
    return {name: (chain, target.astype(np.float32)) for name, (chain, target) in pairs.items()}


def judge(
    solve: Callable, slope: Callable, joints: np.ndarray, targets: np.ndarray, config: Config
) -> dict:
    """Success, lengths, root and gradients on one set."""
    found, status = map(np.asarray, solve(joints, targets))
    miss = np.linalg.norm(found[:, -1] - targets, axis=-1)
    old, new = (np.linalg.norm(np.diff(p, axis=1), axis=-1) for p in (joints, found))
    weights = np.random.default_rng(config.seed).normal(size=joints.shape).astype(np.float32)

    slopes = [np.asarray(g).reshape(len(joints), -1) for g in slope(joints, targets, weights)]
    finite = np.isfinite(slopes[0]).all(axis=1) & np.isfinite(slopes[1]).all(axis=1)
    return {
        "within_1_5_mm": float((miss <= 1.5e-3).mean()),
        "within_tolerance": float((status == REACHED).mean()),
        "largest_miss_m": float(miss.max()),
        "largest_length_error_m": float(np.abs(new - old).max()),
        "largest_root_error_m": float(np.abs(found[:, 0] - joints[:, 0]).max()),
        "non_finite_values": int((~np.isfinite(found)).sum()),
        "non_finite_gradients": int((~finite).sum()),
        "largest_target_gradient": float(np.abs(slopes[1]).max()),
    }


def chain_times(solve: Callable, config: Config) -> dict[str, Any]:
    """Seconds of one solve, alone and in a batch."""
    joints, targets = map(jnp.asarray, chain_sets(config)["random reachable"])
    single = joints[0], targets[0]
    bare = jax.jit(lambda j: 2 * j + 1)
    batch = interleaved(lambda: solve(joints, targets), lambda: bare(joints), config.repeats)
    alone = interleaved(lambda: solve(*single), lambda: bare(single[0]), config.repeats)
    batch["median_us_a_solve"] = 1e6 * batch["median_s"] / config.chains
    batch["lower_quartile_us_a_solve"] = 1e6 * batch["quartiles_s"][0] / config.chains
    return {"batch": batch, "single": alone}


def limited_arm() -> tuple[np.ndarray, JointLimits, dict]:
    """Back, collar bone, shoulder, elbow, wrist and hand of a body, with human ranges."""
    rows = [
        # bone (m), swing about z and about its square (degrees), twist (degrees)
        ((0.0, 0.12, 0), (-10, 30, -15, 15), (-10, 10)),
        ((0.0, 0.12, 0), (-10, 30, -15, 15), (-15, 15)),
        ((0.0, 0.125, 0), (-10, 30, -15, 15), (-15, 15)),
        ((-0.18, 0.02, -0.02), (-10, 25, -15, 15), (0, 0)),
        ((-0.29, 0, 0), (-60, 90, -40, 110), (-60, 60)),
        ((-0.21, 0, 0), (0, 145, 0, 0), (-80, 80)),
        ((-0.09, 0, 0), (-60, 60, -20, 20), (0, 0)),
        ((-0.05, 0, 0), (-20, 80, 0, 0), (0, 0)),
        ((-0.05, 0, 0), (0, 0, 0, 0), (0, 0)),
    ]
    bones = np.array([row[0] for row in rows])
    offsets = np.concatenate([np.zeros((1, 3)), bones[:-1]]).astype(np.float32)
    limits = joint_limits(
        bones,
        swing=np.radians([row[1] for row in rows]).tolist(),
        twist=np.radians([row[2] for row in rows]).tolist(),
        across=[[0.0, 0.0, 1.0]] * len(rows),
    )
    count = len(rows)
    return offsets, limits, {"parents": tuple(range(-1, count - 1)), "ends": (count - 1,)}


def with_limits(config: Config) -> tuple[dict, dict]:
    """Targets of random poses inside the limits, from other such poses."""
    offsets, limits, tree = limited_arm()
    rng = np.random.default_rng(config.seed)
    count = len(offsets)
    chain = Skeleton(names=tuple(map(str, range(count))), parents=tree["parents"], offsets=offsets)
    base = np.zeros((config.limited, 3), np.float32)
    wanted, start = (random_rotations(rng, config.limited, limits) for _ in range(2))
    targets = kinematics.forward(chain, base, wanted)[0][:, -1:]
    solve = partial(fabrik_tree, offsets, base, start, targets, tolerance=config.tolerance, **tree)
    cases = {
        "stages alone": partial(solve, limits=limits, max_iterations=64, max_steps=0, max_starts=1),
        "stages and steps, one start": partial(solve, limits=limits, max_starts=1),
        "with more starts": partial(solve, limits=limits),
        "limits off": solve,
    }
    metrics, timings = {}, {}
    for name, case in cases.items():
        found, status = map(np.asarray, case())
        ends = kinematics.forward(chain, base, found)[0][:, -1]
        outside = quaternion.angle_between(clamp(found, limits)[:, :-1], found[:, :-1])
        miss = np.linalg.norm(ends - targets[:, 0], axis=-1)
        metrics[name] = {
            "reached": float((status == REACHED).mean()),
            "within_1_5_mm": float((miss <= 1.5e-3).mean()),
            "largest_angle_outside_limits_rad": float(outside.max()),
        }
        timings[name] = interleaved(case, None, max(config.repeats // 8, 1))
        timings[name]["median_us_a_pose"] = 1e6 * timings[name]["median_s"] / config.limited
    return metrics, timings


def both_hands_and_head(config: Config) -> tuple[dict, dict]:
    """A body whose hands and head have targets at once, within what a pose near it can do."""
    skeleton = synthetic_skeleton()
    rng = np.random.default_rng(config.seed)
    shape = (config.bodies, skeleton.num_joints)

    def poses(spread: float) -> np.ndarray:
        axes, angles = unit(rng.normal(size=(*shape, 3))), rng.normal(scale=spread, size=shape)
        turns = np.array(quaternion.from_axis_angle(axes, angles))
        turns[:, [0, *skeleton.end_joints]] = (1, 0, 0, 0)
        return np.asarray(turns, np.float32)

    start = poses(0.2)
    moved = quaternion.multiply(start, poses(0.25)).astype(np.float32)
    roots = np.zeros((config.bodies, 3), np.float32)
    limbs = tuple(find_limb(skeleton, name) for name in LIMBS)
    ends = [limb.joints[-1] for limb in limbs]
    targets = kinematics.forward(skeleton, roots, moved)[0][:, ends].astype(np.float32)
    metrics, timings = {}, {}
    for name, chosen in (("right hand", limbs[:1]), ("hands and head", limbs)):
        solve = partial(
            reach_pose,
            skeleton,
            roots,
            start,
            targets[:, : len(chosen)],
            limbs=chosen,
            tolerance=config.tolerance,
        )
        found, status = map(np.asarray, solve())
        got = kinematics.forward(skeleton, roots, found)[0]
        bones = np.linalg.norm(got[:, 1:] - got[:, list(skeleton.parents[1:])], axis=-1)
        wanted = np.linalg.norm(np.asarray(skeleton.offsets)[1:], axis=-1)[None]
        miss = np.linalg.norm(got[:, ends[: len(chosen)]] - targets[:, : len(chosen)], axis=-1)
        metrics[name] = {
            "all_reached": float((status == REACHED).all(axis=1).mean()),
            "all_within_1_5_mm": float((miss <= 1.5e-3).all(axis=1).mean()),
            "largest_length_error_m": float(np.abs(bones - wanted).max()),
        }
        timings[name] = interleaved(solve, None, max(config.repeats // 4, 1))
        timings[name]["median_us_a_pose"] = 1e6 * timings[name]["median_s"] / config.bodies
    return metrics, timings


def lines(metrics: dict, timings: dict) -> tuple[str, ...]:
    batch, single = timings["chains"]["batch"], timings["chains"]["single"]
    rows = [
        f"batch: {batch['median_us_a_solve']:.2f} us a solve (lower quartile"
        f" {batch['lower_quartile_us_a_solve']:.2f}), {batch['time_ratio']:.0f} x a bare pass;"
        f" single: {1e3 * single['median_s']:.3f} ms",
    ]
    for name, row in metrics["sets"].items():
        rows.append(
            f"{name}: {100 * row['within_1_5_mm']:.2f} % within 1.5 mm, lengths to"
            f" {row['largest_length_error_m']:.1e} m, root to {row['largest_root_error_m']:.1e} m,"
            f" {row['non_finite_gradients']} gradients not finite"
        )
    for name, row in metrics["limits"].items():
        us = timings["limits"][name]["median_us_a_pose"]
        rows.append(
            f"limited arm, {name}: {100 * row['reached']:.1f} % reached, {us:.0f} us a pose"
        )
    for name, row in metrics["bodies"].items():
        us = timings["bodies"][name]["median_us_a_pose"]
        rows.append(f"body, {name}: {100 * row['all_reached']:.1f} % reached, {us:.0f} us a pose")
    others = ", ".join(f"{name} {value:g}" for name, value in PUBLISHED.items())
    return (*rows, f"elsewhere, not measured here: {others}")


if __name__ == "__main__":
    experiment(run, Config)
