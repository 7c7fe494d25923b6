"""What is played of a walk: the poses of its edges, with feet that stand where they are put."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Bool, Float, Int

from mgjax.core.arrays import Array
from mgjax.core.errors import SkeletonError
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.shown import like
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.exported import exported
from mgjax.core.xla.padding import bucket_size
from mgjax.graph.cache import cached
from mgjax.graph.feet.contacts import standing_points
from mgjax.graph.feet.course import FeetState, at_rest, course
from mgjax.graph.feet.legs import FootChains, foot_chains
from mgjax.graph.feet.posed import leg_lengths, posed, reach_of
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, WalkFrames, frames_at, sample_walk

FRAMES = 512
"""Frames that a call is compiled for, and eight times as many, …; only lots that are needed are
computed."""
LOT = 32
"""Frames of a motion that are computed at once."""
FEW_LOT = 8
"""Single poses that are computed at once."""

_Carry = tuple[Array, Array, FeetState, FeetState, Array]
"""Root, rotations and states so far, the state to go on from, and how fast points move there."""


def legs_of(graph: MotionGraph) -> FootChains | None:
    """The legs that feet are kept with; None where a graph is built without, or has none."""
    if not graph.report.get("clean_feet", False):
        return None
    return cached(graph, ("feet", "legs"), lambda: _legs(graph.skeleton))


def _legs(skeleton: Skeleton) -> FootChains | None:
    try:
        return foot_chains(skeleton)
    except SkeletonError:  # the build said so
        return None


def play_walk(
    graph: MotionGraph,
    walk: Walk,
    times: Float[np.ndarray, " T"],
    *,
    rate: float | None = None,
    start: Float[np.ndarray, "3"] | None = None,
    begin: FeetState | None = None,
) -> Motion:
    """The motion of a walk as it is played, written and checked.

    The poses of :func:`mgjax.graph.walk.sample_walk`, in which a foot that stands in the capture
    stands still through seams and changes of speed (:mod:`mgjax.graph.feet.course`). The first
    frame is unchanged without a ``begin``, and what is appended to a walk changes nothing before.

    Args:
        graph: a motion graph.
        walk: over it.
        times: moments of the walk, s, that follow one another in the motion.
        rate: frames of the motion per second; default: of the first two times.
        start: planar frame of the body at the beginning of the walk.
        begin: what the feet are off at the first of the times, from what was played before.
    """
    return play(graph, walk, times, rate=rate, start=start, begin=begin)[0]


def play(
    graph: MotionGraph,
    walk: Walk,
    times: Float[np.ndarray, " T"],
    *,
    rate: float | None = None,
    start: Float[np.ndarray, "3"] | None = None,
    begin: FeetState | None = None,
) -> tuple[Motion, FeetState]:
    """:func:`play_walk`, and what the feet are off in each frame. [T, …]"""
    motion = sample_walk(graph, walk, times, start=start)
    if rate is not None:
        motion = like(replace(motion, frame_rate=float(rate)), motion)
    chains = legs_of(graph)
    state = begin or at_rest()
    if chains is None:
        return motion, jax.tree.map(lambda x: np.repeat(np.asarray(x)[None], len(times), 0), state)
    stands = _stands(graph, frames_at(graph, walk, times))
    return keep_feet(graph.skeleton, chains, motion, stands, scale=graph.body_scale, begin=state)


def play_at(
    graph: MotionGraph,
    walk: Walk,
    when: Float[np.ndarray, " T"],
    *,
    rate: float,
    start: Float[np.ndarray, "3"] | None = None,
    begin: FeetState | None = None,
) -> Motion:
    """Poses of a walk at any ascending moments, s, as it is written ``rate`` times a second."""
    motion = sample_walk(graph, walk, when, start=start)
    if legs_of(graph) is None or not len(when):
        return motion
    times = np.arange(max(int(np.ceil(when[-1] * rate)), 1) + 1) / rate
    states = play(graph, walk, times, rate=rate, start=start, begin=begin)[1]
    return with_feet(graph, motion, at_times(states, times, when))


def at_times(
    states: FeetState, times: Float[np.ndarray, " K"], when: Float[np.ndarray, " T"]
) -> FeetState:
    """States between those at ascending times, linearly; before and after them, the ends."""
    low = np.clip(np.searchsorted(times, when, side="right") - 1, 0, max(len(times) - 2, 0))
    high = np.minimum(low + 1, len(times) - 1)
    length = times[high] - times[low]
    share = np.divide(when - times[low], length, out=np.zeros(len(when)), where=length > 0)
    share = np.clip(share, 0.0, 1.0).astype(np.float32)

    def between(values: np.ndarray) -> np.ndarray:
        part = share.reshape(-1, *(1,) * (values.ndim - 1))
        return values[low] * (1 - part) + values[high] * part

    return jax.tree.map(between, states)


def with_feet(graph: MotionGraph, motion: Motion, states: FeetState) -> Motion:
    """Poses as captured, put as the states of their moments have feet and root. [T, …]"""
    chains = legs_of(graph)
    if chains is None:
        return motion
    count = motion.num_frames
    size = bucket_size(count, FRAMES, 8)
    origin = np.asarray(motion.root_translation[0], np.float64) * np.array([1.0, 0.0, 1.0])
    root = (np.asarray(motion.root_translation, np.float64) - origin).astype(np.float32)
    new_root, rotations = _put(
        graph.skeleton,
        _padded(root, size),
        _padded(np.asarray(motion.local_rotations, np.float32), size),
        jax.tree.map(lambda x: _padded(x, size), states),
        np.float32(graph.body_scale),
        np.int32(count),
        chains=chains,
    )
    return _moved(motion, new_root, rotations, origin)


def _padded(array: np.ndarray, size: int) -> np.ndarray:
    """Frames up to ``size``: the last one again to the end of its lot, then nothing."""
    count = len(array)
    padded = np.zeros((size, *array.shape[1:]), array.dtype)
    padded[:count] = array
    padded[count : -(-count // LOT) * LOT] = array[-1]
    return padded


def _moved(motion: Motion, root: Array, rotations: Array, origin: Float[np.ndarray, "3"]) -> Motion:
    count = motion.num_frames
    new = replace(
        motion,
        root_translation=(np.asarray(root)[:count].astype(np.float64) + origin).astype(np.float32),
        local_rotations=np.asarray(rotations)[:count],
    )
    return like(new, motion)


def _stands(graph: MotionGraph, played: WalkFrames) -> Bool[np.ndarray, "T 2 2"]:
    """Which points stand in the poses of a walk: those of the nearer of both frames."""
    nearer = np.where(played.share < 0.5, played.low, played.high)
    return standing_points(graph)[nearer]


def keep_feet(
    skeleton: Skeleton,
    chains: FootChains,
    motion: Motion,
    stands: Bool[np.ndarray, "T 2 2"],
    *,
    scale: float,
    begin: FeetState | None = None,
) -> tuple[Motion, FeetState]:
    """A motion whose feet stand still where they stand.

    Args:
        skeleton, chains: the body and its legs.
        motion: its poses.
        stands: whether the ball and the ankle of the left and the right foot stand.
        scale: of the body.
        begin: what the feet are off at the first frame; default: nothing.

    Returns:
        The motion, and the state in each of its frames.
    """
    count = motion.num_frames
    size = bucket_size(count, FRAMES, 8)
    # Single precision is for a body near the origin.
    origin = np.asarray(motion.root_translation[0], np.float64) * np.array([1.0, 0.0, 1.0])
    root = (np.asarray(motion.root_translation, np.float64) - origin).astype(np.float32)
    rotations = np.asarray(motion.local_rotations, np.float32)
    new_root, new_rotations, state = _kept(
        skeleton,
        _padded(root, size),
        _padded(rotations, size),
        _padded(stands, size),
        begin or at_rest(),
        np.float32(motion.frame_rate),
        np.float32(scale),
        np.int32(count),
        chains=chains,
    )
    moved = _moved(motion, new_root, new_rotations, origin)
    return moved, jax.tree.map(lambda x: np.asarray(x)[:count], state)


@partial(jax.jit, static_argnames="chains")
@exported("chains")
def _kept(
    skeleton: Skeleton,
    root: Float[jax.Array, "T 3"],
    rotations: Float[jax.Array, "T J 4"],
    stands: Bool[jax.Array, "T 2 2"],
    begin: FeetState,
    rate: Float[jax.Array, ""],
    scale: Float[jax.Array, ""],
    count: Int[jax.Array, ""],
    *,
    chains: FootChains,
) -> tuple[Array, Array, FeetState]:
    """A lot at a time, each with the first frame of the next one."""
    size = len(root)
    begin = jax.tree.map(jnp.asarray, begin)
    poses = jax.tree.map(lambda x: jnp.concatenate([x, x[-1:]]), (root, rotations, stands))

    def lot(number: Array, carry: _Carry) -> _Carry:
        new_root, new_rotations, states, state, before = carry
        at = number * LOT
        taken = jax.tree.map(lambda x: lax.dynamic_slice_in_dim(x, at, LOT + 1), poses)
        positions, turns = forward(skeleton, taken[0], taken[1])
        points = positions[:, np.array([chains.balls, chains.ankles]).T]
        hips, ankles = positions[:, np.array(chains.hips)], positions[:, np.array(chains.ankles)]
        reach = reach_of(hips, ankles, leg_lengths(positions, chains))
        speed = (points[1:, ..., ::2] - points[:-1, ..., ::2]) * rate
        found = course(
            points, hips, reach, taken[2], state, rate=rate, scale=scale,
            before=jnp.where(number == 0, speed[0], before),
        )  # fmt: skip
        here = jax.tree.map(lambda x: x[:LOT], (taken[0], taken[1], positions, turns, found))
        put = posed(skeleton, chains, *here, scale=scale)
        written = jax.tree.map(
            lambda whole, part: lax.dynamic_update_slice_in_dim(whole, part, at, 0),
            (new_root, new_rotations, states),
            (*put, here[-1]),
        )
        return *written, jax.tree.map(lambda x: x[-1], found), speed[-1]

    empty = jax.tree.map(lambda x: jnp.zeros((size, *x.shape), x.dtype), begin)
    carry = (root, rotations, empty, begin, jnp.zeros((2, 2, 2), root.dtype))
    return lax.fori_loop(0, (count + LOT - 1) // LOT, lot, carry)[:3]


@partial(jax.jit, static_argnames="chains")
@exported("chains")
def _put(
    skeleton: Skeleton,
    root: Float[jax.Array, "T 3"],
    rotations: Float[jax.Array, "T J 4"],
    states: FeetState,
    scale: Float[jax.Array, ""],
    count: Int[jax.Array, ""],
    *,
    chains: FootChains,
) -> tuple[Array, Array]:
    def lot(number: Array, carry: tuple[Array, Array]) -> tuple[Array, Array]:
        at = number * FEW_LOT
        here, local, state = jax.tree.map(
            lambda x: lax.dynamic_slice_in_dim(x, at, FEW_LOT), (root, rotations, states)
        )
        positions, turns = forward(skeleton, here, local)
        put = posed(skeleton, chains, here, local, positions, turns, state, scale=scale)
        return jax.tree.map(
            lambda whole, part: lax.dynamic_update_slice_in_dim(whole, part, at, 0), carry, put
        )

    return lax.fori_loop(0, (count + FEW_LOT - 1) // FEW_LOT, lot, (root, rotations))
