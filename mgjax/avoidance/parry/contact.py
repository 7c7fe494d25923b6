"""Where an attack first meets a motion: by the capsules of the body, exactly as it is written.

Between two moments of the check, 240 a second, joints and spheres move straight
(:mod:`mgjax.avoidance.checks.written`). Intervals in which a sphere may be within reach are looked
at in 32 steps; in between nothing can come nearer than the speeds allow, and the moment of a
contact is then found by halving.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.core.body.capsules import Capsules

_STEPS = 32
_HALVINGS = 24


@dataclass(frozen=True, kw_only=True, eq=False)
class Contact:
    """Where a sphere of an attack first meets a capsule of the body.

    Attributes:
        time: s.
        capsule: its number.
        place: on the surface of the capsule, m. [3]
        share: place along the capsule's bone, 0 … 1.
        square: cosine between the sphere's way and the direction in which it presses on the
            capsule: 1 head on, 0 grazing.
        along: cosine between that way and the capsule's bone, 0 … 1: 0 where it lies across.
    """

    time: float
    capsule: int
    place: Float[np.ndarray, "3"]
    share: float
    square: float
    along: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    """Joints of a motion at the moments of the check."""

    times: Float[np.ndarray, " T"]
    positions: Float[np.ndarray, "T J 3"]

    def at(self, times: Float[np.ndarray, " M"]) -> Float[np.ndarray, "M J 3"]:
        """Places between the moments, straight from each to the next, m."""
        index = np.clip(
            np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2
        )
        step = self.times[index + 1] - self.times[index]
        share = ((times - self.times[index]) / step)[:, None, None]
        return self.positions[index] * (1 - share) + self.positions[index + 1] * share


def first_contact(
    capsules: Capsules,
    track: Track,
    attack: Attack,
    sphere: int,
    among: Bool[np.ndarray, " B"] | None = None,
) -> Contact | None:
    """The first contact of one sphere of an attack with a body; None where there is none.

    Args:
        capsules: of the body.
        track: its motion.
        attack: the attack; its times as those of the track.
        sphere: its number.
        among: capsules that count; default: all.
    """
    chosen = np.arange(len(capsules.radii)) if among is None else np.flatnonzero(among)
    starts, stops = attack.lifetimes
    first, last = max(starts[sphere], track.times[0]), min(stops[sphere], track.times[-1])
    if first >= last or not len(chosen):
        return None
    moments = np.unique(np.concatenate([[first, last], track.times, attack.times]))
    moments = moments[(moments >= first) & (moments <= last)]

    def gaps(times: np.ndarray) -> np.ndarray:
        return _gaps(capsules, track, attack, sphere, chosen, times)[0]

    ends = gaps(moments).min(axis=1)
    moved = _moved(track, attack, sphere, moments)
    near = np.flatnonzero(np.minimum(ends[:-1], ends[1:]) - 0.5 * moved <= 0)
    for interval in near.tolist():
        fine = np.linspace(moments[interval], moments[interval + 1], _STEPS + 1)
        touched = np.flatnonzero(gaps(fine).min(axis=1) <= 0)
        if len(touched):
            after = int(touched[0])
            span = fine[max(after - 1, 0)], fine[after]
            return _contact(capsules, track, attack, sphere, chosen, span)
    return None


def least_gap(
    capsules: Capsules,
    track: Track,
    attack: Attack,
    sphere: int,
    among: Bool[np.ndarray, " B"],
    until: float,
) -> float:
    """A lower bound of the distance of a sphere to some capsules until a moment, m.

    It is low by at most what both move in a thirty-second of the time between two moments of the
    check.
    """
    chosen = np.flatnonzero(among)
    starts, stops = attack.lifetimes
    first, last = max(starts[sphere], track.times[0]), min(stops[sphere], track.times[-1], until)
    if first > last or not len(chosen):
        return np.inf
    moments = np.unique(np.concatenate([[first, last], track.times, attack.times]))
    moments = moments[(moments >= first) & (moments <= last)]
    ends = _gaps(capsules, track, attack, sphere, chosen, moments)[0].min(axis=1)
    if len(moments) < 2:
        return float(ends.min())
    moved = _moved(track, attack, sphere, moments)
    bound = np.minimum(ends[:-1], ends[1:]) - 0.5 * moved
    for interval in np.argsort(bound):
        if bound[interval] > ends.min():
            break
        fine = np.linspace(moments[interval], moments[interval + 1], _STEPS + 1)
        inner = _gaps(capsules, track, attack, sphere, chosen, fine)[0].min()
        bound[interval] = inner - 0.5 * moved[interval] / _STEPS
    return float(bound.min())


def _moved(
    track: Track, attack: Attack, sphere: int, moments: Float[np.ndarray, " M"]
) -> Float[np.ndarray, " M1"]:
    """By how much a distance changes at most from each moment to the next, m."""
    joints = np.linalg.norm(np.diff(track.at(moments), axis=0), axis=-1).max(axis=1)
    return joints + np.linalg.norm(np.diff(attack.at(moments)[:, sphere], axis=0), axis=-1)


def _gaps(
    capsules: Capsules,
    track: Track,
    attack: Attack,
    sphere: int,
    chosen: np.ndarray,
    times: Float[np.ndarray, " M"],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distance of surfaces, m, way from the sphere to each capsule's bone, and shares along it."""
    a, b = (x[:, chosen] for x in capsules.ends(track.at(times)))
    axis = b - a
    centre = attack.at(times)[:, sphere, None]
    along = np.maximum((axis * axis).sum(axis=-1), 1e-12)
    share = np.clip(((centre - a) * axis).sum(axis=-1) / along, 0.0, 1.0)
    way = a + share[..., None] * axis - centre
    gap = np.linalg.norm(way, axis=-1) - capsules.radii[chosen] - attack.radii[sphere]
    return gap, way, share


def _contact(
    capsules: Capsules,
    track: Track,
    attack: Attack,
    sphere: int,
    chosen: np.ndarray,
    span: tuple[float, float],
) -> Contact:
    """The contact between two moments, of which only the second is in contact."""
    low, high = span
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        touched = _gaps(capsules, track, attack, sphere, chosen, np.array([middle]))[0].min() <= 0
        low, high = (low, middle) if touched else (middle, high)
    gap, way, share = (
        x[0] for x in _gaps(capsules, track, attack, sphere, chosen, np.array([high]))
    )
    row = int(np.argmin(gap))
    press = way[row] / max(float(np.linalg.norm(way[row])), 1e-9)
    number = int(chosen[row])
    centre = attack.at(np.array([high]))[0, sphere]
    a, b = (x[0, number] for x in capsules.ends(track.at(np.array([high]))))
    bone, comes = (b - a) / np.linalg.norm(b - a), way_of(attack, sphere, float(high))
    return Contact(
        time=float(high),
        capsule=number,
        place=centre + way[row] - press * capsules.radii[number],
        share=float(share[row]),
        square=float(press @ comes),
        along=float(abs(bone @ comes)),
    )


def way_of(attack: Attack, sphere: int, time: float) -> Float[np.ndarray, "3"]:
    """Unit vector along which a sphere moves at a moment; 0 where it stands still."""
    starts, stops = attack.lifetimes
    around = np.clip(np.array([time - 1e-3, time + 1e-3]), starts[sphere], stops[sphere])
    step = np.diff(attack.at(around)[:, sphere], axis=0)[0]
    length = float(np.linalg.norm(step))
    return step / length if length > 1e-6 else np.zeros(3)
