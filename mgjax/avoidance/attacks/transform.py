"""Attacks seen from another place and moment, and in another unit of length."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.core import planar


def in_frame(attack: Attack, place: Float[np.ndarray, "3"], begins: float) -> Attack:
    """An attack of the world in a planar frame, its times counted from ``begins`` s."""
    inverse = np.asarray(planar.inverse(place))
    centres = np.asarray(planar.apply(inverse, attack.centres.astype(np.float64)))
    return replace(shifted(attack, begins), centres=centres)


def of_size(attack: Attack, factor: float) -> Attack:
    """An attack whose places and spheres are so many times as large, at the same times."""
    if factor == 1:
        return attack
    return replace(
        attack,
        centres=attack.centres * factor,
        radii=attack.radii * factor,
        acceleration=attack.acceleration * factor,
    )


def shifted(attack: Attack, begins: float) -> Attack:
    """An attack with its times counted from ``begins`` s."""
    return replace(
        attack,
        times=attack.times - begins,
        starts=None if attack.starts is None else attack.starts - begins,
        stops=None if attack.stops is None else attack.stops - begins,
    )


def after(attack: Attack, now: float) -> Attack:
    """What comes from ``now`` s on of an attack that ends later, without spheres that are gone."""
    if attack.start >= now:
        return attack
    here = attack.at(np.array([now]))
    later = attack.times > now
    left = np.ones(len(attack.radii), bool) if attack.stops is None else attack.stops >= now
    return replace(
        attack,
        times=np.concatenate([[now], attack.times[later]]),
        centres=np.concatenate([here, attack.centres[later]])[:, left],
        radii=attack.radii[left],
        starts=None if attack.starts is None else np.maximum(attack.starts, now)[left],
        stops=None if attack.stops is None else attack.stops[left],
    )
