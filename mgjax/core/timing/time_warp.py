"""Time warps: a captured motion that is played with a speed of its own.

NumPy in gives NumPy out. With jax arrays all is differentiable with respect to times, positions and
knots; which two knots a time lies between has no slope.
"""

from __future__ import annotations

from dataclasses import dataclass

from jaxtyping import Float, Int

from mgjax.core.arrays import Array, namespace
from mgjax.core.xla.pytree import register


@register()
@dataclass(frozen=True, kw_only=True, eq=False)
class TimeWarp:
    """Which moment of a motion, as captured, is shown when; both count in the same unit.

    The speed (captured time per time of playback) is linear between knots, and 1 before the first
    and after the last; two knots of one time are a jump.

    Attributes:
        times: of playback, ascending. [K]
        positions: captured time, ascending. [K]
        speeds: at the knots, not negative; the first and the last are 1. [K]
    """

    times: Float[Array, " K"]
    positions: Float[Array, " K"]
    speeds: Float[Array, " K"]

    def at(self, times: Float[Array, " T"]) -> Float[Array, " T"]:
        """The captured moments that are shown at the given times."""
        knots, positions, speeds = self._arrays(times)
        i, rate = self._piece(knots, times)
        since = times - knots[i]
        return positions[i] + since * (speeds[i] + 0.5 * rate * since)

    def speed(self, times: Float[Array, " T"]) -> Float[Array, " T"]:
        """Speed at the given times; at a jump, that after it."""
        knots, _, speeds = self._arrays(times)
        i, rate = self._piece(knots, times)
        return speeds[i] + rate * (times - knots[i])

    def when(self, positions: Float[Array, " T"]) -> Float[Array, " T"]:
        """Times at which captured moments are shown: the inverse of :meth:`at`.

        The speed must nowhere be 0.
        """
        xp = namespace(positions, *self._fields)
        times, knots, speeds = self._arrays(positions)
        i, rate = self._piece(knots, positions)
        far = positions - knots[i]
        begin = speeds[i]
        # Stable also where the speed hardly changes: x = (v + v') / 2 · t.
        end = xp.sqrt(xp.maximum(begin**2 + 2 * rate * far, 0.0))
        return times[i] + 2 * far / (begin + end)

    @property
    def _fields(self) -> tuple[Array, Array, Array]:
        return self.times, self.positions, self.speeds

    def _arrays(self, asked: Array) -> tuple[Array, Array, Array]:
        """Times, positions and speeds as arrays that a traced number may index."""
        xp = namespace(asked, *self._fields)
        times, positions, speeds = (xp.asarray(values) for values in self._fields)
        return times, positions, speeds

    def _piece(
        self, knots: Float[Array, " K"], at: Float[Array, " T"]
    ) -> tuple[Int[Array, " T"], Float[Array, " T"]]:
        """The last knot before each value, and the change of speed per second after it."""
        xp = namespace(knots, at)
        times, _, speeds = self._arrays(at)
        i = xp.clip(xp.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 1)
        durations = xp.diff(times)
        longer = durations > 0
        rates = xp.where(longer, xp.diff(speeds) / xp.where(longer, durations, 1.0), 0.0)
        rates = xp.concatenate([rates, xp.zeros(1, rates.dtype)])
        return i, xp.where(at < knots[0], 0.0, rates[i])


def even_warp(times: Float[Array, " K"], positions: Float[Array, " K"]) -> TimeWarp:
    """The warp that shows some captured moments at some times, with one speed between two of them.

    Args:
        times: of playback, ascending; of several equal ones the last counts. [K]
        positions: captured time, ascending. [K]
    """
    xp = namespace(times, positions)
    durations = xp.diff(times)
    longer = durations > 0
    speeds = xp.where(longer, xp.diff(positions) / xp.where(longer, durations, 1.0), 1.0)
    one = xp.ones(1, speeds.dtype)
    return TimeWarp(
        times=xp.repeat(times, 2),
        positions=xp.repeat(positions, 2),
        speeds=xp.concatenate([one, xp.repeat(speeds, 2), one]),
    )


def scaled_warp(durations: Float[Array, " L"], scales: Float[Array, " L"]) -> TimeWarp:
    """The warp of pieces that are each played at one speed, from 0 on.

    Args:
        durations: of the pieces as captured.
        scales: factors on these, greater than 0.
    """
    xp = namespace(durations, scales)

    def ends(each: Array) -> Array:
        return xp.repeat(xp.concatenate([xp.zeros(1, each.dtype), xp.cumsum(each)]), 2)

    one = xp.ones(1, scales.dtype)
    return TimeWarp(
        times=ends(durations * scales),
        positions=ends(durations),
        speeds=xp.concatenate([one, xp.repeat(1 / scales, 2), one]),
    )
