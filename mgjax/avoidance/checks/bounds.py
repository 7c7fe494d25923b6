"""Bounds on the clearance of a few walks at once, from the table of body volumes.

The written motion turns joints by slerp; the table's spheres move straight from frame to frame.
What that can differ is known (:mod:`mgjax.avoidance.body.chord_error`), so the clearance of the
motion as it would be written lies within bounds. Where they leave no doubt nothing else needs to be
looked at.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import jax
import jax.numpy as jnp
from jaxtyping import Float, Int

from mgjax.avoidance.attacks.batch import (
    AttackBatch,
    AttackColumn,
    active_at,
    centres_at,
    centres_at_frames,
    frame_times,
    lives_between,
)
from mgjax.avoidance.body.device_tables import FOLLOWING, DeviceTables, LinkColumn
from mgjax.avoidance.body.volumes import (
    PlacedColumn,
    PlacedEdges,
    chain_transforms,
    chord_errors_at,
    locate,
    read_edges,
    root_at,
    spheres_at,
)
from mgjax.avoidance.candidates.batch import CandidateBatch
from mgjax.avoidance.rates import CLEAR_M, EXPORT_RATE, FAR
from mgjax.core.arrays import Array
from mgjax.core.xla.materialise import stage
from mgjax.core.xla.pytree import register
from mgjax.graph.types import NO_EDGE

FIRST_LANES = 2
"""Walks that are looked at with the ranking: the winner is nearly always among the first."""

MORE_LANES = 32
"""Walks that are looked at together after those."""

CHUNK_FRAMES = 64
"""Frames that are looked at together."""

STRIDE = 4
"""One in so many frames tells when a single sphere may be near a walk at all."""

ROUNDING_M = 1e-4
"""Beside twice the chord error: what 32 bits and the written motion's own frames differ by."""

_ARCS = 2.0
"""A written frame lies between two frames of the graph, and the body moves between two written
frames along yet another arc: each differs from a straight line by one chord error at most."""


class BoundColumn(IntEnum):
    """Columns of :attr:`Bounds.figures`; what each says stands at the property of its name."""

    CLEARANCE = 0
    LOWER_BOUND = 1
    CONTACT_FROM = 2
    PATH_END = 3


@register()
@dataclass(frozen=True, kw_only=True)
class Bounds:
    """What is certain about the clearance of each of K walks.

    Attributes:
        edges, scales: the walks with what follows them. [K, M]
        figures: the properties below, in one array. [K, 4]
    """

    edges: Int[Array, "*k M"]
    scales: Float[Array, "*k M"]
    figures: Float[Array, "*k 4"]

    @property
    def clearance(self) -> Float[Array, "*k"]:
        """Clearance of the table's body, m."""
        return self.figures[..., BoundColumn.CLEARANCE]

    @property
    def lower_bound(self) -> Float[Array, "*k"]:
        """The clearance of the written motion is at least this, m."""
        return self.figures[..., BoundColumn.LOWER_BOUND]

    @property
    def contact_from(self) -> Float[Array, "*k"]:
        """Seconds from which the walk is certainly touched; ``FAR`` if not certainly."""
        return self.figures[..., BoundColumn.CONTACT_FROM]

    @property
    def path_end(self) -> Float[Array, "*k"]:
        """When the path is over, s."""
        return self.figures[..., BoundColumn.PATH_END]


def clearance_bounds(
    tables: DeviceTables,
    walks: CandidateBatch,
    scales: Float[Array, "L K"],
    attack_batch: AttackBatch,
    *,
    frame_rate: float,
) -> Bounds:
    """Bounds on the clearance of walks and of what follows them by default.

    Args:
        tables: of the graph.
        walks: the walks; a length of 0 is padding.
        scales: factor on the duration of each edge.
        attack_batch: the attacks.
        frame_rate: of the graph.
    """
    own = attack_batch if walks.owner is None else attack_batch.of(walks.owner)
    edges, scales = stage(tables.opaque_true, _continued, tables.edge_links, walks, scales)
    placed = stage(
        tables.opaque_true,
        lambda e, s: chain_transforms(tables, e, read_edges(tables, e), s),
        edges,
        scales,
    )
    lanes = jnp.arange(walks.length.shape[0], dtype=jnp.int32)
    path_end = placed.ends[jnp.maximum(walks.length - 1, 0), lanes]
    # Sped up further, a walk would pass several frames of the graph between two written ones.
    quick = jnp.any((edges != NO_EDGE) & (scales * EXPORT_RATE < frame_rate * 0.999), axis=0)
    first, last = _near(tables, placed, own)
    clearance, lower_bound, contact = _over_frames(tables, placed, own, first, last, quick)
    figures = jnp.stack([clearance, lower_bound, contact, path_end], axis=1)
    return Bounds(edges=edges.T, scales=scales.T, figures=figures)


def _continued(
    links: Int[Array, "E D"], walks: CandidateBatch, scales: Float[Array, "L K"]
) -> tuple[Array, Array]:
    """The walks with what follows them appended, at natural speed."""
    edges, length = walks.edges, walks.length
    last = edges[jnp.maximum(length - 1, 0), jnp.arange(length.shape[0], dtype=jnp.int32)]
    more = links[jnp.maximum(last, 0)][:, LinkColumn.FOLLOWERS :].T
    row = jnp.arange(edges.shape[0] + FOLLOWING, dtype=jnp.int32)[:, None]
    beyond = row - length[None]
    longer = jnp.pad(edges, ((0, FOLLOWING), (0, 0)), constant_values=NO_EDGE)
    for k in range(FOLLOWING):
        longer = jnp.where((beyond == k) & (length > 0)[None], more[k : k + 1], longer)
    wide = jnp.pad(scales, ((0, FOLLOWING), (0, 0)), constant_values=1.0)
    return longer, jnp.where(beyond < 0, wide, 1.0)


def _near(
    tables: DeviceTables, placed: PlacedEdges, attack_batch: AttackBatch
) -> tuple[Int[Array, " K"], Int[Array, " K"]]:
    """The first and last frame at which an attack may reach each walk; the last is −1 if never.

    A single sphere is looked at in every fourth frame, and from as much farther as it and the root
    can move in two. Of several each frame is looked at, since each comes and goes for itself.
    """
    lanes = placed.count.shape[0]
    stride = STRIDE if attack_batch.sphere_slots == 1 else 1
    frames = attack_batch.number(AttackColumn.FRAME_COUNT)[None].astype(jnp.int32)
    slowest = jnp.min(placed.rows[..., PlacedColumn.SCALE], axis=0)
    speed = attack_batch.number(AttackColumn.SPEED) + tables.root_speed / slowest
    away = (stride // 2) / EXPORT_RATE * speed + (tables.seam if stride > 1 else 0.0)
    reach = (attack_batch.number(AttackColumn.MARGIN) + away)[None, :, None] + attack_batch.spheres[
        None, :, 0
    ]
    born, gone = attack_batch.spheres[None, :, 1], attack_batch.spheres[None, :, 2]

    def chunk(k: Array, known: tuple[Array, Array]) -> tuple[Array, Array]:
        index = (k * CHUNK_FRAMES + jnp.arange(CHUNK_FRAMES, dtype=jnp.int32))[:, None] * stride
        index = jnp.minimum(jnp.broadcast_to(index, (CHUNK_FRAMES, lanes)), frames - 1)
        times = frame_times(attack_batch, index)
        x, y, z = root_at(tables, locate(tables, placed, times))
        span = 1.01 * stride / EXPORT_RATE
        alive = (times[..., None] >= born - span) & (times[..., None] <= gone + span)
        if stride > 1:
            centres = centres_at(attack_batch, jnp.clip(times, born[..., 0], gone[..., 0]))
        else:
            centres = centres_at_frames(attack_batch, index)
        dx, dy, dz = (centres[..., k::3] - axis[..., None] for k, axis in enumerate((x, y, z)))
        gap = jnp.sqrt(dx * dx + dy * dy + dz * dz)
        # Nothing is certain after the end of a walk, wherever the attack is then.
        over = (times > placed.stop[None] - span)[..., None]
        near = jnp.any(((gap <= reach) | over) & alive, axis=-1)
        first, last = known
        low = jnp.min(jnp.where(near, index - stride // 2, frames), axis=0)
        high = jnp.max(jnp.where(near, index + stride // 2, -1), axis=0)
        return jnp.minimum(first, low), jnp.maximum(last, high)

    most = jnp.max(frames)
    chunks = ((most + stride - 2) // stride + CHUNK_FRAMES) // CHUNK_FRAMES
    never = jnp.full(lanes, -1, jnp.int32)
    first, last = jax.lax.fori_loop(0, chunks, chunk, (jnp.full_like(never, 1 << 30), never))
    return jnp.maximum(first - 1, 0), jnp.minimum(last + 1, frames[0] - 1)


def _over_frames(
    tables: DeviceTables,
    placed: PlacedEdges,
    attack_batch: AttackBatch,
    first: Int[Array, " K"],
    last: Int[Array, " K"],
    quick: Array,
) -> tuple[Array, Array, Array]:
    """Clearance, its lower bound, and when contact is certain. Each [K]

    ``CHUNK_FRAMES`` frames at a time; each chunk begins with the last frame of the chunk before.
    """
    sag = attack_batch.number(AttackColumn.SAG)[None]

    def chunk(k: Array, known: tuple[Array, ...]) -> tuple[Array, ...]:
        number = jnp.arange(CHUNK_FRAMES, dtype=jnp.int32)[:, None]
        index = first[None] + k * (CHUNK_FRAMES - 1) + number
        inside = index[1:] <= last[None]
        index = jnp.minimum(index, last[None])
        times = frame_times(attack_batch, index)
        keys = locate(tables, placed, times)
        centres = centres_at_frames(attack_batch, index)
        body = spheres_at(tables, keys)
        gap, surely = (
            jnp.where(inside, distance - sag, FAR)
            for distance in _gaps(tables, body, attack_batch, times, centres)
        )
        chord_error = chord_errors_at(tables, keys)
        doubt = _ARCS * jnp.maximum(chord_error[1:], chord_error[:-1]) + ROUNDING_M
        doubt = jnp.where(quick[None] | (times[1:] > placed.stop[None]), FAR, doubt)
        least = jnp.where(gap < FAR / 2, gap - doubt, FAR)
        most = surely + 2 * sag + doubt
        touched = (surely < FAR / 2) & (most < CLEAR_M)
        begin = times[:-1]
        figures = (
            surely,
            least,
            jnp.where(touched, begin, FAR),
        )
        return tuple(
            jnp.minimum(old, jnp.min(new, axis=0)) for old, new in zip(known, figures, strict=True)
        )

    chunks = (jnp.max(last - first) + CHUNK_FRAMES - 2) // (CHUNK_FRAMES - 1)
    far = jnp.full(first.shape, FAR, jnp.float32)
    return jax.lax.fori_loop(0, chunks, chunk, (far, far, far))


def _gaps(
    tables: DeviceTables,
    body: Float[Array, "3 W K S"],
    attack_batch: AttackBatch,
    times: Float[Array, "W K"],
    centres: Float[Array, "W K D"],
) -> tuple[Float[Array, "V K"], Float[Array, "V K"]]:
    """Least swept distance in each interval of the times: of spheres that are there at any moment
    of it, and of those that are there throughout; ``FAR`` where none is."""
    slots = attack_batch.sphere_slots
    present = active_at(attack_batch, times)
    throughout, partly = present[1:] & present[:-1], lives_between(attack_batch, times)
    each = jnp.moveaxis(centres.reshape(*centres.shape[:2], slots, 3), (2, 3), (0, 1))

    def one(sphere: Array, radius: Array) -> Array:
        relative = [sphere[k][..., None] - body[k] for k in range(3)]
        begin = [r[:-1] for r in relative]
        move = [r[1:] - r[:-1] for r in relative]
        along = sum(m * m for m in move)
        share = -sum(b * m for b, m in zip(begin, move, strict=True))
        share = jnp.clip(share / jnp.maximum(along, 1e-20), 0.0, 1.0)
        square = sum((b + share * m) ** 2 for b, m in zip(begin, move, strict=True))
        return jnp.min(jnp.sqrt(square) - tables.radii[None, None], axis=-1) - radius[None]

    def masked(near: Array, partly: Array, throughout: Array) -> tuple[Array, Array]:
        return jnp.where(partly, near, FAR), jnp.where(throughout, near, FAR)

    radii = attack_batch.spheres[:, 0]
    if slots == 1:
        return masked(one(each[0], radii[:, 0]), partly[..., 0], throughout[..., 0])

    def step(k: Array, least: tuple[Array, Array]) -> tuple[Array, Array]:
        near = one(each[k], radii[:, k])
        own = masked(near, partly[..., k], throughout[..., k])
        return jnp.minimum(least[0], own[0]), jnp.minimum(least[1], own[1])

    count = jnp.max(attack_batch.number(AttackColumn.SPHERE_COUNT)).astype(jnp.int32)
    far = jnp.full((times.shape[0] - 1, times.shape[1]), FAR, jnp.float32)
    return jax.lax.fori_loop(0, count, step, (far, far))
