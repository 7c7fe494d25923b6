"""The show of whatever can be shown."""

from __future__ import annotations

from typing import Any

from mgjax.core.errors import MgjaxError
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.stage.show.motion import motion_show
from mgjax.stage.show.types import Show


def show_of(thing: Any) -> Show:
    """The show of a thing; :class:`MgjaxError` says what can be shown where it is none."""
    if isinstance(thing, Show):
        return thing
    if isinstance(thing, tuple) and len(thing) == 2:
        skeleton, motion = thing
        if isinstance(skeleton, Skeleton) and isinstance(motion, Motion):
            return motion_show(skeleton, motion)
    raise MgjaxError(got=f"a {type(thing).__name__}", expected="something that can be shown")
