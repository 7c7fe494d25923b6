"""Settings of reaching. Neither jax nor numpy is imported here."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ReachConfig:
    """How hands and head reach on a walk.

    Attributes:
        limits: keep the joint limits of :mod:`mgjax.hybrid.reach_limits`.
        extend: walk towards a target that is out of reach.
        stop: stand still for a target that the walk passes too quickly to hold it.
        blend_s: over this time the walk's pose gives way to the reaching one, and returns, s. It
            is lengthened where a joint would turn too fast.
        turn_deg_s: joints turn at most so fast, or as fast as in the walk itself, degrees/s.
        drop_m: the pelvis goes down by at most so much, m.
        arrive_m: the end of a limb counts as having arrived within this distance, m.
        hold_m: and as staying within this, m.
        radius_m: radius of the turns on the way to a target, m.
    """

    limits: bool = True
    extend: bool = True
    stop: bool = True
    blend_s: float = 0.6
    turn_deg_s: float = 720.0
    drop_m: float = 0.5
    arrive_m: float = 0.01
    hold_m: float = 0.005
    radius_m: float = 0.7
