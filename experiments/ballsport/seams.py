"""Pairs of link motions joined at their best sections, and how smoothly."""

from __future__ import annotations

from typing import Any

import numpy as np

from mgjax.ballsport.clipset.build import ClipSet
from mgjax.ballsport.clipset.joining import join
from mgjax.ballsport.clipset.transition import TransitionTable
from mgjax.core.kinematics import global_positions


def seams(clips: ClipSet, table: TransitionTable, most: int, seed: int) -> dict[str, Any]:
    """Joins pairs of link motions at their best sections and looks at the blends."""
    rng = np.random.default_rng(seed)
    pairs = np.argwhere(np.isfinite(table.distance))
    pairs = pairs[rng.permutation(len(pairs))[:most]]
    rate, window = clips.motion.frame_rate, table.window
    rows: list[tuple[float, float, float, float]] = []
    for i, j in pairs:
        leave, arrive = int(table.leave[i, j]), int(table.arrive[i, j])
        begin = max(leave - 2, int(clips.clip_starts[clips.link_clip[i]]))
        end = min(arrive + window + 2, int(clips.clip_stops[clips.link_clip[j]]))
        joined = join(clips, [(begin, leave + window), (arrive, end)], window=window)
        positions = np.asarray(global_positions(clips.skeleton, joined.motion))
        own = _own_speeds(clips, begin, leave + window), _own_speeds(clips, arrive, end)
        rows.append((*_speeds(positions, rate), *np.max(own, axis=0)))
    speed, change, own_speed, own_change = np.array(rows).T
    return {
        "pairs": len(rows),
        "largest_joint_speed_m_s_p50_p95_max": np.percentile(speed, [50, 95, 100]),
        "same_windows_before_joining_m_s_p50_p95_max": np.percentile(own_speed, [50, 95, 100]),
        "speed_change_per_frame_m_s_p50_p95_max": np.percentile(change, [50, 95, 100]),
        "change_before_joining_m_s_p50_p95_max": np.percentile(own_change, [50, 95, 100]),
    }


def _speeds(positions: np.ndarray, rate: float) -> tuple[float, float]:
    """Largest joint speed, and largest change of a joint's velocity from frame to frame, m/s."""
    velocity = np.diff(positions, axis=0) * rate
    top = float(np.linalg.norm(velocity, axis=-1).max())
    return top, float(np.linalg.norm(np.diff(velocity, axis=0), axis=-1).max())


def _own_speeds(clips: ClipSet, start: int, stop: int) -> tuple[float, float]:
    """Largest joint speed and change of velocity of a piece before it is joined, m/s."""
    return _speeds(clips.positions[start:stop], clips.motion.frame_rate)
