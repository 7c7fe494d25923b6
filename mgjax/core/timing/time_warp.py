"""Time warps: a captured motion that is played with a speed of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


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

    times: Float[np.ndarray, " K"]
    positions: Float[np.ndarray, " K"]
    speeds: Float[np.ndarray, " K"]

    def at(self, times: Float[np.ndarray, " T"]) -> Float[np.ndarray, " T"]:
        """The captured moments that are shown at the given times."""
        i, rate = self._piece(self.times, times)
        since = times - self.times[i]
        return self.positions[i] + since * (self.speeds[i] + 0.5 * rate * since)

    def speed(self, times: Float[np.ndarray, " T"]) -> Float[np.ndarray, " T"]:
        """Speed at the given times; at a jump, that after it."""
        i, rate = self._piece(self.times, times)
        return self.speeds[i] + rate * (times - self.times[i])

    def when(self, positions: Float[np.ndarray, " T"]) -> Float[np.ndarray, " T"]:
        """Times at which captured moments are shown: the inverse of :meth:`at`.

        The speed must nowhere be 0.
        """
        i, rate = self._piece(self.positions, positions)
        far = positions - self.positions[i]
        begin = self.speeds[i]
        # Stable also where the speed hardly changes: x = (v + v') / 2 · t.
        end = np.sqrt(np.maximum(begin**2 + 2 * rate * far, 0.0))
        return self.times[i] + 2 * far / (begin + end)

    def _piece(self, knots: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The last knot before each value, and the change of speed per second after it."""
        i = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 1)
        durations = np.diff(self.times)
        rates = np.divide(
            np.diff(self.speeds), durations, out=np.zeros(len(durations)), where=durations > 0
        )
        rates = np.append(rates, 0.0)
        return i, np.where(at < knots[0], 0.0, rates[i])


def even_warp(times: Float[np.ndarray, " K"], positions: Float[np.ndarray, " K"]) -> TimeWarp:
    """The warp that shows some captured moments at some times, with one speed between two of them.

    Args:
        times: of playback, ascending; of several equal ones the last counts. [K]
        positions: captured time, ascending. [K]
    """
    durations = np.diff(times)
    speeds = np.divide(
        np.diff(positions), durations, out=np.ones(len(durations)), where=durations > 0
    )
    return TimeWarp(
        times=np.repeat(times, 2),
        positions=np.repeat(positions, 2),
        speeds=np.concatenate([[1.0], np.repeat(speeds, 2), [1.0]]),
    )
