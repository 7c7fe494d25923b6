"""A change of a motion: how its channels go over time, and what that does to its joints."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float

from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.avoidance.refinement.pose import ankles_of, changed
from mgjax.avoidance.refinement.rig import Rig
from mgjax.core import planar, quaternion
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.shown import like

FADE_S = 0.12
"""Within this time of standing on it a foot is not yet free to be moved as much as it might be."""


@dataclass(frozen=True, kw_only=True, eq=False)
class JointChange:
    """What a change does to joints: of whatever changes a motion by curves within a window.

    Attributes:
        start: of the window in which it is changed, s from now.
        values: channels from then on, 120 times a second. Zero at both ends. [W, C]
        joints: names of the joints that it changes.
        moved_m: how far each of them is moved at most, m.
        turned_deg: how far each of them turns at most in its parent's frame, degrees.
        clearance_before_m, clearance_m: signed distance of attack and body without it and with
            it, m.
    """

    start: float
    values: Float[np.ndarray, "W C"]
    joints: tuple[str, ...]
    moved_m: tuple[float, ...]
    turned_deg: tuple[float, ...]
    clearance_before_m: float
    clearance_m: float

    @property
    def stop(self) -> float:
        """End of the window, s from now."""
        return self.start + (len(self.values) - 1) / EXPORT_RATE

    @property
    def largest_m(self) -> float:
        """How far any joint is moved at most, m."""
        return max(self.moved_m, default=0.0)

    @property
    def largest_deg(self) -> float:
        """How far any joint turns at most, degrees."""
        return max(self.turned_deg, default=0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Refinement(JointChange):
    """How a motion was changed so that an attack misses it.

    Its ``values`` are channels of :class:`~mgjax.avoidance.refinement.rig.Rig`, m and rad; the root
    and the feet are moved in the frame of the attack.

    Attributes:
        coefficients: of the splines that ``values`` come from, before planted feet are left where
            they are; see :mod:`mgjax.avoidance.refinement.splines`. [K, C]
        shift_s: how much later than eq. 3 has it the avoidance part of the walk comes, s; earlier
            if negative.
    """

    coefficients: Float[np.ndarray, "K C"]
    shift_s: float = 0.0

    def effort(self, config: AvoidanceConfig) -> float:
        """The larger of move and turn, as shares of the caps; 0 … 1."""
        tiny = 1e-9
        return max(
            self.largest_m / max(config.refine_max_m, tiny),
            self.largest_deg / max(config.refine_max_deg, tiny),
        )


def channels_at(
    values: Float[np.ndarray, "W C"], start: float, times: Float[np.ndarray, " T"]
) -> Float[np.ndarray, "T C"]:
    """Channels at any times; 0 outside of the window."""
    position = (np.asarray(times, np.float64) - start) * EXPORT_RATE
    last = len(values) - 1
    within = np.clip(position, 0, last)
    low = np.minimum(within.astype(np.int64), last - 1)
    share = (within - low)[:, None]
    mixed = values[low] * (1 - share) + values[low + 1] * share
    return np.where(((position >= 0) & (position <= last))[:, None], mixed, 0.0)


def change_motion(
    rig: Rig,
    motion: Motion,
    times: Float[np.ndarray, " T"],
    values: Float[np.ndarray, "W C"],
    start: float,
    *,
    angle: float = 0.0,
) -> Motion:
    """A motion whose channels are changed; frames outside of the window stay as they are.

    Args:
        rig: the channels.
        motion: a pose for each of the ``times``.
        times: s from now.
        values, start: of a :class:`Refinement`.
        angle: about the vertical, rad, from the frame of the values to that of the motion.
    """
    inside = (times > start) & (times < start + (len(values) - 1) / EXPORT_RATE)
    if not inside.any():
        return motion
    channels = channels_at(values, start, times[inside])
    if angle:
        turn = np.array([angle, 0.0, 0.0])
        feet = 3 + 3 * len(rig.groups)
        for first in (0, *range(feet, channels.shape[1], 3)):
            place = slice(first, first + 3)
            channels[:, place] = planar.apply(turn, channels[:, place])
    root = np.array(motion.root_translation)
    rotations = np.array(motion.local_rotations)
    plain = replace(rig, skeleton=replace(rig.skeleton, offsets=np.asarray(rig.skeleton.offsets)))
    before = root[inside].astype(np.float64), rotations[inside].astype(np.float64)
    ankles, feet_turn = ankles_of(plain, *before)
    moved, turned = changed(
        replace(plain, shares=np.asarray(rig.shares)), *before, channels, ankles, feet_turn
    )
    root[inside], rotations[inside] = moved, turned
    return like(replace(motion, root_translation=root, local_rotations=rotations), motion)


def free_feet(
    planted: Bool[np.ndarray, "T L"], times: Float[np.ndarray, " T"]
) -> Float[np.ndarray, "T L"]:
    """How far feet may be moved: 0 where they stand, and 1 from ``FADE_S`` before and after.

    One frame to either side of a stance counts as standing, so that a foot is at rest also between
    frames.
    """
    free = np.ones(planted.shape)
    for foot in range(planted.shape[1]):
        stands = times[planted[:, foot]]
        if not len(stands):
            continue
        after = np.clip(np.searchsorted(stands, times), 0, len(stands) - 1)
        before = np.maximum(after - 1, 0)
        away = np.minimum(np.abs(times - stands[after]), np.abs(times - stands[before]))
        share = np.clip((away - 1.01 / EXPORT_RATE) / FADE_S, 0.0, 1.0)
        free[:, foot] = share * share * (3 - 2 * share)
    return free


def with_rows(
    motion: Motion, times: Float[np.ndarray, " T"], other: Motion, start: float
) -> Motion:
    """Poses at written frames, those that another motion has from ``start`` on taken from it."""
    rows = np.round((times - start) * EXPORT_RATE).astype(np.int64)
    own = (rows >= 0) & (rows < other.num_frames)
    root = np.array(motion.root_translation)
    rotations = np.array(motion.local_rotations)
    root[own] = other.root_translation[rows[own]]
    rotations[own] = other.local_rotations[rows[own]]
    return like(replace(motion, root_translation=root, local_rotations=rotations), motion)


def places_of(rig: Rig, motion: Motion) -> Float[np.ndarray, "T J 3"]:
    """Places of the joints of a motion, m."""
    skeleton = replace(rig.skeleton, offsets=np.asarray(rig.skeleton.offsets))
    root, rotations = np.asarray(motion.root_translation), np.asarray(motion.local_rotations)
    return np.asarray(forward(skeleton, root, rotations)[0])


def change_of_joints(
    before: Motion,
    after: Motion,
    were: Float[np.ndarray, "T J 3"],
    are: Float[np.ndarray, "T J 3"],
) -> tuple[Float[np.ndarray, " J"], Float[np.ndarray, " J"]]:
    """How far each joint is moved, m, and turned in its parent's frame, degrees, at most.

    Args:
        before, after: the motion.
        were, are: places of its joints, m.
    """
    moved = np.linalg.norm(are - were, axis=-1)
    turned = quaternion.angle_between(before.local_rotations, after.local_rotations)
    return moved.max(axis=0), np.degrees(np.asarray(turned).max(axis=0))
