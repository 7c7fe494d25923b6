"""A motion, alone on the floor."""

from __future__ import annotations

from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.standing import standing
from mgjax.stage.show.types import Actor, Colour, Show


def motion_show(
    skeleton: Skeleton, motion: Motion, *, title: str = "Motion", colour: Colour = "blue"
) -> Show:
    """A body that plays a motion."""
    skeleton, motion = standing(skeleton, motion)
    actor = Actor(id="body", body=0, frames=frames_of(motion), colour=colour)
    return Show(
        title=title,
        seconds=(motion.num_frames - 1) / motion.frame_rate,
        bodies=[body_of(skeleton)],
        actors=[actor],
        notes=[
            ("frames", f"{motion.num_frames} at {motion.frame_rate:g} a second"),
            ("joints", str(skeleton.num_joints)),
        ],
    )
