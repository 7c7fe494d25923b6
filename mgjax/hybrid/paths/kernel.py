"""The heavy part of the path search: many partial walks extended by many macro edges at once.

Everything here is one jitted call over flat pairs (partial walk, macro edge). Shapes depend on the
size of the graph's tables and on a few buckets of pairs, not on the path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Float, Int

from mgjax.core.arrays import Array
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.core.xla.pytree import register
from mgjax.hybrid.config import PathConfig
from mgjax.hybrid.macro.macro_edges import MacroEdges
from mgjax.hybrid.paths.curve import SAMPLES, SPACING_M, Curve
from mgjax.hybrid.paths.sketch import Sketch

SMALLEST, LARGEST, GROWTH = 256, 6912, 3
"""Pairs in one call: 256, 768, 2304 or 6912."""

END_EARLY_M, END_LATE_M = 0.5, 1.0
"""An adult's walk to a given end may stop so much before and after the path's length: the root
sways, so its own arc length runs ahead of its way along the path."""


@register("with_speed", "with_end")
@dataclass(frozen=True, kw_only=True, eq=False)
class Request:
    """A path as the kernels read it.

    Attributes:
        x, z: P at multiples of ``spacing``, m. [S]
        speeds: wanted speed there, NaN for none; one entry if none is wanted at all. [S]
        spacing, length: m.
        near: largest distance, m.
        early, late: how much before and after the length a walk to a given end may stop, m.
        speed_weight, blend_weight: see :class:`PathConfig`.
        end: place and heading of the end; a NaN heading is any. [3]
        end_weights: of the squared distance to the end, and of the squared heading error. [2]
        obstacles: circles, grown by the margin; padding has the radius −1. [O, 3]
        with_speed, with_end: whether any speed, and whether an end is wanted.
    """

    x: Float[Array, " S"]
    z: Float[Array, " S"]
    speeds: Float[Array, " V"]
    spacing: Float[Array, ""]
    length: Float[Array, ""]
    near: Float[Array, ""]
    early: Float[Array, ""]
    late: Float[Array, ""]
    speed_weight: Float[Array, ""]
    blend_weight: Float[Array, ""]
    end: Float[Array, "3"]
    end_weights: Float[Array, "2"]
    obstacles: Float[Array, "O 3"]
    with_speed: bool
    with_end: bool


def make_request(curve: Curve, sketch: Sketch, config: PathConfig) -> Request:
    """Puts a path into arrays of fixed shape; the settings are those of the body."""
    spacing = max(curve.scale * SPACING_M, curve.length / (SAMPLES - 1))
    arc = np.minimum(np.arange(math.ceil(curve.length / spacing) + 1) * spacing, curve.length)
    places = curve.at(arc)
    circles = sketch.obstacles + np.array([0.0, 0.0, config.margin_m])
    if len(circles):
        circles = pad_axis(circles, bucket_size(len(circles), 8, 4), value=-1.0)

    def number(value: float) -> Array:
        return jnp.float32(value)

    def filled(values: np.ndarray) -> Array:
        return jnp.asarray(pad_axis(values.astype(np.float32), SAMPLES))

    wanted = bool(np.isfinite(curve.speed).any())

    return Request(
        x=filled(places[:, 0]),
        z=filled(places[:, 1]),
        speeds=filled(np.interp(arc, curve.arc, curve.speed)) if wanted else jnp.zeros(1),
        spacing=number(spacing),
        length=number(curve.length),
        near=number(config.near_m),
        early=number(curve.scale * END_EARLY_M),
        late=number(curve.scale * END_LATE_M),
        speed_weight=number(config.speed_weight),
        blend_weight=number(config.blend_weight),
        end=jnp.asarray(sketch.end or (0.0, 0.0, 0.0), dtype=jnp.float32),
        end_weights=jnp.asarray([1.0, config.end_radius_m**2], dtype=jnp.float32)
        * number(config.end_weight),
        obstacles=jnp.asarray(circles, dtype=jnp.float32),
        with_speed=wanted,
        with_end=sketch.end is not None,
    )


@jax.jit
def extension_costs(
    track: Float[Array, "K 4 W"],
    speed_heading: Float[Array, "K 2 W"],
    request: Request,
    state: Float[Array, "P 5"],
    macro_edge: Int[Array, " P"],
    frames: Int[Array, "P 2"],
) -> Float[Array, "3 P"]:
    """Costs of partial walks after one more macro edge (eqs 6–7).

    Args:
        track, speed_heading: see :class:`mgjax.hybrid.macro.macro_edges.MacroEdges`.
        request: the path.
        state: heading, x, z, arc length and cost of each partial walk.
        macro_edge: by which each is extended.
        frames: of the macro edge, and how many frames count until the horizon.

    Returns:
        The cost, inf if the walk strays or cannot go on because it is complete; the cost of the
        walk if it ends in this macro edge as complete, else inf; and the frames until then.
    """
    *steps, blend = _unpacked(_rows(track, macro_edge))
    speed, turned = _unpacked(_rows(speed_heading, macro_edge))
    heading, _, _, arc_before, cost_before = _columns(state)
    x, z, arc = _onward(state, *steps)
    last = jnp.concatenate([arc_before, arc[:, :-1]], axis=1)
    late = request.late if request.with_end else 0.0
    number = jnp.arange(track.shape[2])[None]
    counted = (number < jnp.min(frames, axis=1, keepdims=True)) & (last < request.length + late)
    index = _index(request, arc)
    square = (x - _rows(request.x, index)) ** 2 + (z - _rows(request.z, index)) ** 2
    strayed = counted & (square > request.near**2)
    strayed = strayed | (counted & _inside(request.obstacles, x, z))
    if request.with_speed:
        wanted = _rows(request.speeds, index)
        slow = jnp.where(jnp.isnan(wanted), 0.0, speed - wanted)
        square = square + request.speed_weight * slow**2
    square = square + request.blend_weight * blend
    square = jnp.where(strayed, jnp.inf, jnp.where(counted, square, 0.0))
    cost = cost_before[:, 0] + jnp.sum(square, axis=1)
    if not request.with_end:
        finished = jnp.any(counted & (arc >= request.length), axis=1)
        count = jnp.sum(counted, axis=1).astype(jnp.float32)
        return jnp.stack(
            [jnp.where(finished, jnp.inf, cost), jnp.where(finished, cost, jnp.inf), count]
        )
    total = cost_before + jnp.cumsum(square, axis=1) + _end_cost(request, x, z, heading + turned)
    total = jnp.where(counted & (arc >= request.length - request.early), total, jnp.inf)
    over = jnp.any(counted & (arc >= request.length + late), axis=1)
    best = jnp.argmin(total, axis=1)
    return jnp.stack(
        [jnp.where(over, jnp.inf, cost), jnp.min(total, axis=1), best.astype(jnp.float32) + 1.0]
    )


def _columns(state: Float[Array, "P 5"]) -> list[Float[Array, "P 1"]]:
    """Heading, x, z, arc length and cost of partial walks."""
    return [state[:, column : column + 1] for column in range(state.shape[1])]


def _unpacked(rows: Float[Array, "P C W"]) -> list[Float[Array, "P W"]]:
    """The columns of rows of a table."""
    return [rows[:, column] for column in range(rows.shape[1])]


def _onward(
    state: Float[Array, "P 5"], x: Array, z: Array, arc: Array
) -> tuple[Float[Array, "P W"], Float[Array, "P W"], Float[Array, "P W"]]:
    """x, z and arc length in the world of what lies ahead of partial walks. [P, W] each"""
    heading, x_before, z_before, arc_before, _ = _columns(state)
    c, s = jnp.cos(heading), jnp.sin(heading)
    return x * c + z * s + x_before, z * c - x * s + z_before, arc_before + arc


def _rows(table: Array, index: Array) -> Array:
    """The rows of a table; the host and :func:`_index` keep the index in range."""
    return jnp.asarray(table).at[index].get(mode="promise_in_bounds")


def _index(request: Request, arc: Array) -> Array:
    # Arc length is never negative, and the conversion to unsigned numbers is the quicker one.
    return jnp.minimum((arc / request.spacing + 0.5).astype(jnp.uint32), jnp.uint32(SAMPLES - 1))


def _inside(circles: Float[Array, "O 3"], x: Array, z: Array) -> Array:
    def step(inside: Array, circle: Array) -> tuple[Array, None]:
        near = (x - circle[0]) ** 2 + (z - circle[1]) ** 2 < circle[2] ** 2
        return inside | (near & (circle[2] > 0)), None

    nowhere = jnp.zeros_like(x, dtype=bool)
    return lax.scan(step, nowhere, circles)[0] if circles.shape[0] else nowhere


def _end_cost(request: Request, x: Array, z: Array, heading: Array) -> Array:
    off = (x - request.end[0]) ** 2 + (z - request.end[1]) ** 2
    turn = jnp.where(jnp.isnan(request.end[2]), 0.0, heading - request.end[2])
    turn = jnp.arctan2(jnp.sin(turn), jnp.cos(turn))
    return request.end_weights[0] * off + request.end_weights[1] * turn**2


@jax.jit
def lower_bounds(
    ahead: Float[Array, "N 4 T"],
    request: Request,
    state: Float[Array, "B 5"],
    stop: Int[Array, " B"],
    frames: Int[Array, " B"],
) -> Float[Array, " B"]:
    """A cost that every continuation over the next 2 Δ frames adds at least.

    Wherever a walk goes, τ frames after a stop its root lies in a disc that was computed with the
    graph; if the disc is d beyond its radius from the path, the frame costs at least d². Frames in
    which the walk may be over do not count. inf: every continuation strays.

    Args:
        ahead: the discs; see :class:`mgjax.hybrid.macro.macro_edges.MacroEdges`.
        request: the path.
        state: heading, x, z, arc length and cost of each partial walk.
        stop: where each stands.
        frames: how many count until the horizon.
    """
    *centre, radius = _unpacked(_rows(ahead, stop))
    x, z, arc = _onward(state, *centre)
    index = _index(request, arc)
    square = (x - _rows(request.x, index)) ** 2 + (z - _rows(request.z, index)) ** 2
    # A place is read to half a spacing.
    least = jnp.maximum(jnp.sqrt(square) - radius - request.spacing, 0.0)
    early = request.early if request.with_end else 0.0
    counted = (jnp.arange(ahead.shape[2])[None] < frames[:, None]) & (
        arc + radius < request.length - early
    )
    square = jnp.where(least > request.near, jnp.inf, least**2)
    return jnp.sum(jnp.where(counted, square, 0.0), axis=1)


_compiled: set[tuple[object, ...]] = set()


def compile_kernels(macro_edges: MacroEdges, request: Request) -> None:
    """Compiles the kernels for all sizes, once for tables of one shape."""
    tables = (macro_edges.track, macro_edges.speed_heading, macro_edges.ahead)
    key = (*(t.shape for t in tables), request.obstacles.shape)
    key += (request.with_speed, request.with_end)
    if key in _compiled:
        return
    size = SMALLEST
    while size <= LARGEST:
        state, number = np.zeros((size, 5), np.float32), np.zeros(size, np.int32)
        extension_costs(*tables[:2], request, state, number, np.zeros((size, 2), np.int32))
        lower_bounds(tables[2], request, state, number, number).block_until_ready()
        size *= GROWTH
    _compiled.add(key)


def in_buckets(pairs: int) -> list[tuple[int, int, int]]:
    """Cuts a number of pairs into calls: first pair, pair after the last, and padded size."""
    cuts = range(0, pairs, LARGEST)
    ends = [min(first + LARGEST, pairs) for first in cuts]
    return [(a, b, bucket_size(b - a, SMALLEST, GROWTH)) for a, b in zip(cuts, ends, strict=True)]
