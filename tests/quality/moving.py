"""A body that moves a little in every joint, its feet near the floor."""

from __future__ import annotations

import numpy as np

from mgjax.core import quaternion
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton


def moving(skeleton: Skeleton, seconds: float, seed: int, rate: float = 60.0) -> Motion:
    """Sums of slow waves in every angle; feet come near the floor, stand and slide."""
    rng = np.random.default_rng(seed)
    times = np.arange(round(seconds * rate)) / rate
    waves = rng.uniform(0.2, 0.8, (3, skeleton.num_joints, 3))
    phases = rng.uniform(0, 2 * np.pi, waves.shape)
    sizes = rng.uniform(0.0, 0.05, waves.shape)
    phase = 2 * np.pi * waves * times[:, None, None, None] + phases
    vector = (sizes * np.sin(phase)).sum(axis=1)
    vector[:, list(skeleton.end_joints)] = 0.0
    angle = np.linalg.norm(vector, axis=-1)
    turns = quaternion.from_axis_angle(vector / np.maximum(angle, 1e-9)[..., None], angle)
    root = np.stack(
        [0.25 * seed * times, 0.99 + 0.02 * np.sin(3 * times), 0.05 * np.cos(times)], axis=-1
    )
    return Motion(
        root_translation=root.astype(np.float32),
        local_rotations=np.asarray(turns, np.float32),
        frame_rate=rate,
    )
