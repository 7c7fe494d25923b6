"""Files of finished stages of work, named by what they were made of.

A file is written whole or not at all. What it is called follows from the content of everything
that it depends on, so that it never goes stale: a folder of them may be kept, shared by works that
run at the same time, or deleted.
"""

from __future__ import annotations

import contextlib
import os
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from mgjax.core.errors import FileFormatError, OutputError, printable
from mgjax.io.content_key import content_key
from mgjax.io.output import replace_file
from mgjax.io.store import load_arrays, save_arrays
from mgjax.io.text import reason


class StageStore:
    """A folder of stage files.

    Args:
        folder: is made if it is not there.
        version: of the programs that make the files; a file of another version counts as none.

    Attributes:
        found, made: how many files of each stage were read, and how many written.
        spoiled: files that are damaged or of another version, which are made anew.

    Raises:
        OutputError: nothing can be written there.
    """

    def __init__(self, folder: str | Path, version: str) -> None:
        self.folder = Path(folder)
        self.found: Counter[str] = Counter()
        self.made: Counter[str] = Counter()
        self.spoiled: list[Path] = []
        self._version = version
        self._make(self.folder)
        probe = self.folder / ".writable"
        replace_file(probe, "")
        probe.unlink(missing_ok=True)

    def load(self, stage: str, key: str) -> tuple[dict[str, np.ndarray], dict[str, Any]] | None:
        """Arrays and plain values of a finished stage, or None where there is no whole file."""
        path = self._path(stage, key)
        if not path.is_file():
            return None
        try:
            arrays, plain = load_arrays(path, "stage file")
        except FileFormatError:
            arrays, plain = {}, {}
        if plain.pop("version", None) != self._version or plain.pop("content", None) != content_key(
            arrays
        ):
            self.spoiled.append(path)
            return None
        self.found[stage] += 1
        with contextlib.suppress(OSError):  # removed by another build
            os.utime(path)
        return arrays, plain

    def save(
        self,
        stage: str,
        key: str,
        arrays: dict[str, np.ndarray],
        plain: dict[str, Any] | None = None,
    ) -> None:
        """Keeps a finished stage.

        Args:
            stage: a word, the name of its folder.
            key: names all that the stage depends on.
            arrays: by name.
            plain: JSON values by name, beside ``version`` and ``content``.

        Raises:
            OutputError: the file cannot be written, as where no space is left.
        """
        path = self._path(stage, key)
        self._make(path.parent)
        own = {"version": self._version, "content": content_key(arrays)}
        save_arrays(path, arrays, {**(plain or {}), **own})
        self.made[stage] += 1

    def trim(self, size: int) -> None:
        """Removes the files that were used longest ago until so many bytes are left."""
        files = []
        for path in self.folder.glob("*/*.safetensors"):
            with contextlib.suppress(OSError):
                at = path.stat()
                files.append((at.st_mtime, at.st_size, path))
        left = sum(each[1] for each in files)
        for _, own, path in sorted(files):
            if left <= size:
                return
            path.unlink(missing_ok=True)
            left -= own

    def notes(self) -> list[str]:
        """A line on files that could not be used, if there are any."""
        if not self.spoiled:
            return []
        first, count = printable(self.spoiled[0]), len(self.spoiled)
        more = f" and {count - 1} more stage files" if count > 1 else ""
        return [f"{first}{more}: damaged or of another version, made anew"]

    def _path(self, stage: str, key: str) -> Path:
        return self.folder / stage / f"{key}.safetensors"

    def _make(self, folder: Path) -> None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except (OSError, ValueError) as error:  # ValueError: a null byte
            raise OutputError(
                f"{printable(folder)}: cannot be written ({reason(error)}),"
                " expected a writable folder"
            ) from None
