"""The stored hit that is most like a live one."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.ballsport.clipset.build import ClipSet
from mgjax.ballsport.config import MatchConfig, validate_match
from mgjax.ballsport.hits.motion_vectors import MotionVectors, scaled
from mgjax.core.arrays import Array
from mgjax.core.errors import MotionError
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.core.xla.pytree import register


@register()
@dataclass(frozen=True, kw_only=True)
class StoredHits:
    """Motion vectors of many hits, components first, hits last, padded to a fixed size.

    Attributes:
        displacements: m.
        seconds: s.
        v_max: m/s.
        valid: False where it is padding or must not be found.
    """

    displacements: Float[Array, "4 3 N"]
    seconds: Float[Array, "4 N"]
    v_max: Float[Array, " N"]
    valid: Bool[Array, " N"]


@dataclass(frozen=True, kw_only=True)
class Match:
    """A stored hit and how far the live one is from it.

    Attributes:
        hit: its number in the clip set.
        distance: D_m.
    """

    hit: int
    distance: float


def store(vectors: MotionVectors, allowed: Bool[np.ndarray, " N"] | None = None) -> StoredHits:
    """Puts motion vectors ``[N]`` on the device in the layout of the search.

    Raises:
        MotionError: there is none, or ``allowed`` leaves none.
    """
    count = len(np.asarray(vectors.v_max))
    allowed = np.ones(count, bool) if allowed is None else allowed
    if not allowed.any():
        raise MotionError("got no stored hit to compare with, expected at least one")
    size = bucket_size(count, 64)

    def last(values: Array) -> jax.Array:
        padded = pad_axis(np.asarray(values, np.float32), size, value=0.0)
        return jnp.asarray(np.moveaxis(padded, 0, -1).copy())

    return StoredHits(
        displacements=last(vectors.displacements),
        seconds=last(vectors.seconds),
        v_max=last(vectors.v_max),
        valid=jnp.asarray(pad_axis(allowed, size, value=0.0)),
    )


def distances(
    live: MotionVectors, stored: StoredHits, weights: Float[Array, "3"]
) -> Float[Array, " N"]:
    """D_m (Choi et al. 2019, eq. 2) of one live hit to all stored ones; infinite where not valid.

    Deviation: the paper prints v_max of one motion alone in the first term; a difference is meant.

    Args:
        live: one motion vector.
        stored: the others.
        weights: of speed (per m/s), displacements (per m) and times (per s).
    """
    away = live.displacements[:, :, None] - stored.displacements
    total = weights[0] * jnp.abs(live.v_max - stored.v_max)
    # Bounded from below, so that the gradient is finite where two displacements are equal.
    lengths = jnp.sqrt(jnp.maximum(jnp.sum(away * away, axis=1), 1e-20))
    total = total + weights[1] * jnp.sum(lengths, axis=0)
    total = total + weights[2] * jnp.sum(jnp.abs(live.seconds[:, None] - stored.seconds), axis=0)
    return jnp.where(stored.valid, total, jnp.inf)


@jax.jit
def nearest(
    live: MotionVectors, stored: StoredHits, weights: Float[Array, "3"]
) -> tuple[Int[Array, "*b"], Float[Array, "*b"]]:
    """Number and distance of the nearest stored hit for one live hit or for each of ``[B]``.

    Of equal distances the first is taken.
    """

    def one(vector: MotionVectors) -> tuple[Array, Array]:
        values = distances(vector, stored, weights)
        least = jnp.min(values)
        # Much faster than an argmin on this backend: the first place that holds the minimum.
        place = jnp.arange(values.shape[0], dtype=jnp.int32)
        return jnp.min(jnp.where(values == least, place, values.shape[0] - 1)), least

    return one(live) if jnp.ndim(live.v_max) == 0 else jax.vmap(one)(live)


def match_weights(config: MatchConfig) -> Float[np.ndarray, "3"]:
    """The weights as an array; :class:`ConfigError` unless they are usable."""
    validate_match(config)
    return np.array([config.w_v, config.w_m, config.w_t], np.float32)


class Matcher:
    """Finds the hit of a clip set that a live motion resembles; ready for many calls."""

    def __init__(self, clips: ClipSet, config: MatchConfig | None = None) -> None:
        self._weights = jnp.asarray(match_weights(config or MatchConfig()))
        self._legs = clips.leg_length
        bones = np.array(clips.hit_bone)
        self._stored = {
            bone: store(clips.vectors, bones == bone) for bone in sorted(set(clips.hit_bone))
        }

    @property
    def bones(self) -> Collection[str]:
        """What the stored hits hit with."""
        return self._stored.keys()

    def match(self, live: MotionVectors, bone: str, leg_length: float) -> Match:
        """The most similar stored hit of the same bone.

        Which bone hits is known from the analysis of the live motion, which finds hits bone by
        bone.

        Args:
            live: motion vector of one live hit.
            bone: the bone in whose path it was found.
            leg_length: of the live body, m; the motion is scaled to the body of the clip set.

        Raises:
            MotionError: no stored hit of that bone, legs of no length, or a vector that is not
                finite.
        """
        if bone not in self._stored:
            raise MotionError(f"got a hit of {bone!r}, expected one of {', '.join(self._stored)}")
        if not 0 < leg_length < np.inf:
            raise MotionError(f"got a leg of {leg_length} m, expected a positive length")
        vector = scaled(live, self._legs / leg_length)
        hit, distance = nearest(vector, self._stored[bone], self._weights)
        if not np.isfinite(float(distance)):
            raise MotionError("got a motion vector with numbers that are not finite")
        return Match(hit=int(hit), distance=float(distance))
