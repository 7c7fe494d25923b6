"""Labelled intervals that are edited: snapped to frames, never overlapping, with undo."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any

from mgjax.clips.types import Label
from mgjax.core.errors import ConfigError

MOST_UNDO = 1000
DIGITS = 6
"""Seconds are written with so many decimals, where that still means the same frame."""


@dataclass(frozen=True, kw_only=True)
class Extent:
    """How long a clip is: labels lie in frames 0 … ``frames``, the last one not included."""

    frames: int
    rate: float

    def frame(self, seconds: float) -> int:
        """The frame of a time, as the builder of graphs counts."""
        return round(seconds * self.rate)

    def seconds(self, frame: int) -> float:
        """A time that means that frame, with few decimals."""
        short = round(frame / self.rate, DIGITS)
        return short if self.frame(short) == frame else frame / self.rate


@dataclass(frozen=True, kw_only=True)
class Interval:
    """A label, and where it came from.

    Attributes:
        id: names it while it is edited.
        label: as it is now.
        key: the clip's name in the labels file, or "" for one made here.
        raw: what stands in the file, or None.
    """

    id: int
    label: Label
    key: str = ""
    raw: Mapping[str, Any] | None = field(default=None, compare=False)


Intervals = tuple[Interval, ...]


@dataclass(frozen=True, kw_only=True)
class _Step:
    clip: str
    before: Intervals
    after: Intervals


class LabelTable:
    """The intervals of all clips, and what was done to them."""

    def __init__(self, intervals: Mapping[str, Intervals] | None = None) -> None:
        self._now: dict[str, Intervals] = {k: v for k, v in (intervals or {}).items() if v}
        self._saved = dict(self._now)
        self._done: list[_Step] = []
        self._undone: list[_Step] = []
        first = max((i.id for items in self._now.values() for i in items), default=-1) + 1
        self._ids = count(first)

    def of(self, clip: str) -> Intervals:
        """The intervals of a clip, in the order in which they stand in the file."""
        return self._now.get(clip, ())

    def clips(self) -> list[str]:
        """The clips that have labels."""
        return list(self._now)

    def labels(self) -> dict[str, tuple[Label, ...]]:
        """What a graph is built with."""
        return {name: tuple(i.label for i in items) for name, items in self._now.items()}

    @property
    def changed(self) -> bool:
        """Whether there is something that is not saved."""
        return self._now != self._saved

    @property
    def can_undo(self) -> bool:
        return bool(self._done)

    @property
    def can_redo(self) -> bool:
        return bool(self._undone)

    def mark_saved(self) -> None:
        """What is there now is in the file."""
        self._saved = dict(self._now)

    def add(
        self,
        clip: str,
        extent: Extent,
        start: int,
        stop: int,
        *,
        kind: str,
        direction: str = "",
        genuine: bool = True,
    ) -> Interval:
        """Makes a label of frames ``start … stop − 1``.

        Raises:
            ConfigError: it has no frame, or lies outside the clip or over another label.
        """
        items = self.of(clip)
        check_place(items, extent, start, stop)
        label = Label(
            start_s=extent.seconds(start),
            end_s=extent.seconds(stop),
            kind=kind,
            direction=direction,
            genuine=genuine,
        )
        made = Interval(id=next(self._ids), label=label)
        at = next((n for n, i in enumerate(items) if i.label.start_s > label.start_s), len(items))
        self._do(clip, (*items[:at], made, *items[at:]))
        return made

    def change(
        self,
        clip: str,
        extent: Extent,
        number: int,
        *,
        start: int | None = None,
        stop: int | None = None,
        **what: Any,
    ) -> Interval:
        """Moves a label, or makes it another: ``kind``, ``direction``, ``genuine``.

        What is not given, and an end that stays in its frame, is left exactly as it was.

        Raises:
            ConfigError: no such label, or it would lie where it cannot.
        """
        items = self.of(clip)
        old = self._find(clip, number)
        was = extent.frame(old.label.start_s), extent.frame(old.label.end_s)
        now = was[0] if start is None else start, was[1] if stop is None else stop
        if now != was:
            check_place([i for i in items if i.id != number], extent, *now)
        if now[0] != was[0]:
            what["start_s"] = extent.seconds(now[0])
        if now[1] != was[1]:
            what["end_s"] = extent.seconds(now[1])
        new = replace(old, label=replace(old.label, **what))
        if new != old:
            self._do(clip, tuple(new if i.id == number else i for i in items))
        return new

    def delete(self, clip: str, number: int) -> None:
        """Takes a label away; :class:`ConfigError` where there is none."""
        self._find(clip, number)
        self._do(clip, tuple(i for i in self.of(clip) if i.id != number))

    def undo(self) -> str:
        """Takes the last step back; returns its clip."""
        if not self._done:
            raise ConfigError(got="undo", expected="a step that can be undone")
        step = self._done.pop()
        self._undone.append(step)
        self._put(step.clip, step.before)
        return step.clip

    def redo(self) -> str:
        """Does again what was undone; returns its clip."""
        if not self._undone:
            raise ConfigError(got="redo", expected="a step that was undone")
        step = self._undone.pop()
        self._done.append(step)
        self._put(step.clip, step.after)
        return step.clip

    def _find(self, clip: str, number: int) -> Interval:
        for item in self.of(clip):
            if item.id == number:
                return item
        raise ConfigError(got=f"label {number} of {clip!r:.60}", expected="one that is there")

    def _do(self, clip: str, after: Intervals) -> None:
        self._done.append(_Step(clip=clip, before=self.of(clip), after=after))
        del self._done[:-MOST_UNDO]
        self._undone.clear()
        self._put(clip, after)

    def _put(self, clip: str, items: Intervals) -> None:
        if items:
            self._now[clip] = items
        else:
            self._now.pop(clip, None)


def check_place(others: Iterable[Interval], extent: Extent, start: int, stop: int) -> None:
    """Raises :class:`ConfigError` unless frames ``start … stop − 1`` are there and free."""
    text = f"{start / extent.rate:.2f} … {stop / extent.rate:.2f} s"
    if start < 0 or stop > extent.frames:
        end = extent.frames / extent.rate
        raise ConfigError(got=f"a label {text} outside the clip", expected=f"0 … {end:.2f} s")
    if stop <= start:
        raise ConfigError(got=f"a label {text} without a frame", expected="an end after its start")
    for other in others:
        label = other.label
        if start < extent.frame(label.end_s) and extent.frame(label.start_s) < stop:
            raise ConfigError(
                got=f"a label {text} that overlaps {label.kind} {label.start_s:.2f} …"
                f" {label.end_s:.2f} s",
                expected="labels that at most touch",
            )
