"""Paths as people write them, on the command line and in files."""

from __future__ import annotations

from pathlib import Path


def user_path(path: str | Path) -> Path:
    """The path with a leading ``~`` or ``~name`` replaced by the home folder of that user.

    A shell does so only where ``~`` begins a word: not in ``--out=~/walk``, and not in a file.
    Where no user has that name the path stays as it is, as in a shell: files may be called so.
    """
    try:
        return Path(path).expanduser()
    except RuntimeError:
        return Path(path)
