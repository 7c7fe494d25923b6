"""Shows for tests: characters of the procedural set."""

from __future__ import annotations

from functools import cache

import numpy as np

from mgjax.clips.synthetic import synthetic_clips
from mgjax.clips.types import Clip
from mgjax.core.motion import Motion
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Show


@cache
def clips() -> dict[str, Clip]:
    return {clip.name: clip for clip in synthetic_clips()[0]}


def moved(motion: Motion, x: float, z: float) -> Motion:
    shift = np.array([x, 0, z], np.float32)
    return Motion(
        root_translation=np.asarray(motion.root_translation) + shift,
        local_rotations=motion.local_rotations,
        frame_rate=motion.frame_rate,
    )


def actor(name: str, *, id: str = "a", at: tuple[float, float] = (0, 0), **settings) -> Actor:
    return Actor(id=id, body=0, frames=frames_of(moved(clips()[name].motion, *at)), **settings)


def show_of(*actors: Actor, **settings) -> Show:
    """A show of actors who are all of the procedural set."""
    body = body_of(next(iter(clips().values())).skeleton)
    return Show(title="Test", **{"seconds": 4.0, "bodies": [body], "actors": actors, **settings})
