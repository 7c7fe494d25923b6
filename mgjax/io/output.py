"""Writing results so that nothing half-written is ever left behind."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mgjax.core.errors import OutputError, printable
from mgjax.io.text import reason


def replace_file(path: str | Path, data: str | bytes) -> None:
    """Writes a whole file or, on any failure, leaves what was there."""
    path = Path(path)
    try:
        temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
        try:
            temporary.write_bytes(data.encode() if isinstance(data, str) else data)
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)
    except (OSError, ValueError) as error:  # ValueError: no name, a null byte
        raise _unwritable(path, error) from None


@contextmanager
def output_folder(path: str | Path) -> Iterator[Path]:
    """A folder to write in, whose files appear in ``path`` together, and only on success.

    The folder is made at once, so that one that cannot be written is reported before long work.
    Files already in ``path`` under other names stay.
    """
    path = Path(path)
    try:
        made = [folder for folder in (path, *path.parents) if not folder.exists()]
        path.mkdir(parents=True, exist_ok=True)
        stage = Path(tempfile.mkdtemp(prefix=".part-", dir=path))
    except (OSError, ValueError) as error:
        raise _unwritable(path, error) from None
    done = False
    try:
        yield stage
        try:
            items = sorted(stage.iterdir())
            for item in items:  # before the first is put in its place
                if (path / item.name).is_dir():
                    raise IsADirectoryError(f"{item.name} is a folder")
            for item in items:
                os.replace(item, path / item.name)
        except OSError as error:
            raise _unwritable(path, error) from None
        done = True
    finally:
        shutil.rmtree(stage, ignore_errors=True)
        if not done:
            _remove_empty(made)


def _remove_empty(folders: list[Path]) -> None:
    """Removes folders, the deepest first, as far as nobody else has put something there."""
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return


def _unwritable(path: Path, error: Exception) -> OutputError:
    why = reason(error)
    return OutputError(f"{printable(path)}: cannot be written ({why}), expected a writable place")
