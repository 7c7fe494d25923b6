"""The clips of a folder, or of memory: their names at once, what is in them one after another."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from glob import escape
from pathlib import Path

import numpy as np
from jaxtyping import Int

from mgjax.clips.clips_toml import ClipsToml
from mgjax.clips.description import describe, description_lines
from mgjax.clips.folder import clip_files, load_clips
from mgjax.clips.oddities import find_oddities
from mgjax.clips.types import Clip
from mgjax.core.errors import MgjaxError, MotionError
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.load import read_capture
from mgjax.io.user_path import user_path
from mgjax.stage.apps.edit.filmstrip import key_poses
from mgjax.stage.apps.edit.table import Extent

KEPT = 16
"""Motions that stay in memory; others are read again when they are looked at."""

Read = Callable[[str], tuple[Clip, tuple[str, ...]]]
"""Reads a clip by its name, with what there is to say of it, a line each."""

Load = Callable[
    [Callable[[float], None], Collection[str], Collection[str]], tuple[list[Clip], list[str]]
]
"""Reads clips for a graph, with notes; gets what is told the share that is read, the names of those
that are left out, and the names that stay, of two clips with identical motion."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Entry:
    """What is known of a clip.

    Attributes:
        name: of the clip.
        extent: how long it is; None where it cannot be read.
        lines: what ``info`` says.
        error: why it cannot be read, or "".
        parents: of its joints. [J]
        strip: joints of a few poses, seen from the front, as thousandths of the body. [K,J,2]
    """

    name: str
    extent: Extent | None
    lines: tuple[str, ...] = ()
    error: str = ""
    parents: Int[np.ndarray, " J"] | None = None
    strip: Int[np.ndarray, "K J 2"] | None = None


class Library:
    """Clips by name. What a page asks for is looked up here and is never a path.

    Args:
        names: of all clips.
        read: reads one.
        load: reads all for a graph.
        folder: where they lie, or None.
    """

    def __init__(
        self,
        names: Sequence[str],
        read: Read,
        load: Load,
        folder: Path | None = None,
    ) -> None:
        self.names = tuple(names)
        self.load = load
        self.folder = folder
        self._read = read
        self._entries: dict[str, Entry] = {}
        self._new: list[str] = []
        self._motions: OrderedDict[str, tuple[Skeleton, Motion]] = OrderedDict()
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._read_all, name="reading", daemon=True)

    def start(self) -> None:
        """Reads all clips in a thread."""
        self._thread.start()

    def close(self) -> None:
        """Ends the thread after the clip that it reads."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join()
        self._motions.clear()

    def check(self, name: str) -> str:
        """The name itself; :class:`MotionError` where no clip is called so."""
        if name not in self.names:
            raise MotionError(got=f"a clip {name!r:.60}", expected="one of the list")
        return name

    def entries(self) -> list[Entry]:
        """What is known so far, in the order of the names."""
        with self._lock:
            return [self._entries[name] for name in self.names if name in self._entries]

    def take_new(self) -> list[Entry]:
        """What has become known since this was called last."""
        with self._lock:
            names, self._new = self._new, []
            return [self._entries[name] for name in names]

    def entry(self, name: str) -> Entry:
        """What is known of a clip, which is read now if it has not been yet."""
        self.check(name)
        with self._lock:
            known = self._entries.get(name)
        return known or self._learn(name)

    def extent(self, name: str) -> Extent:
        """How long a clip is; :class:`MotionError` where it cannot be read."""
        entry = self.entry(name)
        if entry.extent is None:
            raise MotionError(entry.error)
        return entry.extent

    def motion(self, name: str) -> tuple[Skeleton, Motion]:
        """A clip's skeleton and motion; :class:`MgjaxError` where it cannot be read."""
        self.check(name)
        with self._lock:
            if name in self._motions:
                self._motions.move_to_end(name)
                return self._motions[name]
        clip, _ = self._read(name)
        found = clip.skeleton, clip.motion
        with self._lock:
            self._motions[name] = found
            while len(self._motions) > KEPT:
                self._motions.popitem(last=False)
        return found

    def _read_all(self) -> None:
        for name in self.names:
            if self._stop.is_set():
                return
            with self._lock:
                known = name in self._entries
            if not known:
                self._learn(name)

    def _learn(self, name: str) -> Entry:
        try:
            clip, lines = self._read(name)
            extent = Extent(frames=clip.motion.num_frames, rate=float(clip.motion.frame_rate))
            parents = np.array(clip.skeleton.parents, np.int16)
            strip = key_poses(clip.skeleton, clip.motion)
            entry = Entry(name=name, extent=extent, lines=lines, parents=parents, strip=strip)
        except MgjaxError as error:
            entry = Entry(name=name, extent=None, error=str(error))
        with self._lock:
            if name not in self._entries:
                self._entries[name] = entry
                self._new.append(name)
            return self._entries[name]


def folder_library(folder: str | Path) -> Library:
    """The motion files in a folder and below.

    Raises:
        MotionError: there is none.
        MgjaxError: a ``clips.toml`` that cannot be read.
    """
    place = user_path(folder)
    names = clip_files(place)
    toml = ClipsToml(place)

    def read(name: str) -> tuple[Clip, tuple[str, ...]]:
        capture = read_capture(place / name, toml.of(place / name))
        first, *rest = description_lines(describe(Path(name), capture))
        lines = (first.removeprefix(f"{name}: "), *(line.strip() for line in rest))
        return Clip(name=name, skeleton=capture.skeleton, motion=capture.motion), lines

    def load(
        watch: Callable[[float], None], without: Collection[str], prefer: Collection[str]
    ) -> tuple[list[Clip], list[str]]:
        exclude = [escape(name) for name in sorted(without)]
        return load_clips(
            place, exclude=exclude, skip_bad=True, need_body=True, prefer=prefer, watch=watch
        )

    return Library(names, read, load, place)


def memory_library(clips: Sequence[Clip]) -> Library:
    """Clips that are not in files."""
    by_name = {clip.name: clip for clip in clips}

    def read(name: str) -> tuple[Clip, tuple[str, ...]]:
        clip = by_name[name]
        motion = clip.motion
        first = (
            f"{clip.skeleton.num_joints} joints, {motion.num_frames} frames at"
            f" {motion.frame_rate:g} fps = {motion.seconds:.2f} s"
        )
        return clip, (first, *(o.text for o in find_oddities(clip.skeleton, motion)))

    def load(
        watch: Callable[[float], None], without: Collection[str], prefer: Collection[str]
    ) -> tuple[list[Clip], list[str]]:
        return [clip for clip in clips if clip.name not in without], []

    return Library(list(by_name), read, load)
