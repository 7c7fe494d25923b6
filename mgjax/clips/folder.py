"""All clips below a folder."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from fnmatch import fnmatch
from pathlib import Path

import numpy as np
from tqdm import tqdm

from mgjax.clips.types import Clip
from mgjax.core.errors import MotionError
from mgjax.core.motion import Motion
from mgjax.io.load import SUFFIXES, load_motion
from mgjax.io.user_path import user_path


def load_clips(
    folder: str | Path, *, exclude: Sequence[str] = (), progress: bool = False
) -> tuple[list[Clip], list[str]]:
    """Loads every motion file in ``folder`` and the folders below it, in the order of their paths.

    Links to folders are followed. A folder that is reached on several ways counts once, under the
    name that it has without links where it has one.

    Args:
        folder: where to look.
        exclude: glob patterns on the path relative to ``folder``; matching files are left out.
        progress: shows a bar on stderr.

    Returns:
        The clips, named by relative path with ``/``, and notes on what was left out: of two clips
        with identical motion the first stays.

    Raises:
        MotionError: there is no clip.
        FileFormatError: a file cannot be read.
    """
    folder = user_path(folder)
    if not folder.is_dir():
        raise MotionError(f"{folder}: got no such folder, expected a folder of clips")
    files = _motion_files(folder)
    names = sorted(p.relative_to(folder).as_posix() for p in files)
    names = [n for n in names if not any(fnmatch(n, pattern) for pattern in exclude)]
    if not names:
        raise MotionError(f"{folder}: got no clip, expected {' or '.join(SUFFIXES)} files")
    clips: list[Clip] = []
    notes: list[str] = []
    for name in tqdm(names, desc="reading", unit="clip", disable=not progress, leave=False):
        skeleton, motion = load_motion(folder / name)
        twin = next((c for c in clips if _same_motion(c.motion, motion)), None)
        if twin is not None:
            notes.append(f"{name}: left out, its motion is that of {twin.name}")
            continue
        clips.append(Clip(name=name, skeleton=skeleton, motion=motion))
    return clips, notes


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
