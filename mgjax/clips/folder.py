"""All clips below a folder."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Collection, Sequence
from fnmatch import fnmatch
from pathlib import Path

import numpy as np
from tqdm import tqdm

from mgjax.clips.clips_toml import ClipsToml, over
from mgjax.clips.types import Clip
from mgjax.core.errors import MgjaxError, MotionError, OutputError
from mgjax.core.motion import Motion
from mgjax.io.load import SUFFIXES
from mgjax.io.npz.read import holds_no_motion
from mgjax.io.read_clip import read_clip
from mgjax.io.reading.read_as import ReadAs
from mgjax.io.stages import StageStore
from mgjax.io.user_path import user_path


def clip_files(folder: Path, exclude: Sequence[str] = ()) -> list[str]:
    """Paths of the motion files in a folder and below, relative to it, in their order.

    Links to folders are followed. A folder that is reached on several ways counts once, under the
    name that it has without links where it has one. An ``.npz`` file with other arrays is none.

    Raises:
        MotionError: there is no such folder, or no clip in it.
    """
    if not folder.is_dir():
        raise MotionError(f"{folder}: got no such folder, expected a folder of clips")
    files = _motion_files(folder)
    names = sorted(p.relative_to(folder).as_posix() for p in files)
    names = [n for n in names if not any(fnmatch(n, pattern) for pattern in exclude)]
    arrays = [n for n in names if n.lower().endswith(".npz")]
    other = {n for n in arrays if holds_no_motion(folder / n)}
    names = [n for n in names if n not in other]
    if not names:
        raise MotionError(f"{folder}: got no clip, expected {' or '.join(SUFFIXES)} files")
    return names


def load_clips(
    folder: str | Path,
    *,
    exclude: Sequence[str] = (),
    progress: bool = False,
    read_as: ReadAs | None = None,
    skip_bad: bool = False,
    need_body: bool = False,
    prefer: Collection[str] = (),
    watch: Callable[[float], None] | None = None,
    store: StageStore | None = None,
) -> tuple[list[Clip], list[str]]:
    """Loads every motion file in ``folder`` and the folders below it, in the order of their paths.

    Args:
        folder: where to look; a ``clips.toml`` in it says how files are to be read.
        exclude: glob patterns on the path relative to ``folder``; matching files are left out.
        progress: shows a bar on stderr.
        read_as: what is known of all files; it counts more than a ``clips.toml``.
        skip_bad: leaves files out that cannot be read, with a note for each.
        need_body: a file without a body, or with one no person has, is bad as well.
        prefer: names that stay, of two clips with identical motion.
        watch: told the share of files that are read; what it raises ends the work.
        store: keeps what was read of each file, by its content.

    Returns:
        The clips, named by relative path with ``/``, and notes on what was found and left out: of
        two clips with identical motion the first stays.

    Raises:
        MotionError: there is no clip, or files are bad: all of them are named.
        OutputError: nothing can be kept in the store.
    """
    folder = user_path(folder)
    names = clip_files(folder, exclude)
    known = ClipsToml(folder)
    clips: list[Clip] = []
    notes: list[str] = []
    said: dict[str, list[str]] = {}
    bad: list[MgjaxError] = []
    order = sorted(names, key=lambda name: name not in prefer)
    bar = tqdm(order, desc="reading", unit="clip", disable=not progress, leave=False)
    for number, name in enumerate(bar):
        if watch is not None:
            watch(number / len(names))
        way = over(known.of(folder / name), read_as or ReadAs())
        try:
            clip = read_clip(folder / name, way, need_body=need_body, store=store)
        except OutputError:  # nothing is wrong with the file
            raise
        except MgjaxError as error:
            bad.append(error)
            continue
        twin = next((c for c in clips if _same_motion(c.motion, clip.motion)), None)
        if twin is not None:
            notes.append(f"{name}: left out, its motion is that of {twin.name}")
            continue
        for note in clip.notes:
            said.setdefault(note, []).append(name)
        clips.append(
            Clip(name=name, skeleton=clip.skeleton, motion=clip.motion, reading=clip.reading)
        )
    place = {name: at for at, name in enumerate(names)}
    clips.sort(key=lambda clip: place[clip.name])
    if bad and not (skip_bad and clips):
        raise all_of(bad, len(names))
    notes += [f"left out: {error}" for error in bad]
    return clips, [*_together(said), *notes]


def all_of(bad: Sequence[MgjaxError], files: int) -> MgjaxError:
    """One error for all bad files: the only one as it is, or all in a row."""
    if len(bad) == 1:
        return bad[0]
    return MotionError(f"{len(bad)} of {files} files: {'; '.join(map(str, bad))}")


def _together(said: dict[str, list[str]]) -> list[str]:
    """Notes that several clips have, once."""
    return [
        f"{names[0]}: {note}" if len(names) == 1 else f"{len(names)} clips: {note}"
        for note, names in said.items()
    ]


def _motion_files(folder: Path) -> list[Path]:
    """All motion files below a folder, each folder looked into once."""
    seen: set[str] = set()
    found: list[Path] = []
    folders, links = [folder], []
    while folders or links:
        here = folders.pop() if folders else links.pop(0)
        real = os.path.realpath(here)
        if real in seen:
            continue
        seen.add(real)
        with contextlib.suppress(PermissionError):
            for path in sorted(here.iterdir()):
                if path.is_dir():
                    (links if path.is_symlink() else folders).append(path)
                elif path.suffix.lower() in SUFFIXES and path.is_file():
                    found.append(path)
    return found


def _same_motion(a: Motion, b: Motion) -> bool:
    """Equal poses up to the rounding of a text file; a converted copy counts as the same."""
    if a.local_rotations.shape != b.local_rotations.shape:
        return False
    if abs(a.frame_rate - b.frame_rate) > 1e-3 * a.frame_rate:  # a frame time has few digits
        return False
    if np.abs(a.root_translation - b.root_translation).max() > 1e-4:
        return False
    cosine = np.abs(np.sum(a.local_rotations * b.local_rotations, axis=-1))
    return bool(cosine.min() > 1 - 1e-5)
