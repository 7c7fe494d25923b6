"""Skins that were made before, in this process or in another."""

from __future__ import annotations

import hashlib
from functools import lru_cache

import numpy as np

from mgjax.core.errors import FileFormatError, OutputError
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.compilation import cache_folder
from mgjax.io.skin.welded import WeldedMesh, welded_mesh
from mgjax.io.store import load_arrays, save_arrays

_VERSION = 2
"""Of the way in which skins are made; one more whenever another surface comes out."""
_FIELDS = ("vertices", "normals", "joints", "weights", "triangles")


def skin_of(skeleton: Skeleton) -> WeldedMesh:
    """:func:`~mgjax.io.skin.welded.welded_mesh`, looked up in the user's cache first."""
    offsets = np.ascontiguousarray(skeleton.offsets, dtype=np.float32)
    return _skin(
        skeleton.names, skeleton.parents, skeleton.end_joints, skeleton.roles, offsets.tobytes()
    )


@lru_cache(maxsize=64)
def _skin(
    names: tuple[str, ...],
    parents: tuple[int, ...],
    end_joints: tuple[int, ...],
    roles: tuple[tuple[str, int], ...],
    offsets: bytes,
) -> WeldedMesh:
    key = repr((_VERSION, names, parents, end_joints, roles)).encode() + offsets
    path = cache_folder() / "skins" / f"{hashlib.sha256(key).hexdigest()[:32]}.safetensors"
    if path.is_file():
        try:
            arrays, _ = load_arrays(path, "skin")
            if set(arrays) == set(_FIELDS):
                return WeldedMesh(**arrays)
        except FileFormatError:
            pass  # damaged: it is made anew
    skeleton = Skeleton(
        names=names,
        parents=parents,
        offsets=np.frombuffer(offsets, np.float32).reshape(-1, 3),
        end_joints=end_joints,
        roles=roles,
    )
    mesh = welded_mesh(skeleton)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        save_arrays(path, {name: getattr(mesh, name) for name in _FIELDS}, {})
    except (OSError, OutputError):
        pass  # no place for a cache: the next process makes it again
    return mesh
