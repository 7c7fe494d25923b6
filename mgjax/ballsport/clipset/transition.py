"""Where one link motion is most like another: transition sections S_T between all pairs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.ballsport.clipset.build import ClipSet
from mgjax.ballsport.config import TransitionConfig, validate_transition
from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.core.body.roles import require_roles
from mgjax.core.contacts import foot_joints
from mgjax.core.errors import ConfigError
from mgjax.core.kinematics import joint_velocities
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.padding import bucket_size

NO_SECTION = -1
"""In a table: the link motion is shorter than the section."""
BONES = 5
_SQUARE = 16
"""Windows are searched in squares of this side; every link begins a new one."""
_SIZE = 2048
"""The axis of frames is padded to a multiple of this; the time grows with its square."""
_ROWS = 128
"""Rows of the distance matrix that exist at once: they and their sums stay in the cache."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TransitionTable:
    """The best transition section of every ordered pair of link motions.

    Attributes:
        window: frames of a section.
        distance: D_p summed over the section, infinite where there is none. [N, N]
        leave: first frame of the section in the first link, or ``NO_SECTION``. [N, N]
        arrive: first frame of the section in the second link, or ``NO_SECTION``. [N, N]
    """

    window: int
    distance: Float[np.ndarray, "N N"]
    leave: Int[np.ndarray, "N N"]
    arrive: Int[np.ndarray, "N N"]


def compared_joints(skeleton: Skeleton) -> tuple[int, int, int, int, int]:
    """Left and right foot, left and right hand, root (Fig. 4)."""
    wrists = require_roles(skeleton, ("left_wrist", "right_wrist"))
    return (*foot_joints(skeleton), wrists[0], wrists[1], 0)


def pose_features(clips: ClipSet) -> Float[np.ndarray, "F 10 3"]:
    """Places (m), then velocities (m/s) of the compared bones, in each frame's planar frame."""
    joints = list(compared_joints(clips.skeleton))
    places = clips.positions[:, joints]
    velocities = np.concatenate(
        [
            np.asarray(joint_velocities(places[a:b], clips.motion.frame_rate))
            for a, b in zip(clips.clip_starts, clips.clip_stops, strict=True)
        ]
    )
    inverse = np.asarray(planar.inverse(clips.planes))[:, None]
    turn = inverse * np.array([1, 0, 0], inverse.dtype)
    aligned = planar.apply(inverse, places), planar.apply(turn, velocities)
    return np.concatenate([np.asarray(x, np.float32) for x in aligned], axis=1)


def find_transitions(clips: ClipSet, config: TransitionConfig | None = None) -> TransitionTable:
    """The section of the given length in which two link motions are most alike, for all pairs.

    D_p (Choi et al. 2019, eq. 1) compares two poses; a section is the pair of windows, one in each
    link motion, with the smallest sum of D_p over its frames; of equal sums any may be taken. A
    link motion meets itself only by going back ``loop_s`` or more, so that it can be prolonged.

    Raises:
        ConfigError: a length or weight that cannot be.
    """
    config = config or TransitionConfig()
    window, loop = _frames(config, clips.motion.frame_rate)
    lengths = clips.link_stops - clips.link_starts
    tiles = -(-lengths // _SQUARE)
    links = bucket_size(len(lengths), 64)
    size = -(-(int(tiles.sum()) * _SQUARE + window) // _SIZE) * _SIZE
    owner = np.full(size // _SQUARE, links, np.int32)
    owner[: tiles.sum()] = np.repeat(np.arange(len(lengths)), tiles)
    first = _SQUARE * (np.cumsum(tiles) - tiles)
    frames = np.full(size, NO_SECTION, np.int32)
    valid = np.zeros(size, bool)
    for start, length, place in zip(clips.link_starts, lengths, first, strict=True):
        frames[place : place + length] = np.arange(start, start + length)
        valid[place : place + max(length - window + 1, 0)] = True
    features = pose_features(clips)[frames].transpose(1, 2, 0)
    weights = np.array([*config.w_p, *config.w_v], np.float32)
    distance, row, column = _search(
        features, weights, valid, owner, np.int32(loop), window=window, links=links
    )
    count = len(lengths)
    distance = np.asarray(distance)[:count, :count]
    exists = np.isfinite(distance)
    picked = [np.asarray(x)[:count, :count] for x in (row, column)]
    leave, arrive = (np.where(exists, frames[np.where(exists, x, 0)], NO_SECTION) for x in picked)
    return TransitionTable(window=window, distance=distance, leave=leave, arrive=arrive)


def _frames(config: TransitionConfig, frame_rate: float) -> tuple[int, int]:
    """Frames of a section and of the shortest loop."""
    validate_transition(config)
    window = round(config.seconds * frame_rate)
    if window < 2:
        raise ConfigError(
            f"got seconds = {config.seconds!r}, expected at least two frames of 1/{frame_rate:g} s"
        )
    return window, max(1, round(config.loop_s * frame_rate))


def pose_distances(
    rows: Float[Array, "10 3 R"], columns: Float[Array, "10 3 C"], weights: Float[Array, "10"]
) -> Float[Array, "R C"]:
    """D_p (eq. 1) of all pairs of aligned poses."""
    total = jnp.zeros((rows.shape[-1], columns.shape[-1]), jnp.float32)
    for item in range(2 * BONES):
        squares = jnp.zeros_like(total)
        for axis in range(3):
            squares = squares + (rows[item, axis][:, None] - columns[item, axis][None]) ** 2
        total = total + weights[item] * jnp.sqrt(squares)
    return total


def _diagonal_sums(matrix: Float[Array, "R C"], window: int) -> Float[Array, "P Q"]:
    """Sums of ``window`` entries down each diagonal, by doubling."""
    powers = [matrix]
    for k in range(window.bit_length() - 1):
        step = 2**k
        powers.append(powers[-1][:-step, :-step] + powers[-1][step:, step:])
    shape = matrix.shape[0] - window + 1, matrix.shape[1] - window + 1
    total, done = jnp.zeros(shape, matrix.dtype), 0
    for k, power in enumerate(powers):
        if window >> k & 1:
            total = total + jax.lax.dynamic_slice(power, (done, done), shape)
            done += 2**k
    return total


@partial(jax.jit, static_argnames=("window", "links"))
def _search(
    features: Float[Array, "10 3 S"],
    weights: Float[Array, "10"],
    valid: Array,
    owner: Int[Array, " K"],
    loop: Int[Array, ""],
    *,
    window: int,
    links: int,
) -> tuple[Array, Array, Array]:
    """Smallest sums and where they are, [links, links] each; first by tiles, then inside them."""
    size, more = features.shape[-1], window - 1
    padded = jnp.pad(features, [(0, 0), (0, 0), (0, more)])
    owners = jnp.repeat(owner, _SQUARE)
    place = jnp.arange(size, dtype=jnp.int32)

    def allowed(rows: Array, columns: Array) -> Array:
        same = owners[rows][:, None] == owners[columns][None]
        back = columns[None] <= rows[:, None] - loop
        return valid[rows][:, None] & valid[columns][None] & (~same | back)

    def sums(rows: Array, columns: Array) -> Array:
        """Window sums for two runs of starts; infinite where a window is not allowed."""
        a, b = (
            jax.lax.dynamic_slice_in_dim(padded, x[0], x.shape[0] + more, axis=2)
            for x in (rows, columns)
        )
        total = _diagonal_sums(pose_distances(a, b, weights), window)
        return jnp.where(allowed(rows, columns), total, jnp.inf)

    def block(first: Array) -> Array:
        rows = first + place[:_ROWS]

        def least() -> Array:
            tiles = sums(rows, place).reshape(_ROWS // _SQUARE, _SQUARE, size // _SQUARE, _SQUARE)
            return jnp.min(jnp.min(tiles, axis=1), axis=-1)

        none = jnp.full((_ROWS // _SQUARE, size // _SQUARE), jnp.inf, jnp.float32)
        return jax.lax.cond(jnp.any(valid[rows]), least, lambda: none)

    grid = jax.lax.map(block, place[::_ROWS]).reshape(size // _SQUARE, size // _SQUARE)
    best = jax.ops.segment_min(grid, owner, links, indices_are_sorted=True)
    best = jax.ops.segment_min(best.T, owner, links, indices_are_sorted=True).T
    # The first tile that holds the smallest sum of its pair of links.
    number = jnp.arange(grid.size, dtype=jnp.int32).reshape(grid.shape)
    inside = jnp.minimum(owner, links - 1)
    hit = grid == best[inside][:, inside]
    first = jax.ops.segment_min(jnp.where(hit, number, grid.size), owner, links)
    first = jax.ops.segment_min(first.T, owner, links).T.reshape(-1)
    first = jnp.clip(first, 0, grid.size - 1)

    def look(tile: Array) -> tuple[Array, Array, Array]:
        rows = tile // grid.shape[1] * _SQUARE + place[:_SQUARE]
        columns = tile % grid.shape[1] * _SQUARE + place[:_SQUARE]
        total = sums(rows, columns).reshape(-1)
        at = jnp.argmin(total).astype(jnp.int32)
        return total[at], rows[at // _SQUARE], columns[at % _SQUARE]

    # Each tile's own sums decide, so that one rounding holds for values and places.
    best_inside = jax.lax.map(look, first, batch_size=256)
    value, row, column = (x.reshape(links, links) for x in best_inside)
    return jnp.where(jnp.isfinite(best), value, jnp.inf), row, column
