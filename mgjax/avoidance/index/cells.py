"""Cells of the grid index (§5.1), and those that an attack passes through."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Complex, Float, Int, UInt32

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop

CELL_M = 0.1
LOWEST, HEIGHTS = -2, 28
"""Cells from 0.2 m under the floor to 2.6 m; what touches others has to be enumerated."""
SPAN = 256
"""Columns are numbered (i + SPAN/2) · SPAN + k + SPAN/2; beyond 12.8 m there are none."""
COVERED = np.array([[-SPAN // 2, LOWEST, -SPAN // 2], [SPAN // 2, LOWEST + HEIGHTS, SPAN // 2]])
"""First cell along each axis, and the one after the last."""
_PIECE_M = 0.25


def touched_cells(attack: Attack, crop: Crop) -> Int[np.ndarray, "M 3"] | None:
    """The cells that the swept spheres of a cropped attack touch, in ascending order.

    A sphere that moves straight between knots sweeps a capsule; a cell is touched if it and the
    capsule intersect. Where the attack is curved between knots its radius is enlarged by
    acceleration · dt²/8, so that no cell is missed.

    Args:
        attack: in the planar frame of the node whose cells are meant.
        crop: the part that counts.

    Returns:
        The cells, or None if some are outside the space that indices cover.
    """
    _, lines, radii = swept_lines(attack, crop)
    if not len(radii):
        return np.zeros((0, 3), np.int64)
    low = np.floor((lines - radii[:, None]).min(axis=(0, 1)) / CELL_M)
    high = np.floor((lines + radii[:, None]).max(axis=(0, 1)) / CELL_M)
    if (low < COVERED[0]).any() or (high >= COVERED[1]).any():
        return None
    low, high = low.astype(np.int64) - 1, high.astype(np.int64) + 1
    marks = np.zeros(high - low + 1, bool)
    for i, radius in enumerate(radii):
        _mark_capsules(marks, low, lines[:, i], float(radius))
    return np.stack(np.nonzero(marks), axis=1) + low


def swept_lines(
    attack: Attack, crop: Crop
) -> tuple[Float[np.ndarray, " K"], Float[np.ndarray, "K I 3"], Float[np.ndarray, " I"]]:
    """Times, centres and radii of the capsules that a cropped attack sweeps.

    The radii are enlarged where the attack is curved between knots. Spheres that are not there at
    any moment of the crop are left out.
    """
    knots = attack.times
    first, stop = knots.searchsorted(crop.start, "right"), knots.searchsorted(crop.end)
    times = np.concatenate([[crop.start], knots[first:stop], [crop.end]])
    if attack.starts is None and attack.stops is None:
        ends = attack.at(times[[0, -1]])
        centres, radii = (
            np.concatenate([ends[:1], attack.centres[first:stop], ends[1:]]),
            attack.radii,
        )
    else:
        lives = attack.lives(times[[0, -1]])[0]
        centres, radii = attack.at(times)[:, lives], attack.radii[lives]
    if attack.acceleration == 0:
        return times, centres, radii
    return times, centres, radii + attack.acceleration * np.diff(times).max() ** 2 / 8


def _mark_capsules(
    marks: Bool[np.ndarray, "X Y Z"],
    low: Int[np.ndarray, " 3"],
    line: Float[np.ndarray, "K 3"],
    radius: float,
) -> None:
    """Marks the cells within ``radius`` of a polyline; ``low`` is the first cell."""
    start, stop = _short_pieces(line)
    first = np.floor((np.minimum(start, stop) - radius) / CELL_M).astype(np.int64)
    last = np.floor((np.maximum(start, stop) + radius) / CELL_M).astype(np.int64)
    displacement = stop - start
    key = np.zeros((len(start), 1, 1, 1), np.int64)
    squared = along = np.zeros(key.shape)
    for axis, count in enumerate((last - first).max(axis=0) + 1):
        shape = [len(start), 1, 1, 1]
        shape[axis + 1] = count
        cell = first[:, axis, None] + np.arange(count)
        middle = (cell + 0.5) * CELL_M - start[:, axis, None]
        squared = squared + (middle * middle).reshape(shape)
        along = along + (middle * displacement[:, axis, None]).reshape(shape)
        key = key * marks.shape[axis]
        key = key + _limited(cell - low[axis], 0, marks.shape[axis] - 1).reshape(shape)
    length = np.maximum((displacement * displacement).sum(axis=1), 1e-18)[:, None, None, None]
    share = _limited(along / length, 0.0, 1.0)
    squared = squared + share * (share * length - 2 * along)  # from the middle to the segment
    # A ball of half a cell is inside the cell, and one of half of its diagonal around it.
    flat = marks.reshape(-1)
    flat[key[squared <= (radius + 0.4999 * CELL_M) ** 2]] = True
    open_ = (squared <= (radius + 0.8661 * CELL_M) ** 2) & ~flat[key]
    piece, key = np.nonzero(open_)[0], key[open_]
    corner = np.stack(np.unravel_index(key, marks.shape), axis=1) + low
    flat[key[box_gap(start[piece], displacement[piece], corner * CELL_M) <= radius]] = True


def _short_pieces(line: Float[np.ndarray, "K 3"]) -> tuple[np.ndarray, np.ndarray]:
    """Starts and ends of the pieces of a polyline: one if it is straight, then cut short."""
    displacement = line[-1] - line[0]
    along = (line - line[0]) @ displacement / max(float(displacement @ displacement), 1e-18)
    if (
        np.abs(line - line[0] - along[:, None] * displacement).max() < 1e-9
        and (np.diff(along) >= 0).all()
    ):
        line = line[[0, -1]]
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    count = np.maximum(np.ceil(lengths / _PIECE_M).astype(np.int64), 1)
    piece = np.repeat(np.arange(len(count)), count)
    place = (np.arange(len(piece)) - (np.cumsum(count) - count)[piece])[:, None]
    step = (np.diff(line, axis=0) / count[:, None])[piece]
    start = line[piece] + place * step
    return start, start + step


def _limited(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """``np.clip`` for small arrays, whose cost is the call."""
    return np.minimum(np.maximum(values, low), high)


def box_gap(
    start: Float[np.ndarray, "B 3"],
    displacement: Float[np.ndarray, "B 3"],
    corner: Float[np.ndarray, "B 3"],
) -> Float[np.ndarray, " B"]:
    """Least distance of segments start … start + displacement to cells, in closed form.

    The squared distance is convex and quadratic between the places where the segment meets the
    planes of the cell's faces, so its derivative is linear there.
    """
    safe = np.where(displacement == 0, 1.0, displacement)
    gap = corner - start
    planes = [np.where(displacement == 0, 0.0, (gap + f) / safe) for f in (0.0, CELL_M)]
    ends = np.broadcast_to([0.0, 1.0], (len(start), 2))
    at = np.sort(_limited(np.concatenate([*planes, ends], axis=1), 0.0, 1.0), axis=1)

    def excess(share: np.ndarray) -> np.ndarray:
        x = start[:, None] + share[..., None] * displacement[:, None] - corner[:, None]
        return np.maximum(x - CELL_M, 0) + np.minimum(x, 0)

    slope = (excess(at) * displacement[:, None]).sum(axis=-1)
    right = np.clip((slope < 0).sum(axis=1), 1, at.shape[1] - 1)
    row = np.arange(len(start))
    a, b, fa, fb = at[row, right - 1], at[row, right], slope[row, right - 1], slope[row, right]
    share = np.clip(a - fa * (b - a) / np.where(fb == fa, 1.0, fb - fa), a, b)
    return np.linalg.norm(excess(share[:, None])[:, 0], axis=-1)


def corners(columns: Int[np.ndarray, " K"]) -> Complex[np.ndarray, " K"]:
    """x + i z of the lowest corners of columns, in cells."""
    x, z = np.divmod(columns, SPAN)
    return (x - SPAN // 2) + 1j * (z - SPAN // 2)


def set_bits(
    masks: UInt32[np.ndarray, " X"],
) -> tuple[Int[np.ndarray, " M"], UInt32[np.ndarray, " M"]]:
    """The bits that are set in masks: which mask, and which bit of it."""
    which, bit = ((masks[:, None] >> np.arange(HEIGHTS, dtype=np.uint32)) & 1).nonzero()
    return which, bit.astype(np.uint32)


def cell_of(
    columns: Int[np.ndarray, " M"], bit: UInt32[np.ndarray, " M"]
) -> Int[np.ndarray, "M 3"]:
    """The cells of columns, given by number, at the heights of bits."""
    x, z = np.divmod(columns, SPAN)
    return np.stack([x - SPAN // 2, bit.astype(np.int64) + LOWEST, z - SPAN // 2], axis=1)
