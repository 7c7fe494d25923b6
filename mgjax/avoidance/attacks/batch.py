"""Attacks as compiled code reads them: where they are at the frames of the written motion."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import IntEnum

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.attacks.sag import sag_of
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.core.arrays import Array
from mgjax.core.xla.padding import bucket_size
from mgjax.core.xla.pytree import register

FRAME_BUCKET = 256
"""Frames of an attack that a call is compiled for, and thirty-two times as many."""

MOMENTS = 4
"""At which a body is compared with one that does not react; more change no choice that matters."""

SPHERE_BUCKET = 1
"""Spheres of an attack that a call is compiled for, and eight times as many, …"""

_ABSENT_S = -1e9
"""Life of the spheres that pad an attack."""

_ROUNDING_S = 1e-5
"""A sphere that is there from a moment on is there at this moment in 32 bits, too."""


class AttackColumn(IntEnum):
    """Columns of :attr:`AttackBatch.numbers` before those of the spheres."""

    T_ATTACK = 0
    """The middle of the crop, s."""
    CROP_START = 1
    CROP_END = 2
    EVALUATED = 3
    """How many evenly spaced times are evaluated over the crop."""
    SPHERE_COUNT = 4
    BEGIN = 5
    """When what counts of the attack begins, s."""
    END = 6
    FIRST_FRAME = 7
    """The first frame of the written motion that counts; the next one tells how many do."""
    FRAME_COUNT = 8
    MARGIN = 9
    """How near to the body's reach a sphere has to come to be looked at, m."""
    SAG = 10
    """How far spheres stray from straight lines between two frames, m."""
    SPEED = 11
    """The largest of the spheres, m/s."""


_NUMBERS = len(AttackColumn)
"""Columns before those of the spheres."""


@register()
@dataclass(frozen=True, kw_only=True)
class AttackBatch:
    """Some attacks, each in the planar frame of its node; time counts from now.

    Between two frames centres move straight; the motion is compared with them at frames.

    Attributes:
        frames: x, y and z of every sphere at the frames of the written motion from the first that
            counts, m; before the attack begins and after it ends it is held. [A, N, 3·I]
        numbers: what is known of each attack, by :class:`AttackColumn`; then all that ``spheres``
            has. [A, 12+3·I]
        unmoved: x of all spheres of the body that does not react, then y, then z, padded, at
            evenly spaced moments of which the last is the end of the crop, m. [A, K, 3·S]
    """

    frames: Float[Array, "A N D"]
    numbers: Float[Array, "A M"]
    unmoved: Float[Array, "A K B"]

    @property
    def spheres(self) -> Float[Array, "A 3 I"]:
        """Radius in m, first and last second of each sphere; those that pad never come."""
        return self.numbers[:, _NUMBERS:].reshape(self.numbers.shape[0], 3, -1)

    @property
    def sphere_slots(self) -> int:
        """Spheres with their padding."""
        return self.frames.shape[2] // 3

    @property
    def is_long(self) -> bool:
        """Whether they have so many frames that they are padded to the larger size."""
        return self.frames.shape[1] > FRAME_BUCKET

    def as_long(self) -> AttackBatch:
        """The same attacks padded to the larger size, as it goes with long walks."""
        if self.is_long:
            return self
        beyond = bucket_size(FRAME_BUCKET + 1, FRAME_BUCKET, 32) - self.frames.shape[1]
        frames = np.pad(np.asarray(self.frames), ((0, 0), (0, beyond), (0, 0)), mode="edge")
        return replace(self, frames=frames)

    def number(self, column: AttackColumn) -> Float[Array, " A"]:
        """One of the numbers of all attacks."""
        return self.numbers[:, column]

    def of(self, owner: Int[Array, " C"]) -> AttackBatch:
        """The attack of each candidate, by number."""
        return AttackBatch(
            frames=self.frames[owner], numbers=self.numbers[owner], unmoved=self.unmoved[owner]
        )


def empty_attack_batch(frames: int, spheres: int, columns: int) -> AttackBatch:
    """One attack that is nowhere, of a size that calls are compiled for.

    Args:
        frames, spheres: of the attack.
        columns: coordinates of a body, with their padding.
    """
    numbers = np.full((1, _NUMBERS + 3 * spheres), _ABSENT_S, np.float32)
    numbers[0, :_NUMBERS] = 0
    return AttackBatch(
        frames=np.zeros((1, frames, 3 * spheres), np.float32),
        numbers=numbers,
        unmoved=np.zeros((1, MOMENTS, columns), np.float32),
    )


def make_attack_batch(
    attack: Attack,
    crop: Crop,
    config: AvoidanceConfig,
    reach: float,
    unmoved: Float[np.ndarray, "K B"] | None = None,
) -> AttackBatch:
    """One attack, padded to one of few sizes.

    Args:
        attack, crop: the attack, and the part of it that counts for timing and energies.
        config: settings.
        reach: how far any point of the body can be from its root, m.
        unmoved: the body that does not react, which only the movement energy needs; see
            :class:`AttackBatch`.
    """
    begin, end = max(attack.start, 0.0), attack.end
    # The frames of the written motion at which it counts.
    first = math.floor(begin * EXPORT_RATE)
    last = max(math.ceil(end * EXPORT_RATE), first + 1)
    step = 1 / EXPORT_RATE
    count, spheres = last - first + 1, len(attack.radii)
    slots = bucket_size(spheres, SPHERE_BUCKET, 8)
    times = np.arange(first, last + 1) * step
    frames = np.empty((1, bucket_size(count, FRAME_BUCKET, 32), 3 * slots), np.float32)
    frames[0, :, 3 * spheres :] = 0
    if attack.starts is None and attack.stops is None:
        for k, column in enumerate(attack.centres.reshape(len(attack.times), -1).T):
            frames[0, :count, k] = np.interp(times, attack.times, column)
    else:
        frames[0, :count, : 3 * spheres] = _lived(attack, times).reshape(count, -1)
    frames[0, count:] = frames[0, count - 1]
    numbers = np.full((1, _NUMBERS + 3 * slots), _ABSENT_S, np.float32)
    speed = attack.largest_speed
    numbers[0, :_NUMBERS] = (
        crop.middle,
        crop.start,
        crop.end,
        evaluated(attack, crop, config),
        spheres,
        begin,
        max(end, begin),
        first,
        count,
        reach + speed * step + 0.1,
        sag_of(attack, step),
        speed,
    )
    life = numbers[0, _NUMBERS:].reshape(3, slots)
    life[0, :spheres] = attack.radii
    life[1, :spheres] = attack.start if attack.starts is None else attack.starts
    life[2, :spheres] = attack.end if attack.stops is None else attack.stops
    if unmoved is None:
        unmoved = np.zeros((MOMENTS, 0), np.float32)
    return AttackBatch(frames=frames, numbers=numbers, unmoved=unmoved[None])


def evaluated(attack: Attack, crop: Crop, config: AvoidanceConfig) -> int:
    """How many evenly spaced times over the crop are evaluated.

    They are at most min(1/20 s, radius / speed) apart (§4.2).
    """
    quickest = float(attack.radii.min()) / max(attack.largest_speed, 1e-6)
    step = min(config.evaluation_step_s, quickest)
    return max(math.ceil((crop.end - crop.start) / step) + 1, 2)


def _lived(attack: Attack, times: Float[np.ndarray, " T"]) -> Float[np.ndarray, "T I 3"]:
    """Centres at frames; at the last frame before a sphere's life, and the first after it, where it
    would be if it had moved on straight, so that between frames it is where it is."""
    frames = attack.at(times)
    starts, stops = (moments.tolist() for moments in attack.lifetimes)
    for k, (begin, end) in enumerate(zip(starts, stops, strict=True)):
        inner = np.flatnonzero((times > begin) & (times < end))
        for moment, outside, inside in (
            (begin, int(times.searchsorted(begin)) - 1, inner[0] if inner.size else None),
            (end, int(times.searchsorted(end, "right")), inner[-1] if inner.size else None),
        ):
            if not 0 <= outside < len(times):
                continue
            other = (end if moment == begin else begin) if inside is None else times[inside]
            if other == moment:
                continue
            at, beside = attack.at(np.array([moment, other]))[:, k]
            frames[outside, k] = at + (beside - at) * ((times[outside] - moment) / (other - moment))
    return frames


def centres_at(attack_batch: AttackBatch, times: Float[Array, "T A"]) -> Float[Array, "T A D"]:
    """Where the spheres of each attack are at times of its own, m; D is x, y, z of each."""
    _, size, _ = attack_batch.frames.shape
    begin, end, first = (
        attack_batch.number(k)[None]
        for k in (AttackColumn.BEGIN, AttackColumn.END, AttackColumn.FIRST_FRAME)
    )
    times = jnp.clip(times, begin, end)
    low = jnp.clip(jnp.floor(times * EXPORT_RATE - first), 0.0, size - 2)
    # The first and last frame stand for the moments at which the attack begins and ends.
    before = jnp.clip((first + low) / EXPORT_RATE, begin, end)
    after = jnp.clip((first + low + 1) / EXPORT_RATE, begin, end)
    share = jnp.clip((times - before) / jnp.maximum(after - before, 1e-9), 0.0, 1.0)[..., None]
    row = _rows(attack_batch, low.astype(jnp.int32))
    frames = attack_batch.frames.reshape(-1, attack_batch.frames.shape[2])
    return frames[row] * (1 - share) + frames[row + 1] * share


def centres_at_frames(attack_batch: AttackBatch, index: Int[Array, "W A"]) -> Float[Array, "W A D"]:
    """Where the spheres are at frames of the written motion, counted from each attack's first."""
    frames = attack_batch.frames.reshape(-1, attack_batch.frames.shape[2])
    return frames[_rows(attack_batch, jnp.clip(index, 0, attack_batch.frames.shape[1] - 1))]


def _rows(attack_batch: AttackBatch, index: Int[Array, "T A"]) -> Int[Array, "T A"]:
    """Rows of the frames of all attacks, one after the other."""
    attacks, size, _ = attack_batch.frames.shape
    return index + (jnp.arange(attacks, dtype=jnp.int32) * size)[None]


def active_at(attack_batch: AttackBatch, times: Float[Array, "T A"]) -> Bool[Array, "T A I"]:
    """Whether each sphere of each attack is there."""
    slack = _ROUNDING_S + 1e-6 * jnp.abs(times[..., None])
    after = times[..., None] >= attack_batch.spheres[None, :, 1] - slack
    return after & (times[..., None] <= attack_batch.spheres[None, :, 2] + slack)


def lives_between(attack_batch: AttackBatch, times: Float[Array, "T A"]) -> Bool[Array, "V A I"]:
    """Whether each sphere of each attack is there at any moment between two times."""
    slack = _ROUNDING_S + 1e-6 * jnp.abs(times[..., None])
    born, gone = attack_batch.spheres[None, :, 1], attack_batch.spheres[None, :, 2]
    return (times[1:, ..., None] >= born - slack[1:]) & (times[:-1, ..., None] <= gone + slack[:-1])


def evaluation_times(attack_batch: AttackBatch, index: Int[Array, " T"]) -> Float[Array, "T A"]:
    """The evaluated times of each attack by number; beyond the last it is repeated."""
    start, end, count = (
        attack_batch.number(k)[None]
        for k in (AttackColumn.CROP_START, AttackColumn.CROP_END, AttackColumn.EVALUATED)
    )
    share = jnp.minimum(index.astype(jnp.float32)[:, None] / (count - 1), 1.0)
    return start + share * (end - start)


def frame_times(attack_batch: AttackBatch, index: Int[Array, "N A"]) -> Float[Array, "N A"]:
    """The times of frames of the written motion, counted from each attack's first."""
    frame = attack_batch.number(AttackColumn.FIRST_FRAME)[None] + index.astype(jnp.float32)
    return jnp.clip(
        frame / EXPORT_RATE,
        attack_batch.number(AttackColumn.BEGIN)[None],
        attack_batch.number(AttackColumn.END)[None],
    )
