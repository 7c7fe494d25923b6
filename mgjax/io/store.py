"""Named arrays and JSON in one safetensors file."""

from __future__ import annotations

import json
import math
import mmap
from pathlib import Path
from typing import Any

import numpy as np
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from mgjax.core.errors import FileFormatError
from mgjax.io.output import replace_file

_DTYPES = {
    **{f"U{bits}": np.dtype(f"<u{bits // 8}") for bits in (8, 16, 32, 64)},
    **{f"I{bits}": np.dtype(f"<i{bits // 8}") for bits in (8, 16, 32, 64)},
    **{f"F{bits}": np.dtype(f"<f{bits // 8}") for bits in (16, 32, 64)},
    "BOOL": np.dtype(bool),
}
"""Of the file format's names."""


def save_arrays(path: str | Path, arrays: dict[str, np.ndarray], metadata: dict[str, Any]) -> None:
    """Writes arrays and metadata; whole or not at all."""
    flat = {name: np.ascontiguousarray(value) for name, value in arrays.items()}
    text = {key: json.dumps(value) for key, value in metadata.items()}
    replace_file(path, save(flat, metadata=text))


def load_arrays(path: str | Path, kind: str) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Reads what :func:`save_arrays` wrote; :class:`FileFormatError` if it is something else."""
    arrays, metadata = map_arrays(path, kind)
    return {name: array.copy() for name, array in arrays.items()}, metadata


def map_arrays(path: str | Path, kind: str) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The same, but the arrays are read-only views of the file: what is not used is not read."""
    if not Path(path).is_file():
        raise FileFormatError(path, None, "no such file", f"a {kind}")
    try:
        with safe_open(str(path), framework="numpy") as file:  # checks sizes and places
            metadata = {k: json.loads(v) for k, v in (file.metadata() or {}).items()}
        return _views(Path(path)), metadata
    except (SafetensorError, OSError, ValueError, KeyError) as error:
        reason = str(error).splitlines()[0][:80]
        raise FileFormatError(
            path, None, f"a file that is damaged ({reason})", f"a {kind}"
        ) from None


def _views(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a file: 8 bytes with the size of a header in JSON, which says where each is."""
    with path.open("rb") as file:
        mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    begin = 8 + int.from_bytes(mapped[:8], "little")
    header = json.loads(mapped[8:begin])
    header.pop("__metadata__", None)
    views: dict[str, np.ndarray] = {}
    for name, entry in header.items():
        count, dtype = math.prod(entry["shape"]), _DTYPES[entry["dtype"]]
        offset = begin + entry["data_offsets"][0]
        flat = np.frombuffer(mapped, dtype, count, offset) if count else np.zeros(0, dtype)
        views[name] = flat.reshape(entry["shape"])
    return views
