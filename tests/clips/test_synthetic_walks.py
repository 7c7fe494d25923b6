from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from mgjax.clips.synthetic_walks import STEP_DEG, synthetic_walks
from mgjax.clips.types import Clip
from mgjax.core.body.roles import require_roles
from mgjax.core.errors import MotionError
from mgjax.core.kinematics import global_positions, planar_frames
from mgjax.core.motion import validate_motion

STEPS = 8


@lru_cache(maxsize=1)
def walks() -> list[Clip]:
    return synthetic_walks()


def positions_of(clip: Clip) -> np.ndarray:
    return np.asarray(global_positions(clip.skeleton, clip.motion), np.float64)


def test_there_is_one_for_each_curvature_to_both_sides() -> None:
    names = {clip.name for clip in walks()}
    assert names == {f"arc_{sign * angle}" for angle in STEP_DEG for sign in (1, -1)}
    for clip in walks():
        validate_motion(clip.skeleton, clip.motion)


@pytest.mark.parametrize("number", range(2 * len(STEP_DEG) - 1))
def test_each_turns_by_its_steps_and_begins_and_ends_at_rest(number: int) -> None:
    clip = walks()[number]
    positions = positions_of(clip)
    heading = np.unwrap(np.asarray(planar_frames(clip.skeleton, positions))[:, 0])
    turned = np.degrees(heading[-1] - heading[0])
    assert turned == pytest.approx(STEPS * float(clip.name.split("_")[1]), abs=3.0)
    speed = np.linalg.norm(np.diff(positions[:, 0, ::2], axis=0), axis=1) * clip.motion.frame_rate
    assert speed[[0, -1]].max() < 0.05
    assert 0.75 < speed[30:-30].mean() < 1.4


@pytest.mark.parametrize("number", range(2 * len(STEP_DEG) - 1))
def test_a_foot_on_the_floor_does_not_slide(number: int) -> None:
    clip = walks()[number]
    positions = positions_of(clip)
    toes = positions[:, list(require_roles(clip.skeleton, ("left_toe", "right_toe")))]
    low = toes[..., 1] < 0.0205
    still = low[1:] & low[:-1]
    steps = np.linalg.norm(np.diff(toes[..., ::2], axis=0), axis=-1)
    assert still.any(axis=0).all()
    assert steps[still].max() < 0.004
    assert positions[..., 1].min() > -0.01


@pytest.mark.parametrize("rate", [0.0, float("nan"), 1e9])
def test_a_rate_has_to_be_one(rate: float) -> None:
    with pytest.raises(MotionError, match="expected 1 … 10000"):
        synthetic_walks(frame_rate=rate)
