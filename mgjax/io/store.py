"""Named arrays and JSON in one safetensors file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from mgjax.core.errors import FileFormatError
from mgjax.io.output import replace_file


def save_arrays(path: str | Path, arrays: dict[str, np.ndarray], metadata: dict[str, Any]) -> None:
    """Writes arrays and metadata; whole or not at all."""
    flat = {name: np.ascontiguousarray(value) for name, value in arrays.items()}
    text = {key: json.dumps(value) for key, value in metadata.items()}
    replace_file(path, save(flat, metadata=text))


def load_arrays(path: str | Path, kind: str) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Reads what :func:`save_arrays` wrote; :class:`FileFormatError` if it is something else."""
    if not Path(path).is_file():
        raise FileFormatError(path, None, "no such file", f"a {kind}")
    try:
        with safe_open(str(path), framework="numpy") as file:
            metadata = {k: json.loads(v) for k, v in (file.metadata() or {}).items()}
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    except (SafetensorError, OSError, ValueError) as error:
        reason = str(error).splitlines()[0][:80]
        raise FileFormatError(
            path, None, f"a file that is damaged ({reason})", f"a {kind}"
        ) from None
    return arrays, metadata
