"""Reading GLB files: the skeleton of a skin, or of animated nodes, and what moves it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mgjax.core.skeleton import MAX_OFFSET_M
from mgjax.io.gltf.animation import Tracks, animated_nodes, key_rate, read_tracks
from mgjax.io.gltf.document import Document, read_document
from mgjax.io.gltf.nodes import Node, ancestors, read_nodes, skeleton_nodes, unique_names
from mgjax.io.gltf.pose import Poses, convert
from mgjax.io.reading.raw import RawMotion
from mgjax.io.reading.units import UNITS
from mgjax.io.text import check_size

DEFAULT_RATE = 30.0
"""Frames per second where keys do not lie on a grid of their own."""

_STILL_M = 1e-5
"""A joint that moves by less in its parent's frame is rigid: programs write back such noise."""


def read_glb(path: str | Path, *, frame_rate: float | None = None) -> RawMotion:
    """Reads the skeleton and the first animation that moves it; joints come to lie where any
    glTF viewer shows them.

    Nodes above the skeleton's root (such as an armature that is scaled by 0.01 and lies on its
    back) are folded into the root, with their scale. The rest pose is that of the file's nodes.
    Frame 0 is at 0 s. A leaf that the animation does not turn is an end joint. Without an
    animation there is one frame, the rest pose. Meshes and materials are not read.

    Args:
        path: the file. Units are metres, y is up, as glTF 2.0 has it.
        frame_rate: frames per second to sample at; default: the spacing of the keys where all lie
            on one grid of 20 … 1000 per second, else 30.

    Raises:
        FileFormatError: the file is damaged, has no skeleton, or data that cannot be read.
    """
    document = read_document(path)
    nodes = read_nodes(document)
    moved = animated_nodes(document)
    order = skeleton_nodes(document, nodes, moved[0] if moved else set())
    above_root = ancestors(document, nodes, order[0])[:-1]
    used = {*order, *above_root}
    tracks, stated = _animation(document, moved, used)
    rate = frame_rate or _rate(tracks, stated)
    end = max((float(track.times[-1]) for track in tracks.values()), default=0.0)
    check_size(path, int(min(end * rate, 1e12)) + 1, len(order))
    count = int(np.floor(end * rate * (1 + 4 * float(np.finfo(np.float32).eps)) + 1e-3)) + 1
    poses = convert(nodes, above_root, order, tracks, np.arange(count) / rate)
    if not all(np.isfinite(values).all() for values in vars(poses).values()):
        document.refuse("transforms that are not finite", "places that can be told")
    return _raw(document, nodes, order, tracks, poses, rate)


def _animation(
    document: Document, moved: list[set[int]], used: set[int]
) -> tuple[Tracks, float | None]:
    """Tracks of the first animation that moves one of these nodes, and the rate it says it has."""
    animations = document.objects(document.json, "animations")
    for item, moves in zip(animations, moved, strict=True):
        if moves & used:
            extras = item.get("extras")
            stated = extras.get("frame_rate") if isinstance(extras, dict) else None
            fits = isinstance(stated, float) and 0 < stated <= 10000
            return read_tracks(document, item, used), stated if fits else None
    return {}, None


def _rate(tracks: Tracks, stated: float | None) -> float:
    return (key_rate(list(tracks.values()), stated) if tracks else stated) or DEFAULT_RATE


def _raw(
    document: Document,
    nodes: list[Node],
    order: list[int],
    tracks: Tracks,
    poses: Poses,
    rate: float,
) -> RawMotion:
    slot = {node: joint for joint, node in enumerate(order)}
    parents = tuple(-1 if j == 0 else slot[nodes[node].parent] for j, node in enumerate(order))
    leaves = set(range(len(order))) - set(parents)
    ends = tuple(
        joint
        for joint, node in enumerate(order)
        if nodes[node].is_end or (tracks and joint in leaves and (node, "rotation") not in tracks)
    )
    rigid = bool((np.ptp(poses.offsets[:, 1:], axis=0) <= _STILL_M).all())
    offsets, moving = poses.rest_offsets.copy(), poses.offsets.copy()
    if rigid:  # keys that never move a joint are just another way to write its offset
        offsets[1:] = poses.offsets[0, 1:]
    if np.abs(offsets[0]).max() > MAX_OFFSET_M:
        offsets[0] = 0  # where the rest pose stands in the world says nothing of the body
    moving[:, 0] = offsets[0]
    return RawMotion(
        path=document.path,
        names=unique_names(nodes, order),
        parents=parents,
        end_joints=ends if len(order) > 1 else (),
        offsets=offsets,
        lines=(0,) * len(order),
        root=poses.root,
        rotations=poses.rotations,
        moving=None if rigid else moving,
        frame_rate=float(rate),
        unit=UNITS["m"],
        settled=True,
    )
