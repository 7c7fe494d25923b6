"""Putting a GLB file together: arrays into its buffer, and all of it into bytes."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from mgjax.core.errors import ConfigError

FLOAT, BYTE, SHORT, WORD = 5126, 5121, 5123, 5125
"""Component types of the format; the integers are unsigned."""
VERTICES, INDICES = 34962, 34963
"""What a buffer view is for."""
_COMPONENTS = {"<f4": FLOAT, "|u1": BYTE, "<u2": SHORT, "<u4": WORD}
_KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


def pygltflib() -> ModuleType:
    """The package that knows the format; :class:`ConfigError` says how to get it."""
    try:
        import pygltflib as package
    except ImportError:
        raise ConfigError(
            "got no pygltflib, with which glTF is written, expected it to be installed:"
            " pip install 'mgjax[export]'"
        ) from None
    return package


class GlbBuilder:
    """Collects arrays in one buffer and everything else in a ``pygltflib.GLTF2``."""

    def __init__(self) -> None:
        self.lib = pygltflib()
        self.gltf = self.lib.GLTF2()
        self.gltf.asset = self.lib.Asset(version="2.0", generator="mgjax")
        self._data = bytearray()

    def add(
        self,
        values: np.ndarray,
        *,
        target: int | None = None,
        bounds: bool = False,
        normalized: bool = False,
    ) -> int:
        """Adds [N,width] numbers; returns the index of their accessor."""
        values = np.ascontiguousarray(values)
        values = values.astype(values.dtype.newbyteorder("<"), copy=False)
        self._data += bytes(-len(self._data) % 4)
        view = self.lib.BufferView(
            buffer=0, byteOffset=len(self._data), byteLength=values.nbytes, target=target
        )
        self._data += values.tobytes()
        self.gltf.bufferViews.append(view)
        accessor = self.lib.Accessor(
            bufferView=len(self.gltf.bufferViews) - 1,
            componentType=_COMPONENTS[values.dtype.str],
            count=len(values),
            type=_KINDS[values.shape[1]],
            normalized=normalized,
        )
        if bounds:
            accessor.min, accessor.max = values.min(axis=0).tolist(), values.max(axis=0).tolist()
        self.gltf.accessors.append(accessor)
        return len(self.gltf.accessors) - 1

    def node(self, **fields: Any) -> int:
        """Adds a node; returns its index."""
        self.gltf.nodes.append(self.lib.Node(**fields))
        return len(self.gltf.nodes) - 1

    def to_bytes(self) -> bytes:
        """The GLB file."""
        self.gltf.buffers = [self.lib.Buffer(byteLength=len(self._data))]
        self.gltf.set_binary_blob(bytes(self._data))
        return b"".join(self.gltf.save_to_bytes())
