"""Bounds on the clearance of a few walks at once, from the table of body volumes.

The written motion turns joints by slerp; the table's spheres move straight from frame to frame.
What that can differ is known (:mod:`mgjax.avoidance.bend`), so the clearance of the motion as it
would be written lies within bounds. Where they leave no doubt nothing else needs to be looked at.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attack import Attack
from mgjax.avoidance.body_reader import Laid, find, lay, root_at, spheres_at
from mgjax.avoidance.candidates import NO_EDGE
from mgjax.avoidance.check import CLEAR_M, EXPORT_RATE, FAR
from mgjax.avoidance.device_tables import DeviceTables
from mgjax.avoidance.evaluate import padded_spheres
from mgjax.core.arrays import Array
from mgjax.core.padding import bucket_size
from mgjax.core.pytree import register

LANES = 4
"""Walks that are looked at with the ranking: the winner is nearly always among the first."""

MORE_LANES = 32
"""Walks that are looked at together after those."""

FOLLOWING = 8
"""Edges that are played after the path, each the longest that leaves its node."""

FRAMES = 256
"""Written frames of an attack that a call is compiled for, and four times as many, …"""

WINDOW_SHARE = 4
"""One in so many of them is the window in which an attack may be near a walk."""

ROUNDING_M = 1e-4
"""Beside twice the bend: what 32 bits and the written motion's own frames differ by."""

_BENDS = 2.0
"""A written frame lies between two frames of the graph, and the body moves between two written
frames along yet another arc: each differs from a straight line by one bend at most."""


@register()
@dataclass(frozen=True, kw_only=True)
class Flight:
    """An attack at the frames of the written motion, from now to its end.

    Attributes:
        times: s, the last repeated as padding. [N]
        centres: of its spheres, m. [3, N, I]
        present: whether each sphere is there from one time to the next. [N1, I]
        radii: m. [I]
        margin: how near to the body's reach a sphere has to come to be looked at, m.
        sag: how far spheres stray from straight lines between two times, m.
    """

    times: Float[Array, " N"]
    centres: Float[Array, "3 N I"]
    present: Bool[Array, "N1 I"]
    radii: Float[Array, " I"]
    margin: Float[Array, ""]
    sag: Float[Array, ""]


@register()
@dataclass(frozen=True, kw_only=True)
class Bounds:
    """What is certain about some walks.

    Attributes:
        edges, scales: the walks with what follows them. [K, M]
        clearance: of the table's body, m. [K]
        least: the clearance of the written motion is at least this. [K]
        doubt_from: seconds until which the walk is certainly clear; ``FAR`` if throughout. [K]
        touched_from: seconds from which it is certainly touched; ``FAR`` if not certainly. [K]
        path_end: when the path is over, s. [K]
    """

    edges: Int[Array, "K M"]
    scales: Float[Array, "K M"]
    clearance: Float[Array, " K"]
    least: Float[Array, " K"]
    doubt_from: Float[Array, " K"]
    touched_from: Float[Array, " K"]
    path_end: Float[Array, " K"]


def make_flight(attack: Attack, reach: float) -> Flight:
    """An attack at the frames of the written motion, padded to one of few sizes.

    ``reach`` is how far any point of the body can be from its root, m.
    """
    begin, end = max(attack.start, 0.0), attack.end
    first = int(np.floor(begin * EXPORT_RATE))
    last = max(int(np.ceil(end * EXPORT_RATE)), first + 1)
    step = 1 / EXPORT_RATE
    margin = reach + attack.largest_speed * step + 0.1
    size = _size(attack, last - first + 1, margin)
    times = np.clip((first + np.arange(size)) * step, begin, max(end, begin))
    centres, there, radii = padded_spheres(attack, times)
    present = there[:-1] & there[1:]
    present[last - first :] = False
    curve = (attack.acceleration + _kinks(attack, step)) * step**2 / 8
    return Flight(
        times=times.astype(np.float32),
        centres=centres,
        present=present,
        radii=radii,
        margin=np.asarray(margin, dtype=np.float32),
        sag=np.asarray(curve, dtype=np.float32),
    )


def _size(attack: Attack, frames: int, margin: float) -> int:
    """Frames that an attack is padded to: all of it, and a window as long as it may be near."""
    way = np.linalg.norm(np.diff(attack.centres, axis=0), axis=-1).sum(axis=0)
    speed = float(way.min()) / max(attack.end - attack.start, 1e-6)
    near = 1.15 * 2 * (margin + float(attack.radii.max())) / max(speed, 1e-6) * EXPORT_RATE
    return bucket_size(max(frames, min(int(near), frames) * WINDOW_SHARE), FRAMES, 4)


def _kinks(attack: Attack, step: float) -> float:
    """Acceleration whose bend over ``step`` covers the corners at an attack's knots, m/s².

    Cutting a corner of Δv costs Δv · step/4 at most, several within a step the sum of theirs. The
    knots of a smooth flight bend by no more than its acceleration says.
    """
    if len(attack.times) < 3:
        return 0.0
    span = np.diff(attack.times)
    velocity = np.diff(attack.centres, axis=0) / span[:, None, None]
    turns = np.linalg.norm(np.diff(velocity, axis=0), axis=-1)
    smooth = attack.acceleration * 0.5 * (span[1:] + span[:-1])
    excess = np.maximum(turns - smooth[:, None] * 1.01 - 1e-6, 0.0)
    if not excess.any():
        return 0.0
    total = np.concatenate([[0.0], np.cumsum(excess.max(axis=1))])
    knots = attack.times[1:-1]
    upto = np.searchsorted(knots, knots + step, side="right")
    return float((total[upto] - total[:-1]).max()) * 2 / step


def certify(
    tables: DeviceTables,
    edges: Int[Array, "K L"],
    scales: Float[Array, "K L"],
    length: Int[Array, " K"],
    flight: Flight,
    *,
    frame_rate: float,
) -> Bounds:
    """Bounds on the clearance of walks and of what follows them by default.

    Args:
        tables: of the graph.
        edges, scales, length: the walks; a length of 0 is padding.
        flight: the attack.
        frame_rate: of the graph.

    Where an attack is near a walk for longer than the window nothing is certain.
    """
    window = flight.times.shape[0] // WINDOW_SHARE
    edges, scales = _go_on(tables, edges, scales, length)
    laid = lay(tables, edges, scales)
    path_end = laid.ends[jnp.arange(len(length)), jnp.maximum(length - 1, 0)]
    which, overflow = _near(tables, laid, flight, window)
    times = flight.times[which]
    where = find(tables, laid, times)
    gap = _gaps(tables, spheres_at(tables, where), flight, which) - flight.sag
    # Sped up further, a walk would pass several frames of the graph between two written ones.
    quick = jnp.any((edges != NO_EDGE) & (scales * EXPORT_RATE < frame_rate * 0.999), axis=1)
    unknown = (overflow | quick)[None] | (times[1:] > laid.stop[None])
    doubt = _BENDS * jnp.maximum(where.bend[1:], where.bend[:-1]) + ROUNDING_M
    doubt = jnp.where(unknown, FAR, doubt)
    active = gap < FAR / 2
    least = jnp.where(active, gap - doubt, FAR)
    most = gap + 2 * flight.sag + doubt
    begin = times[:-1]
    return Bounds(
        edges=edges,
        scales=scales,
        clearance=jnp.min(gap, axis=0),
        least=jnp.min(least, axis=0),
        doubt_from=jnp.min(jnp.where(least < CLEAR_M, begin, FAR), axis=0),
        touched_from=jnp.min(jnp.where(active & (most < CLEAR_M), begin, FAR), axis=0),
        path_end=path_end,
    )


def _go_on(
    tables: DeviceTables,
    edges: Int[Array, "K L"],
    scales: Float[Array, "K L"],
    length: Int[Array, " K"],
) -> tuple[Array, Array]:
    """The walks with the longest edges appended, at natural speed."""
    rows = jnp.arange(len(length))
    last = edges[rows, jnp.maximum(length - 1, 0)]

    def step(edge: Array, _: None) -> tuple[Array, Array]:
        following = tables.next_edge[jnp.maximum(edge, 0)]
        return following, following

    _, more = jax.lax.scan(step, last, None, length=FOLLOWING)
    column = jnp.arange(edges.shape[1] + FOLLOWING)[None]
    beyond = column - length[:, None]
    added = more.T[rows[:, None], jnp.clip(beyond, 0, FOLLOWING - 1)]
    padded = jnp.pad(edges, ((0, 0), (0, FOLLOWING)), constant_values=NO_EDGE)
    follows = (beyond >= 0) & (beyond < FOLLOWING) & (length > 0)[:, None]
    longer = jnp.where(beyond < 0, padded, jnp.where(follows, added, NO_EDGE))
    wide = jnp.pad(scales, ((0, 0), (0, FOLLOWING)), constant_values=1.0)
    return longer, jnp.where(beyond < 0, wide, 1.0)


def _near(
    tables: DeviceTables, laid: Laid, flight: Flight, window: int
) -> tuple[Int[Array, "W K"], Bool[Array, " K"]]:
    """For each walk the times around those at which the attack may reach it; whether too many."""
    count = laid.stop.shape[0]
    times = jnp.broadcast_to(flight.times[:, None], (flight.times.shape[0], count))
    x, y, z = root_at(tables, find(tables, laid, times))
    dx, dy, dz = (flight.centres[k][:, None] - axis for k, axis in enumerate((x, y, z)))
    gap = jnp.sqrt(dx * dx + dy * dy + dz * dz) - flight.radii[None, None]
    there = jnp.concatenate([flight.present, jnp.zeros_like(flight.present[:1])])
    there = there | jnp.roll(there, 1, axis=0)
    near = jnp.any((gap <= flight.margin) & there[:, None], axis=-1)
    index = jnp.arange(near.shape[0])[:, None]
    first = jnp.min(jnp.where(near, index, near.shape[0]), axis=0)
    last = jnp.max(jnp.where(near, index, -1), axis=0)
    first = jnp.clip(first - 1, 0, near.shape[0] - window)
    which = first[None] + jnp.arange(window)[:, None]
    return which, last + 1 > first + window - 1


def _gaps(
    tables: DeviceTables,
    body: tuple[Array, Array, Array],
    flight: Flight,
    which: Int[Array, "W K"],
) -> Float[Array, "V K"]:
    """Least swept distance in each interval of the times; ``FAR`` where no sphere is there."""

    def one(centres: Array, radius: Array, present: Array) -> Array:
        relative = [centres[k][which][..., None] - axis for k, axis in enumerate(body)]
        begin = [r[:-1] for r in relative]
        move = [r[1:] - r[:-1] for r in relative]
        along = sum(m * m for m in move)
        share = -sum(b * m for b, m in zip(begin, move, strict=True))
        share = jnp.clip(share / jnp.maximum(along, 1e-20), 0.0, 1.0)
        square = sum((b + share * m) ** 2 for b, m in zip(begin, move, strict=True))
        near = jnp.min(jnp.sqrt(square) - tables.radii[None, None], axis=-1) - radius
        return jnp.where(present[which[:-1]], near, FAR)

    there = jnp.concatenate([flight.present, jnp.zeros_like(flight.present[:1])])
    spheres = (jnp.moveaxis(flight.centres, 2, 0), flight.radii, there.T)
    if flight.radii.shape[0] == 1:
        return one(*(x[0] for x in spheres))

    def step(least: Array, sphere: tuple) -> tuple[Array, None]:
        return jnp.minimum(least, one(*sphere)), None

    far = jnp.full((which.shape[0] - 1, which.shape[1]), FAR, jnp.float32)
    return jax.lax.scan(step, far, spheres)[0]
