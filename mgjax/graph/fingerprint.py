"""A hash by which what was made from a graph is known to be of that graph."""

from __future__ import annotations

import hashlib
from dataclasses import fields

import numpy as np

from mgjax.graph.cache import cached
from mgjax.graph.types import MotionGraph

_KEY = "fingerprint"


def fingerprint(graph: MotionGraph) -> str:
    """A hash of everything of a graph that its motion and search depend on; made once a graph."""
    return cached(graph, _KEY, lambda: _hash(graph))


def remember_fingerprint(graph: MotionGraph, known: str) -> None:
    """Spares the hashing of a graph that was read from a file that names its fingerprint."""
    cached(graph, _KEY, lambda: known)


def _hash(graph: MotionGraph) -> str:
    digest = hashlib.blake2b(digest_size=16)
    digest.update(repr((graph.frame_rate, graph.skeleton.names, graph.skeleton.parents)).encode())
    digest.update(np.asarray(graph.skeleton.offsets).tobytes())
    for field in fields(graph):
        value = getattr(graph, field.name)
        if isinstance(value, np.ndarray):
            digest.update(f"{field.name} {value.dtype} {value.shape}".encode())
            digest.update(np.ascontiguousarray(value).tobytes())
    return digest.hexdigest()
