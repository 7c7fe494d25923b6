"""Clips as a graph needs them: bones of fixed length, and a rest pose that stands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.clips.types import Clip
from mgjax.core.body.rest import standing_rest
from mgjax.core.errors import MotionError
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton

SLIDE_M = 0.03
"""A joint that moves by less in its parent's frame (a shoulder that slides) is held still."""


def standing_clip(clip: Clip, notes: list[str]) -> Clip:
    """The clip with rigid bones and a standing rest pose; notes say what was changed.

    Raises:
        MotionError: a joint moves too far in its parent's frame for a bone; it is named.
    """
    skeleton, motion = rigid(clip.skeleton, clip.motion, clip.name, notes)
    rest = standing_rest(skeleton)
    if rest is not None:
        skeleton, motion = rest.skeleton, rest.motion(motion)
    return replace(clip, skeleton=skeleton, motion=motion)


def rigid(
    skeleton: Skeleton, motion: Motion, name: str, notes: list[str]
) -> tuple[Skeleton, Motion]:
    """Holds joints that slide a little in their parent's frame at the middle of where they are."""
    if motion.joint_offsets is None:
        return skeleton, motion
    places = np.asarray(motion.joint_offsets, dtype=np.float64)
    middle = np.median(places, axis=0)
    slides = np.linalg.norm(places - middle, axis=-1).max(axis=0)
    slides[0] = 0.0  # the root's place in the world is no bone
    farthest = int(np.argmax(slides))
    if slides[farthest] > SLIDE_M:
        raise MotionError(
            got=f"{skeleton.names[farthest]!r} moving by up to {slides[farthest]:.2f} m in its"
            " parent's frame",
            expected=f"bones, which are rigid, or joints that slide by at most {SLIDE_M:g} m",
            place=name,
        )
    notes.append(
        f"{name}: {int((slides > 0).sum())} joints slide in their parent's frame by up to"
        f" {100 * slides[farthest]:.1f} cm and were held still"
    )
    middle[0] = np.asarray(skeleton.offsets)[0]
    skeleton = replace(skeleton, offsets=middle.astype(np.float32))
    return skeleton, replace(motion, joint_offsets=None)
