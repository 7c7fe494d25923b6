"""Work on whole bodies: forward kinematics of a motion, a motion graph of a clip."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import jax
import numpy as np

from experiments.benchmarks.beside.calls import Calls
from experiments.benchmarks.beside.types import Job
from mgjax.clips import synthetic_clips
from mgjax.core.kinematics import forward
from mgjax.core.motion import cut, resample
from mgjax.graph import GraphConfig, build_graph
from mgjax.io.bvh.write import save_bvh

FK_M = 1e-3
"""Joints farther than this from where they are in double precision would be wrong."""


def kinematics(seed: int, items: int, *, frames: int) -> Job:
    """World positions of all joints in the first frames of the embedded clips."""
    clips, _ = synthetic_clips()
    skeleton = clips[0].skeleton
    turns = np.concatenate([clip.motion.local_rotations for clip in clips])[:frames]
    roots = np.concatenate([clip.motion.root_translation for clip in clips])[:frames]
    turns, roots = np.asarray(turns, np.float32), np.asarray(roots, np.float32)
    right = _right(skeleton, roots, turns)
    compiled = jax.jit(partial(forward, skeleton))

    def call(_: int) -> Any:
        return jax.block_until_ready(compiled(roots, turns)[0])

    def miss(_: int, found: Any) -> float:
        return float(np.abs(np.asarray(found) - right).max())

    data = {
        "rotations": turns.tolist(),
        "roots": roots.tolist(),
        "offsets": np.asarray(skeleton.offsets).tolist(),
        "parents": list(skeleton.parents),
        "right": right.tolist(),
    }
    return Job(data=data, ours=Calls(count=1, call=call, miss=miss), tolerance=FK_M)


def _right(skeleton: Any, roots: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """The positions, joint by joint in double precision. [F, J, 3]"""
    offsets, turns = np.asarray(skeleton.offsets, float), np.asarray(turns, float)
    places, world = [np.asarray(roots, float)], [turns[:, 0]]
    for joint, parent in enumerate(skeleton.parents[1:], start=1):
        w, v = world[parent][:, :1], world[parent][:, 1:]
        aside = np.cross(v, offsets[joint]) + w * offsets[joint]
        places.append(places[parent] + offsets[joint] + 2 * np.cross(v, aside))
        a, b = turns[:, joint, :1], turns[:, joint, 1:]
        scalar = w * a - (v * b).sum(axis=1, keepdims=True)
        world.append(np.concatenate([scalar, w * b + a * v + np.cross(v, b)], axis=1))
    return np.stack(places, axis=1)


def graph(seed: int, items: int, *, frames: int, frame_rate: float = 30.0) -> Job:
    """A motion graph of the beginning of an embedded clip, which the peer reads as BVH."""
    clips, _ = synthetic_clips()
    clip = max(clips, key=lambda each: len(each.motion.root_translation))
    motion = cut(resample(clip.motion, frame_rate), 0, frames)
    with tempfile.TemporaryDirectory() as folder:
        save_bvh(Path(folder, "clip.bvh"), clip.skeleton, motion)
        text = Path(folder, "clip.bvh").read_text(encoding="utf-8")
    config = GraphConfig(frame_rate=frame_rate, threshold_m=0.3)

    def call(_: int) -> Any:
        return build_graph({"clip": (clip.skeleton, motion)}, config=config)

    calls = Calls(count=1, call=call, miss=lambda _, graph: 0.0)
    return Job(data={"bvh": text, "frame_rate": frame_rate}, ours=calls, tolerance=0.0)
