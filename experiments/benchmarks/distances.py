"""The distance of all pairs of windows: time beside a bare product, and how exact it is.

    python -m experiments.benchmarks.distances --out out/benchmarks/distances

Times are of made-up motion of 31 joints. The error is that against the definition (hybrid paper
eq. 1), in float64, over all pairs of windows of two short motions, at the origin and away from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mgjax.bench.graph import WINDOW, build_rows, distance_rows, smooth_motion
from mgjax.graph.distances.distance import distance_matrix
from mgjax.runs.experiment import Results, experiment


@dataclass(frozen=True, kw_only=True)
class Config:
    """Settings."""

    size: int = 8192
    """Windows of each motion."""
    repeats: int = 9
    """Timed calls, in turns with the bare product."""
    builds: int = 3
    """Timed builds of the graph of the embedded clips; 0: none."""
    exact: int = 120
    """Frames of the motions whose distances are compared with the definition."""
    away_m: float = 50.0
    """How far from the origin, m."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"size": 128, "repeats": 1, "builds": 0, "exact": 20}


def run(config: Config) -> Results:
    rows = distance_rows(size=config.size, repeats=config.repeats)
    built = build_rows(repeats=config.builds) if config.builds else []
    a, b = smooth_motion(config.exact), smooth_motion(config.exact, seed=1)
    errors = {}
    for name, moved in (("origin", 0.0), ("away", config.away_m)):
        away = np.array([moved, 0.0, moved], np.float32)
        found = np.asarray(distance_matrix(a + away, b + away, window=WINDOW))
        errors[name] = float(np.abs(found - defined(a + away, b + away)).max())
    lines = [f"{row['case']}: {row['median_s']:.3f} s, ratio {row['ratio']:.2f}" for row in rows]
    lines.append(f"largest error {errors['origin']:.1e} m, away {errors['away']:.1e} m")
    return Results(
        metrics={"largest_error_m": errors},
        timings={"distances": rows, "build": built},
        lines=tuple(lines),
    )


def defined(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """[R,C] eq. 1 in float64, pair by pair: the best turn and shift on the floor."""
    rows, columns = (len(x) - WINDOW + 1 for x in (a, b))
    out = np.zeros((rows, columns))
    for r in range(rows):
        one = a[r : r + WINDOW].reshape(-1, 3).astype(np.float64)
        for c in range(columns):
            other = b[c : c + WINDOW].reshape(-1, 3).astype(np.float64)
            p, q = (x[:, ::2] - x[:, ::2].mean(0) for x in (one, other))
            along, across = (p * q).sum(), (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum()
            squared = (p * p).sum() + (q * q).sum() - 2 * np.hypot(along, across)
            squared += ((one[:, 1] - other[:, 1]) ** 2).sum()
            out[r, c] = np.sqrt(max(squared / len(one), 0.0))
    return out


if __name__ == "__main__":
    experiment(run, Config)
