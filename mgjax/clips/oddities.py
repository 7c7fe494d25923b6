"""What is strange about a captured motion, and what to do without it.

Nothing here changes a motion: loading keeps every frame, ``info`` prints the oddities, and the
graph builder asks where to cut.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mgjax.core.body.height import body_scale
from mgjax.core.body.roles import find_role
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton

MAX_SPEED_M_S = 25.0
"""A hard kick or throw of an adult moves the fastest joint at 15–20 m/s."""

MIN_JUMP_M = 0.15
"""Smaller steps of an adult are noise, not a jump, whatever the frame rate makes of their speed."""

FLOOR_TOLERANCE_M = 0.03
"""Capture is not calibrated better than this."""

SLOW_FPS = 10.0
"""No capture is slower; a header that says so is wrong."""

SETTLED_M = 0.02
"""Movement of an adult in a frame below which a pose that a T-pose was blended into counts as free
of it."""

_MOST = 10


@dataclass(frozen=True)
class Oddity:
    """One finding.

    Attributes:
        kind: ``slow_rate``, ``t_pose_first_frame``, ``jump``, ``feet_under_floor``,
            ``zero_offsets`` or ``moving_bones``.
        frame: where it is, or None where it is about the whole file.
        text: one line for a reader.
    """

    kind: str
    frame: int | None
    text: str


def find_oddities(skeleton: Skeleton, motion: Motion) -> tuple[Oddity, ...]:
    """All oddities of a motion, in the order of the kinds above; at most ten jumps one by one."""
    positions = np.asarray(global_positions(skeleton, motion))
    steps = _steps(positions)
    scale = body_scale(skeleton)
    oddities: list[Oddity] = []
    if motion.frame_rate < SLOW_FPS:
        text = f"{motion.frame_rate:g} frames a second are too few for motion; --fps says the rate"
        oddities.append(Oddity("slow_rate", None, text))
    t_pose = _t_pose(motion, steps, scale)
    if t_pose:
        clean = _clean(steps, motion.frame_rate, scale)
        text = (
            f"frame 0 is the rest pose and {steps[0].max():.2f} m away from frame 1;"
            f" frame {clean} is the first without a trace of it"
        )
        oddities.append(Oddity("t_pose_first_frame", 0, text))
    oddities += _jumps(skeleton, steps, motion.frame_rate, t_pose, scale)
    oddities += _feet(skeleton, positions)
    oddities += _bones(skeleton, motion)
    return tuple(oddities)


def jump_frames(skeleton: Skeleton, motion: Motion) -> np.ndarray:
    """Frames f such that the motion jumps between f − 1 and f, in rising order.

    A jump is a joint of an adult faster than 25 m/s and by at least 0.15 m. The step out of a
    T-pose in frame 0 is not one of them; see :func:`first_clean_frame`.
    """
    steps = _steps(np.asarray(global_positions(skeleton, motion)))
    scale = body_scale(skeleton)
    return _jump_frames(steps, motion.frame_rate, _t_pose(motion, steps, scale), scale)


def first_clean_frame(skeleton: Skeleton, motion: Motion) -> int:
    """The first frame without a trace of a T-pose in frame 0; 0 where there is none.

    Some converters filter the angles, so that the T-pose is blended into the frames after it.
    """
    steps = _steps(np.asarray(global_positions(skeleton, motion)))
    scale = body_scale(skeleton)
    return _clean(steps, motion.frame_rate, scale) if _t_pose(motion, steps, scale) else 0


def _steps(positions: np.ndarray) -> np.ndarray:
    """[F-1, J] metres that each joint moves from a frame to the next."""
    return np.linalg.norm(np.diff(positions, axis=0), axis=-1)


def _t_pose(motion: Motion, steps: np.ndarray, scale: float) -> bool:
    if len(steps) == 0:
        return False
    top = steps.max(axis=1)
    usual = float(np.median(top[1:])) if len(top) > 1 else 0.0
    fast = top[0] * motion.frame_rate >= scale * MAX_SPEED_M_S or top[0] >= 3 * usual
    if top[0] < scale * MIN_JUMP_M or not fast:
        return False
    # Mean angle to the rest pose. The root's rotation is a place in the world, not a pose.
    q = np.asarray(motion.local_rotations, dtype=np.float64)[:, 1:]
    angle = np.arctan2(np.linalg.norm(q[..., 1:], axis=-1), np.abs(q[..., 0])).mean(axis=1)
    return bool(angle[0] < angle[1] and angle[0] <= 0.5 * np.median(angle[1:]))


def _clean(steps: np.ndarray, frame_rate: float, scale: float) -> int:
    """First frame after which the motion no longer runs away from the pose of frame 0."""
    top = steps.max(axis=1)
    window = max(round(0.15 * frame_rate), 1)
    usual = np.median(top[window : 3 * window]) if len(top) > window else 0.0
    restless = np.flatnonzero(top[:window] > max(scale * SETTLED_M, 2 * usual))
    return int(restless[-1]) + 1 if restless.size else 1


def _jump_frames(steps: np.ndarray, frame_rate: float, t_pose: bool, scale: float) -> np.ndarray:
    bound = scale * max(MAX_SPEED_M_S / frame_rate, MIN_JUMP_M)
    frames = np.flatnonzero((steps >= bound).any(axis=1)) + 1
    return frames[frames > 1] if t_pose else frames


def _jumps(
    skeleton: Skeleton, steps: np.ndarray, frame_rate: float, t_pose: bool, scale: float
) -> list[Oddity]:
    frames = _jump_frames(steps, frame_rate, t_pose, scale)
    oddities: list[Oddity] = []
    for frame in frames[:_MOST]:
        joint = int(np.argmax(steps[frame - 1]))
        step = float(steps[frame - 1, joint])
        text = (
            f"{skeleton.names[joint]} moves {step:.2f} m from frame {frame - 1} to frame {frame}"
            f" ({step * frame_rate:.0f} m/s)"
        )
        oddities.append(Oddity("jump", int(frame), text))
    if len(frames) > _MOST:
        text = f"{len(frames) - _MOST} more jumps, the last to frame {frames[-1]}"
        oddities.append(Oddity("jump", int(frames[_MOST]), text))
    return oddities


def _feet(skeleton: Skeleton, positions: np.ndarray) -> list[Oddity]:
    points = _foot_points(skeleton)
    lowest = positions[:, points, 1].min(axis=1)
    frame = int(np.argmin(lowest))
    if lowest[frame] >= -FLOOR_TOLERANCE_M:
        return []
    under = int((lowest < -FLOOR_TOLERANCE_M).sum())
    text = (
        f"a foot is {-lowest[frame]:.3f} m under the floor in frame {frame},"
        f" more than {FLOOR_TOLERANCE_M:g} m in {under} of {len(lowest)} frames"
    )
    return [Oddity("feet_under_floor", frame, text)]


def _foot_points(skeleton: Skeleton) -> list[int]:
    """The ankles and all that hangs on them; all joints where no ankle is known by its name."""
    ankles = {find_role(skeleton, role) for role in ("left_ankle", "right_ankle")} - {None}
    feet: set[int] = set()
    for joint, parent in enumerate(skeleton.parents):
        if joint in ankles or parent in feet:
            feet.add(joint)
    return sorted(feet) or list(range(skeleton.num_joints))


def _bones(skeleton: Skeleton, motion: Motion) -> list[Oddity]:
    oddities: list[Oddity] = []
    flat = np.flatnonzero((np.asarray(skeleton.offsets)[1:] == 0).all(axis=1)) + 1
    if flat.size:
        text = f"{_count(flat)} zero offset: {_list(skeleton, flat)}"
        oddities.append(Oddity("zero_offsets", None, text))
    if motion.joint_offsets is not None:
        moving = np.flatnonzero((np.ptp(np.asarray(motion.joint_offsets), axis=0) > 1e-6).any(1))
        text = f"{_count(moving)} no fixed place in the parent's frame: {_list(skeleton, moving)}"
        oddities.append(Oddity("moving_bones", None, text))
    return oddities


def _count(joints: np.ndarray) -> str:
    return "1 joint has" if len(joints) == 1 else f"{len(joints)} joints have"


def _list(skeleton: Skeleton, joints: np.ndarray) -> str:
    names = ", ".join(skeleton.names[j] for j in joints[:_MOST])
    return names if len(joints) <= _MOST else f"{names}, …"
