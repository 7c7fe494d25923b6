"""Where a motion sensor sends to, and how a recorded clip is played as one.

Neither jax nor numpy is imported here.
"""

from __future__ import annotations

from dataclasses import dataclass

from mgjax.core.ranges import Ranges, check_range, check_ranges

HOST = "127.0.0.1"
"""Loopback: nothing from outside this machine is heard unless another address is given."""
PORT = 39539
"""On which receivers of the VMC protocol commonly listen."""


@dataclass(frozen=True, kw_only=True)
class ReplayConfig:
    """How a clip is played as a stream of packets, and what goes wrong on its way.

    Attributes:
        rate: frames sent per second of motion; None is the rate of the clip.
        speed: seconds of motion per second. Time stamps are those of the motion, so a receiver
            finds the same velocities at any speed.
        loss: share of packets that never arrive.
        reorder: share of packets that arrive after those of the next frame.
        jitter_s: each packet is late by a random time up to this, s.
        seed: draws all of these.
    """

    rate: float | None = None
    speed: float = 1.0
    loss: float = 0.0
    reorder: float = 0.0
    jitter_s: float = 0.0
    seed: int = 0


_RANGES: Ranges = {
    "speed": (1e-3, 10000.0),
    "loss": (0.0, 1.0),
    "reorder": (0.0, 1.0),
    "jitter_s": (0.0, 10.0),
    "seed": (0, 2**63),
}
_RATES = (1e-3, 10000.0)


def validate_replay(config: ReplayConfig) -> None:
    """Raises :class:`ConfigError` unless a clip can be sent so."""
    check_ranges(config, _RANGES)
    if config.rate is not None:
        check_range("rate", config.rate, *_RATES)
