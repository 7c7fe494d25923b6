"""A named clip, and an interval of it that carries a label."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, cast

from mgjax.core.errors import MotionError
from mgjax.core.motion import Motion
from mgjax.core.shown import Shown, made_of, origin_of
from mgjax.core.skeleton import Skeleton


@dataclass(frozen=True, kw_only=True)
class Clip(Shown):
    """One captured (or made) motion with the name by which labels and reports know it.

    Attributes:
        name: unique among the clips of a graph.
        skeleton, motion: what is moved, and how.
        reading: how the file was read, ready for JSON; empty for a motion from elsewhere.
    """

    name: str
    skeleton: Skeleton
    motion: Motion
    reading: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if origin_of(self.motion) is None:
            made_of(self.motion, self.skeleton)


@dataclass(frozen=True, kw_only=True)
class Label:
    """A labelled interval of a clip, in seconds from its first frame; half-open.

    Attributes:
        start_s, end_s: the interval; in frames of rate f it is round(start·f) … round(end·f) − 1.
        kind: what is done, such as ``"duck"``.
        direction: to which side of the character: ``"left"``, ``"right"`` or ``""``.
        genuine: a real evasion; False for an exercise that resembles one.
    """

    start_s: float
    end_s: float
    kind: str
    direction: str = ""
    genuine: bool = True


Labels = Mapping[str, tuple[Label, ...]]
"""Labels by clip name."""

ClipLike = Clip | tuple[Skeleton, Motion]


def as_clips(clips: Mapping[str, tuple[Skeleton, Motion]] | Iterable[ClipLike]) -> list[Clip]:
    """Clips from :class:`Clip` objects, (skeleton, motion) pairs or a mapping of names to pairs.

    Pairs without a name are called ``clip0``, ``clip1``, …; names must be unique.
    """
    if isinstance(clips, Mapping):
        pairs = cast(Mapping[str, tuple[Skeleton, Motion]], clips)
        result = [Clip(name=n, skeleton=s, motion=m) for n, (s, m) in pairs.items()]
    else:
        result = []
        for number, item in enumerate(clips):
            if not isinstance(item, Clip):
                item = Clip(name=f"clip{number}", skeleton=item[0], motion=item[1])
            result.append(item)
    names = [clip.name for clip in result]
    for name in names:
        if names.count(name) > 1:
            raise MotionError(f"two clips are called {name!r}, expected unique names")
    return result


def mirrored_direction(direction: str) -> str:
    """The direction seen in a mirror: left and right change places."""
    return {"left": "right", "right": "left"}.get(direction, direction)
