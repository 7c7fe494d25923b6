"""GLB files put together byte by byte, as other programs write them."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class Glb:
    """A document that grows; ``data`` is its buffer."""

    def __init__(self) -> None:
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "nodes": [],
            "accessors": [],
            "bufferViews": [],
        }
        self.data = bytearray()

    def view(self, values: np.ndarray, **more: Any) -> int:
        self.data += bytes(-len(self.data) % 4)
        self.json["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes, **more}
        )
        self.data += values.tobytes()
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values: Any, kind: str = "f4", **more: Any) -> int:
        array = np.asarray(values).astype(f"<{kind}")
        array = array[:, None] if array.ndim == 1 else array
        self.json["accessors"].append(
            {
                "bufferView": self.view(array),
                "componentType": CODES[kind],
                "count": len(array),
                "type": KINDS[array.shape[1]],
                **more,
            }
        )
        if array.shape[1] == 1:
            limits = {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
            self.json["accessors"][-1] |= limits
        return len(self.json["accessors"]) - 1

    def node(self, name: str | None, children: list[int] | None = None, **more: Any) -> int:
        node: dict[str, Any] = {k: _listed(v) for k, v in more.items()}
        if name is not None:
            node["name"] = name
        if children:
            node["children"] = children
        self.json["nodes"].append(node)
        return len(self.json["nodes"]) - 1

    def animate(self, *channels: tuple[int, str, int, int, str], **more: Any) -> None:
        """Channels: node, path, input accessor, output accessor, interpolation."""
        self.json.setdefault("animations", []).append(
            {
                "samplers": [
                    {"input": i, "output": o, "interpolation": kind}
                    for _, _, i, o, kind in channels
                ],
                "channels": [
                    {"sampler": s, "target": {"node": node, "path": path}}
                    for s, (node, path, *_) in enumerate(channels)
                ],
                **more,
            }
        )

    def skin(self, joints: list[int], **more: Any) -> None:
        self.json.setdefault("skins", []).append({"joints": joints, **more})

    def scene(self, *roots: int) -> None:
        self.json["scenes"], self.json["scene"] = [{"nodes": list(roots)}], 0

    def bytes(self) -> bytes:
        if self.data:
            self.json["buffers"] = [{"byteLength": len(self.data)}]
        return glb(json.dumps({k: v for k, v in self.json.items() if v != []}), bytes(self.data))


def glb(text: str | bytes, data: bytes = b"") -> bytes:
    """The container around a JSON text."""
    first = text.encode() if isinstance(text, str) else text
    first += b" " * (-len(first) % 4)
    chunks = struct.pack("<I4s", len(first), b"JSON") + first
    if data:
        data += bytes(-len(data) % 4)
        chunks += struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def quaternions(rng: np.random.Generator, *shape: int) -> np.ndarray:
    """Unit, xyzw."""
    q = rng.normal(size=(*shape, 4))
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def _listed(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def armature(seed: int, *, scale: float = 0.01, rate: float = 24.0, frames: int = 20) -> Glb:
    """A chain of bones as Mixamo's files have it: below an armature that is small and lies.

    Bones have rest rotations of any kind; rotations and the hips' place are animated; a mesh hangs
    beside the bones, and a bare node marks the end of the last.
    """
    rng = np.random.default_rng(seed)
    file = Glb()
    names = ["Hips", "Spine", "Head", "LeftUpLeg", "LeftLeg"]
    above = [-1, 0, 1, 0, 3]
    for name in names:
        size = 100.0 if name == "Hips" else 40.0
        place = rng.uniform(-1, 1, 3) * size
        file.node(f"mixamorig:{name}", translation=place, rotation=quaternions(rng))
    end = file.node("mixamorig:HeadTop_End", translation=np.array([0.0, 20.0, 0.0]))
    for node in range(len(names)):
        below = [child for child, parent in enumerate(above) if parent == node]
        below += [end] if names[node] == "Head" else []
        if below:
            file.json["nodes"][node]["children"] = below
    mesh = file.node("Surface")
    lying = [-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
    top = file.node(
        "Armature", [0, mesh], rotation=np.array(lying), scale=np.full(3, scale),
        translation=np.array([0.3, 0.1, -0.2]),
    )  # fmt: skip
    times = file.accessor(np.arange(frames) / rate)
    turns = rng.normal(size=(len(names), frames, 4)).cumsum(axis=1) + 4 * rng.normal(size=4)
    turns /= np.linalg.norm(turns, axis=-1, keepdims=True)
    channels = [
        (node, "rotation", times, file.accessor(turns[node]), "LINEAR")
        for node in range(len(names))
    ]
    moves = rng.normal(size=(frames, 3)).cumsum(axis=0) * 10
    channels.append((0, "translation", times, file.accessor(moves), "LINEAR"))
    file.animate(*channels)
    file.skin([0, 1, 2, 3, 4])
    file.scene(top)
    return file
