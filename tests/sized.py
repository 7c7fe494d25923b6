"""Bodies and motions so many times as large, at the same times: what all of mgjax must not notice.

A body of another size is given as a skeleton whose offsets are scaled and a motion whose root is;
rotations, frames and labels stay. What a function finds for it must then be what it finds for the
first body: the same frames, edges and choices, lengths and speeds times the factor.

By powers of two numbers are scaled without rounding, so everything is the same to the last bit. By
other factors rounding differs, and decides where two things are as good as each other.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from mgjax.clips.types import Clip
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.graph.types import MotionGraph

SIZES = (0.6, 1.3)
"""Times the embedded body: 0.98 m and 2.1 m, about the smallest and the largest that are built."""

EXACT = (0.5, 2.0)
"""Those by which nothing is rounded: 0.81 m and 3.3 m, which takes a unit that is said."""


def body_of_size(skeleton: Skeleton, size: float) -> Skeleton:
    return replace(skeleton, offsets=_times(skeleton.offsets, size))


def motion_of_size(motion: Motion, size: float) -> Motion:
    return replace(motion, root_translation=_times(motion.root_translation, size))


def clips_of_size(clips: Iterable[Clip], size: float) -> list[Clip]:
    return [
        replace(
            clip,
            skeleton=body_of_size(clip.skeleton, size),
            motion=motion_of_size(clip.motion, size),
        )
        for clip in clips
    ]


def planes_of_size(planes: np.ndarray, size: float) -> np.ndarray:
    """Planar frames (θ, x, z): the turn stays."""
    return (planes * np.array([1.0, size, size])).astype(planes.dtype)


def graph_of_size(graph: MotionGraph, size: float) -> MotionGraph:
    return replace(
        graph,
        skeleton=body_of_size(graph.skeleton, size),
        root_translation=_times(graph.root_translation, size),
        node_plane=planes_of_size(graph.node_plane, size),
        edge_exit=planes_of_size(graph.edge_exit, size),
        edge_distance=_times(graph.edge_distance, size),
    )


def _times(values, size: float) -> np.ndarray:
    values = np.asarray(values)
    return (values * np.float64(size)).astype(values.dtype)
