"""Pieces of the clip set played one after the other, blended where they meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.ballsport.clipset.build import ClipSet
from mgjax.core import planar, quaternion
from mgjax.core.arrays import Array
from mgjax.core.errors import MotionError
from mgjax.core.motion import Motion
from mgjax.graph.blending.alignment import align
from mgjax.graph.blending.forms import blend_weights


@dataclass(frozen=True, kw_only=True, eq=False)
class Joined:
    """One motion out of several pieces.

    Attributes:
        motion: world coordinates.
        placements: planar transform from the coordinates of each piece's clip to the world. [P, 3]
        offsets: frame ``f`` of the clip set, if piece p plays it, is frame ``f + offsets[p]`` of
            the motion. [P]
        seams: first and last-but-one frame of each blend, as start and stop. [P−1, 2]
    """

    motion: Motion
    placements: Float[np.ndarray, "P 3"]
    offsets: Int[np.ndarray, " P"]
    seams: Int[np.ndarray, "S 2"]


def join(
    clips: ClipSet,
    pieces: Sequence[tuple[int, int]],
    *,
    window: int,
    placement: Float[np.ndarray, "3"] | None = None,
) -> Joined:
    """Plays ranges of the clip set one after the other.

    The last ``window`` frames of a piece and the first of the next are aligned on the floor and
    blended: the root linearly, rotations along the shorter arc, with weights that begin and end
    without a change of velocity (:func:`mgjax.graph.blending.forms.blend_weights`). So to leave one
    link by the section of a :class:`~mgjax.ballsport.clipset.transition.TransitionTable`, its piece
    stops at ``leave + window`` and the next starts at ``arrive``.

    Args:
        clips: the clip set.
        pieces: start and stop frames on its axis.
        window: frames of a blend.
        placement: planar transform of the first piece, by default where it was captured.

    Raises:
        MotionError: a piece that is not inside one clip, or too short for its blends.
    """
    ranges = np.array(pieces, np.int64).reshape(-1, 2)
    _validate(clips, ranges, window)
    root = np.asarray(clips.motion.root_translation)
    turns = np.asarray(clips.motion.local_rotations)
    even = np.full(clips.skeleton.num_joints, 1 / clips.skeleton.num_joints, np.float32)
    alpha = blend_weights(window)
    here = np.zeros(3) if placement is None else np.asarray(placement, np.float64)
    placements, offsets, seams = [here], [-int(ranges[0, 0])], []
    roots: list[np.ndarray] = []
    rotations: list[np.ndarray] = []
    length = 0
    for number, (start, stop) in enumerate(ranges):
        first = start + (window if number else 0)
        last = stop - (window if number + 1 < len(ranges) else 0)
        place, turned = _placed(here, root[first:last], turns[first:last])
        roots.append(place)
        rotations.append(turned)
        length += last - first
        if number + 1 == len(ranges):
            break
        a, b = slice(last, stop), slice(ranges[number + 1, 0], ranges[number + 1, 0] + window)
        windows = [x[part] for part in (a, b) for x in (root, turns, clips.positions)]
        place, turned, transform = _seam(*windows, even, alpha)
        place, turned = _placed(here, np.asarray(place), np.asarray(turned))
        roots.append(place)
        rotations.append(turned)
        seams.append((length, length + window))
        here = np.asarray(planar.compose(here, np.asarray(transform, np.float64)))
        placements.append(here)
        offsets.append(length - int(ranges[number + 1, 0]))
        length += window
    motion = replace(
        clips.motion,
        root_translation=np.concatenate(roots).astype(np.float32),
        local_rotations=np.concatenate(rotations).astype(np.float32),
    )
    return Joined(
        motion=motion,
        placements=np.array(placements),
        offsets=np.array(offsets, np.int64),
        seams=np.array(seams, np.int64).reshape(-1, 2),
    )


def _validate(clips: ClipSet, ranges: np.ndarray, window: int) -> None:
    if len(ranges) == 0 or window < 2:
        raise MotionError(
            f"got {len(ranges)} pieces and a blend of {window} frames,"
            " expected at least one piece and two frames"
        )
    for number, (start, stop) in enumerate(ranges):
        inside = (clips.clip_starts <= start) & (stop <= clips.clip_stops)
        if not (start < stop and inside.any()):
            raise MotionError(f"got frames {start}…{stop}, expected a range inside one clip")
        needed = window * ((number > 0) + (number + 1 < len(ranges)))
        if stop - start < needed:
            raise MotionError(
                f"got frames {start}…{stop} between two blends, expected at least {needed} frames"
            )


def _placed(
    transform: np.ndarray, root: np.ndarray, rotations: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Poses under a planar transform."""
    place, first = planar.apply_pose(transform, root, rotations[:, 0])
    return np.asarray(place), np.concatenate([np.asarray(first)[:, None], rotations[:, 1:]], axis=1)


@jax.jit
def _seam(
    root_a: Float[Array, "W 3"],
    rotations_a: Float[Array, "W J 4"],
    positions_a: Float[Array, "W J 3"],
    root_b: Float[Array, "W 3"],
    rotations_b: Float[Array, "W J 4"],
    positions_b: Float[Array, "W J 3"],
    weights: Float[Array, " J"],
    alpha: Float[Array, " W"],
) -> tuple[Array, Array, Array]:
    """The blend in the coordinates of A, and the transform of B."""
    transform = align(positions_a, positions_b, weights)
    root, first = planar.apply_pose(transform, root_b, rotations_b[:, 0])
    rotations = jnp.concatenate([first[:, None], rotations_b[:, 1:]], axis=1)
    share = alpha[:, None]
    return (
        share * root_a + (1 - share) * root,
        _turn_between(rotations_a, rotations, 1 - alpha),
        transform,
    )


def _turn_between(
    a: Float[Array, "W J 4"], b: Float[Array, "W J 4"], t: Float[Array, " W"]
) -> Float[Array, "W J 4"]:
    """From the rotations ``a`` (t = 0) to ``b`` (t = 1), each joint the same way round throughout.

    The shortest arc of each frame could change sides from one frame to the next where two poses
    differ by about half a turn, and the joint would jump.
    """
    between = quaternion.multiply(quaternion.conjugate(a), b)
    flips = jnp.sum(between[1:] * between[:-1], axis=-1) < 0
    sign = jnp.cumprod(jnp.where(flips, -1.0, 1.0), axis=0)
    between = between * jnp.concatenate([jnp.ones_like(sign[:1]), sign])[..., None]
    between = between * jnp.where(jnp.sum(between[..., 0], axis=0) < 0, -1.0, 1.0)[None, :, None]
    size = jnp.sqrt(jnp.maximum(jnp.sum(between[..., 1:] ** 2, axis=-1), 1e-20))
    half = t[:, None] * jnp.arctan2(size, between[..., 0])
    xyz = between[..., 1:] / size[..., None] * jnp.sin(half)[..., None]
    return quaternion.multiply(a, jnp.concatenate([jnp.cos(half)[..., None], xyz], axis=-1))
