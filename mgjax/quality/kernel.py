"""All measures of many motions in one compiled call: curves over time, and their figures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register
from mgjax.quality import feet as of_feet
from mgjax.quality.in_body import self_penetration
from mgjax.quality.limits import CapturedRanges, beyond
from mgjax.quality.smoothness import (
    normalised_jerk,
    velocity_jumps,
    window_frames,
    windows_counted,
)
from mgjax.quality.speeds import speed_histogram
from mgjax.quality.subject import Subject
from mgjax.quality.tracks import RATE, SKATE_RATE, Tracks


@register()
@dataclass(frozen=True, kw_only=True, eq=False)
class Extremes:
    """What capture itself does at most; without it, what may not be done at all.

    Attributes:
        jerk: 99.9 % quantile of the normalised jerk of each joint that turns. [n]
        apart: least distance of each pair of capsules, m. [P]
        ranges: angles of the joints; None: nothing is said of them.
    """

    jerk: Float[Array, " n"]
    apart: Float[Array, " P"]
    ranges: CapturedRanges | None


@register()
@dataclass(frozen=True, kw_only=True, eq=False)
class Curves:
    """Measures over time, and which of their values count.

    Steps lead from a frame to the next. Those of feet are missing where there are none.

    Attributes:
        skates: whether a foot skates, by steps at 20 Hz. [M, G1]
        toe_speed: m/s, by steps. [M, F1, 2]
        contact: whether the toe touches the floor then. [M, F1, 2]
        slide: of toes and ankles, m, by steps. [M, F1, 4]
        sink: of toes and ankles, m. [M, F, 4]
        height: of toes and ankles, m. [M, F, 4]
        over: of the lower foot over where it rests, m, and whether it stands. [M, F1] each
        jerk: of each joint that turns, by windows that begin at a frame. [M, W, n]
        jump: of each joint's velocity at inner frames, m/s. [M, F2, J]
        depth: of limbs in the body, m. [M, F]
        outside: of joints' ranges, swing and twist, degrees. [M, F, k, 2]
        steps, toe_steps, frames, inner, windows: which count.
    """

    skates: Bool[Array, "*m G1"]
    toe_speed: Float[Array, "*m F1 T"]
    contact: Bool[Array, "*m F1 T"]
    slide: Float[Array, "*m F1 R"]
    sink: Float[Array, "*m F R"]
    height: Float[Array, "*m F R"]
    over: Float[Array, "*m F1"]
    stands: Bool[Array, "*m F1"]
    jerk: Float[Array, "*m W n"]
    jump: Float[Array, "*m F2 J"]
    depth: Float[Array, "*m F"]
    outside: Float[Array, "*m F k 2"]
    steps: Bool[Array, "*m F1"]
    toe_steps: Bool[Array, "*m G1"]
    frames: Bool[Array, "*m F"]
    inner: Bool[Array, "*m F2"]
    windows: Bool[Array, "*m W"]


def curves(track: Tracks, subject: Subject, extremes: Extremes) -> Curves:
    """The measures of one motion over time; the tracks have no leading axis."""
    places, scale = track.places, subject.scale
    count, (first, last) = track.counts, track.spans
    frames = places.shape[0]
    feet = places[:, subject.feet]
    has_feet = bool(subject.feet.shape[0])
    toes = feet[:, :2]
    zero = jnp.zeros(frames - 1, places.dtype)
    skates = jnp.zeros(track.toes.shape[0] - 1, bool)
    over, stands = zero, zero > 0
    if has_feet:
        skates = of_feet.skating(track.toes, track.toe_counts, rate=SKATE_RATE, scale=scale)
        over, stands = of_feet.floating(toes, track.rests[:2], rate=RATE, scale=scale)
    speed, contact = of_feet.contact_speeds(toes, rate=RATE, scale=scale)
    turning = places[:, subject.joints]
    jerk = normalised_jerk(turning, rate=RATE, scale=scale)
    outside = jnp.zeros((frames, 1, 2), places.dtype)
    if extremes.ranges is not None:
        outside = beyond(track.turns, extremes.ranges)
    counted = partial(of_feet.counted, first=first, last=last)
    return Curves(
        skates=skates,
        toe_speed=speed,
        contact=contact,
        slide=of_feet.slides(feet, track.rests, rate=RATE, scale=scale),
        sink=of_feet.sunk(feet),
        height=feet[..., 1],
        over=over,
        stands=stands,
        jerk=jerk,
        jump=velocity_jumps(places, rate=RATE),
        depth=self_penetration(subject.pairs, places, extremes.apart),
        outside=outside,
        steps=counted(frames - 1, 1),
        toe_steps=of_feet.counted(
            track.toes.shape[0] - 1, 1, first=track.toe_spans[0], last=track.toe_spans[1]
        ),
        frames=counted(frames, 0),
        # A jump at the first or the last of the counted frames is one of theirs, too.
        inner=of_feet.counted(
            frames - 2,
            2,
            first=jnp.maximum(first - 1, 0),
            last=jnp.minimum(last + 1, count - 1),
        ),
        windows=windows_counted(jerk.shape[0], window_frames(RATE), count, first, last),
    )


def figures(found: Curves, subject: Subject, extremes: Extremes) -> dict[str, Array]:
    """The figures of one motion; NaN where it shows nothing of the kind (no contact, no window)."""
    touches = found.contact & found.steps[:, None]
    above = found.jerk / extremes.jerk[None]
    windows = found.windows[:, None]
    stands = found.stands & found.steps
    return {
        "skate_ratio": _mean(found.skates, found.toe_steps),
        "contact_speed": _mean(found.toe_speed, touches),
        "contact_fast": _mean(found.toe_speed > of_feet.FAST_M_S * subject.scale, touches),
        "skate_cm": 100 * _mean(found.slide, found.steps[:, None]),
        "normalised_jerk": jnp.exp(_mean(jnp.log(jnp.maximum(found.jerk, 1e-12)), windows)),
        "jerky": _mean(above > 1, windows),
        "jerk_ratio": _largest(above, windows),
        "velocity_jump": _largest(found.jump, found.inner[:, None]),
        "sink": _largest(found.sink, found.frames[:, None]),
        "floating": _mean(found.over, stands),
        "self_penetration": _largest(found.depth, found.frames),
        "limits": _largest(found.outside, found.frames[:, None, None]),
    }


@jax.jit
def measured(tracks: Tracks, subject: Subject, extremes: Extremes) -> dict[str, Array]:
    """The figures of many motions. [M] each"""

    def one(track: Tracks) -> dict[str, Array]:
        return figures(curves(track, subject, extremes), subject, extremes)

    return jax.vmap(one)(tracks)


@jax.jit
def measured_curves(tracks: Tracks, subject: Subject, extremes: Extremes) -> Curves:
    """The measures of many motions over time."""
    return jax.vmap(lambda track: curves(track, subject, extremes))(tracks)


@jax.jit
def speeds(tracks: Tracks, subject: Subject) -> Float[Array, "M J B"]:
    """The histograms of joint speeds of many motions."""

    def one(track: Tracks) -> Array:
        steps = of_feet.counted(track.places.shape[0] - 1, 1, track.spans[0], track.spans[1])
        return speed_histogram(track.places, steps, rate=RATE, scale=subject.scale)

    return jax.vmap(one)(tracks)


def no_extremes(subject: Subject) -> Extremes:
    """Where no capture is given: jerk as it is, limbs not in the body at all, no ranges."""
    return Extremes(
        jerk=np.ones(len(subject.joints), np.float32),
        apart=np.zeros(len(subject.pairs.reach), np.float32),
        ranges=None,
    )


def _mean(values: Array, on: Array) -> Array:
    on = jnp.broadcast_to(on, values.shape)
    count = jnp.sum(on.astype(jnp.float32))
    total = jnp.sum(jnp.where(on, values.astype(jnp.float32), 0.0))
    return jnp.where(count > 0, total / jnp.maximum(count, 1.0), jnp.nan)


def _largest(values: Array, on: Array) -> Array:
    on = jnp.broadcast_to(on, values.shape)
    if not values.size:
        return jnp.full((), jnp.nan, jnp.float32)
    return jnp.where(jnp.any(on), jnp.max(jnp.where(on, values, -jnp.inf)), jnp.nan)
