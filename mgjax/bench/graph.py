"""What ``mgjax bench`` measures."""

from __future__ import annotations

import resource
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from mgjax.bench.timing import interleaved
from mgjax.clips.synthetic import synthetic_clips
from mgjax.graph.build import build_graph
from mgjax.graph.distances.distance import distance_matrix, normalised_weights
from mgjax.graph.distances.minima import find_minima

JOINTS = 31
WINDOW = 10


def smooth_motion(frames: int, seed: int = 0) -> np.ndarray:
    """[F, 31, 3] joint positions that move about as a body's do, for timing only."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None, None] / 30
    pose = rng.normal(size=(1, JOINTS, 3)) * [0.3, 0.5, 0.3] + [0, 1, 0]
    phase, rate = rng.uniform(0, 6.3, (2, 1, JOINTS, 3))
    turn = np.sin(0.05 * t) * 3
    walk = np.concatenate([np.cos(turn), 0 * turn, np.sin(turn)], axis=2) * 2
    return (pose + 0.15 * np.sin(rate * t + phase) + walk).astype(np.float32)


def _bare_product(size: int) -> Any:
    """a @ a.T with as many columns as the distance has floor coordinates."""
    a = jnp.asarray(np.random.default_rng(1).normal(size=(size, 2 * JOINTS)), jnp.float32)
    run = jax.jit(lambda x: x @ x.T)
    return lambda: run(a)


def distance_rows(*, size: int = 8192, repeats: int = 9) -> list[dict[str, Any]]:
    """The distance of all windows: the full matrix, and minima only.

    ``ratio`` compares the rate of floating point operations with that of a bare matrix product of
    the same run, counting 10 J for a pair of windows (the product has 4 J for an entry).
    """
    motion = smooth_motion(size + WINDOW - 1)
    other = smooth_motion(size + WINDOW - 1, seed=1)
    bare = _bare_product(size)
    work = 10 * JOINTS / (4 * JOINTS)
    rows: list[dict[str, Any]] = []
    row = interleaved(lambda: distance_matrix(motion, other, window=WINDOW), bare, repeats)
    pairs = size * size
    row |= {"case": f"full matrix, {size} x {size} windows", "pairs_per_s": pairs / row["median_s"]}
    row["ratio"] = work / row["time_ratio"]
    rows.append(row)
    weights = normalised_weights(None, JOINTS)

    def minima() -> Any:
        return find_minima(
            motion,
            np.array([0]),
            np.array([len(motion)]),
            weights,
            window=WINDOW,
            neighbourhood=1,
            threshold=0.1,
        ).distances

    row = interleaved(minima, bare, repeats)
    row |= {"case": f"minima only, {size} x {size} windows", "pairs_per_s": pairs / row["median_s"]}
    row["ratio"] = work / row["time_ratio"]
    rows.append(row)
    return rows


def build_rows(*, repeats: int = 3) -> list[dict[str, Any]]:
    """The graph of the embedded clips (3 min 28 s), and the peak memory of this process.

    ``ratio`` is its time over that of a bare matrix product of the same run.
    """
    clips, labels = synthetic_clips()
    seconds = sum(clip.motion.seconds for clip in clips)
    bare = _bare_product(4096)
    row = interleaved(lambda: build_graph(clips, labels=labels).edge_exit, bare, repeats)
    row["ratio"] = row["time_ratio"]
    steps = build_graph(clips, labels=labels).report["seconds"]
    row |= {"case": f"build, {seconds:.0f} s of clips", "seconds": steps}
    row["peak_memory_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return [row]
