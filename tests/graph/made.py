"""Small made motions on the body of ``tests/conftest.py``, with one feature each."""

from __future__ import annotations

import numpy as np

from mgjax.clips.types import Clip, Label
from mgjax.core import quaternion
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion
from tests.conftest import make_skeleton

BODY = make_skeleton()
STANDING_M = 1.02
"""Root height at which the balls of the feet of a straight body are 2 cm up."""


def bend(motion_rotations: np.ndarray, name: str, angle: np.ndarray) -> None:
    """Turns a joint about X: for a leg, a negative angle swings it forward."""
    axis = np.tile([1.0, 0.0, 0.0], (len(angle), 1))
    motion_rotations[:, BODY.index(name)] = quaternion.from_axis_angle(axis, angle)


def march(
    frames: int = 120,
    *,
    period: float = 30.0,
    swing: float = 0.35,
    speed: float = 0.0,
    heading: float = 0.0,
    place: tuple[float, float] = (0.0, 0.0),
    ducks: tuple[float, ...] = (),
    noise: float = 0.01,
    seed: int = 0,
    frame_rate: float = 30.0,
) -> Motion:
    """Legs and arms swing; the body goes ahead at ``speed`` and crouches about ``ducks`` (s)."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames) * 30.0 / frame_rate
    phase = 2 * np.pi * t / period

    def wander() -> np.ndarray:
        hertz = rng.uniform(0.1, 0.6, 3)
        waves = np.sin(2 * np.pi * hertz * t[:, None] / 30 + rng.uniform(0, 6, 3))
        return noise * waves.sum(axis=1)

    down = sum((np.exp(-0.5 * ((t / 30 - when) / 0.12) ** 2) for when in ducks), np.zeros(frames))
    rotations = np.tile([1.0, 0, 0, 0], (frames, BODY.num_joints, 1))
    for side, sign in (("l", 1), ("r", -1)):
        wave = sign * np.sin(phase)
        bend(rotations, f"{side}femur", -0.1 - swing * wave - 0.9 * down + wander())
        bend(rotations, f"{side}tibia", 0.2 + 0.5 * swing * (1 + wave) + 1.8 * down + wander())
        bend(rotations, f"{side}humerus", swing * wave + wander())
    bend(rotations, "thorax", 0.3 * down + wander())
    yaw = heading + wander()
    rotations[:, 0] = quaternion.from_yaw(yaw)
    along = speed * t / 30
    root = np.stack(
        [
            place[0] + along * np.sin(heading),
            STANDING_M - 0.04 * swing * np.abs(np.sin(phase)) - 0.35 * down,
            place[1] + along * np.cos(heading),
        ],
        axis=1,
    )
    return Motion(
        root_translation=root.astype(np.float32),
        local_rotations=rotations.astype(np.float32),
        frame_rate=frame_rate,
    )


def places(motion: Motion) -> np.ndarray:
    """World positions, float32."""
    return np.asarray(global_positions(BODY, motion), np.float32)


def clip(name: str, motion: Motion) -> Clip:
    return Clip(name=name, skeleton=BODY, motion=motion)


def made_clips() -> tuple[list[Clip], dict[str, tuple[Label, ...]]]:
    """Three marches, two with ducks that are labelled."""
    first, second = (1.5, 3.0), (2.0,)
    clips = [
        clip("a", march(150, ducks=first, seed=1)),
        clip("b", march(150, ducks=second, seed=2, heading=2.0, place=(40.0, -30.0))),
        clip("c", march(110, seed=3, swing=0.38, speed=0.1)),
    ]
    labels = {
        name: tuple(
            Label(start_s=d - 0.3, end_s=d + 0.3, kind="duck", direction=side, genuine=i == 0)
            for i, (d, side) in enumerate(zip(ducks, ("left", ""), strict=False))
        )
        for name, ducks in (("a", first), ("b", second))
    }
    return clips, labels
