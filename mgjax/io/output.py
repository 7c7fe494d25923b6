"""Writing results so that nothing half-written is ever left behind."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mgjax.core.errors import OutputError


def replace_file(path: str | Path, data: str | bytes) -> None:
    """Writes a whole file or, on any failure, leaves what was there."""
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        try:
            temporary.write_bytes(data.encode() if isinstance(data, str) else data)
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise _unwritable(path, error) from None


@contextmanager
def output_folder(path: str | Path) -> Iterator[Path]:
    """A folder to write in, whose files appear in ``path`` together, and only on success.

    The folder is made at once, so that one that cannot be written is reported before long work.
    Files already in ``path`` under other names stay.
    """
    path = Path(path)
    made = not path.exists()
    try:
        path.mkdir(parents=True, exist_ok=True)
        stage = Path(tempfile.mkdtemp(prefix=".part-", dir=path))
    except OSError as error:
        raise _unwritable(path, error) from None
    done = False
    try:
        yield stage
        try:
            for item in sorted(stage.iterdir()):
                os.replace(item, path / item.name)
        except OSError as error:
            raise _unwritable(path, error) from None
        done = True
    finally:
        shutil.rmtree(stage, ignore_errors=True)
        if made and not done:
            shutil.rmtree(path, ignore_errors=True)


def _unwritable(path: Path, error: OSError) -> OutputError:
    reason = (error.strerror or str(error)).lower()
    return OutputError(f"{path}: cannot be written ({reason}), expected a writable place")
