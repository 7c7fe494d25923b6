"""The arrays of an .npz file, whatever stands in them; pickled objects are never loaded."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mgjax.core.errors import FileFormatError
from mgjax.io.text import quoted, reason

MAX_ARRAY_BYTES = 4_000_000_000
"""No array of a motion or of a body model is larger; such a header is broken."""

_LARGEST = 1e30
"""What is larger is as good as infinite, and would be so as float32."""

_DAMAGED = (ValueError, EOFError, zipfile.BadZipFile, zlib.error, NotImplementedError, KeyError)
"""What zipfile and numpy raise on archives that are not whole."""


def array_names(path: str | Path, kind: str) -> frozenset[str]:
    """Names of the arrays in a file; :class:`FileFormatError` if it is no .npz archive."""
    try:
        with zipfile.ZipFile(path) as file:
            return frozenset(n[:-4] for n in file.namelist() if n.endswith(".npy"))
    except OSError as error:
        raise FileFormatError(path, None, reason(error), f"a readable {kind}") from None
    except _DAMAGED as error:
        got = f"no .npz archive ({_first_line(error)})"
        raise FileFormatError(path, None, got, f"a {kind}") from None


def read_arrays(path: str | Path, names: Sequence[str], kind: str) -> dict[str, np.ndarray]:
    """The named arrays that are in a file.

    Raises:
        FileFormatError: one is damaged, holds pickled objects or claims to be too large.
    """
    present = array_names(path, kind)
    arrays: dict[str, np.ndarray] = {}
    for name in (n for n in names if n in present):
        try:
            with zipfile.ZipFile(path) as file:
                size = file.getinfo(f"{name}.npy").file_size
                if size > MAX_ARRAY_BYTES:
                    got = f"an array {quoted(name)} of {size} bytes"
                    raise FileFormatError(path, None, got, f"at most {MAX_ARRAY_BYTES:.0e}")
            with np.load(path, allow_pickle=False) as file:
                arrays[name] = file[name]
        except OSError as error:
            raise FileFormatError(path, None, reason(error), f"a readable {kind}") from None
        except FileFormatError:
            raise
        except _DAMAGED as error:
            got = f"an array {quoted(name)} that cannot be read ({_first_line(error)})"
            expected = f"a {kind} of plain arrays, without pickled objects"
            raise FileFormatError(path, None, got, expected) from None
    return arrays


def numbers(
    path: str | Path, arrays: dict[str, np.ndarray], name: str, shape: tuple[int | str, ...]
) -> np.ndarray:
    """One of the arrays as float64, its shape and finiteness checked.

    Args:
        path: of the file, for messages.
        arrays: of the file.
        name: which of them.
        shape: expected; a text stands for any size.

    Raises:
        FileFormatError: it is missing, has another shape or type, or is not finite.
    """
    form = "[" + ",".join(str(size) for size in shape) + "]"
    if name not in arrays:
        raise FileFormatError(path, None, f"no array {name!r}", f"numbers of shape {form}")
    array = arrays[name]
    fits = len(array.shape) == len(shape) and all(
        isinstance(wanted, str) or size == wanted
        for size, wanted in zip(array.shape, shape, strict=True)
    )
    if not fits or array.dtype.kind not in "fiu":
        got = f"{name!r} of shape {list(array.shape)} and type {array.dtype}"
        raise FileFormatError(path, None, got, f"numbers of shape {form}")
    values = array.astype(np.float64)
    if not (np.abs(values) <= _LARGEST).all():
        raise FileFormatError(path, None, f"{name!r} with NaN or infinity", "finite numbers")
    return values


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:80]
