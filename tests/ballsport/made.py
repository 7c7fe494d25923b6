"""Made motion for the tests of hits."""

from __future__ import annotations

import numpy as np


def wavy_path(seed: int, frames: int, rate: float) -> np.ndarray:
    """[F,3] sums of sines with hits in plenty; every fourth is rounded, so that it has plateaus."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames) / rate
    path = np.zeros((frames, 3))
    for _ in range(5):
        wave = np.sin(2 * np.pi * rng.uniform(0.3, 5) * t + rng.uniform(0, 6))
        path += 0.3 * rng.normal(size=3) * wave[:, None]
    path += rng.normal(size=path.shape) * (0.01 if seed % 3 == 0 else 0.0)
    path[:, 1] = np.abs(path[:, 1])
    return np.round(path, 1) if seed % 4 == 0 else path


def bumps(rate: float, *events: tuple[float, float, float], seconds: float = 4.0) -> np.ndarray:
    """[F,3] a bone at rest at 0.05 m that is raised: (time, height, width), all s and m."""
    t = np.arange(round(seconds * rate)) / rate
    path = np.zeros((len(t), 3))
    path[:, 1] = 0.05
    for at, height, width in events:
        path[:, 1] += height * np.exp(-0.5 * ((t - at) / width) ** 2)
    return path
