"""Where and when a ball meets the body that is shown, and how it flies on from there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.body.spheres import BodySpheres
from mgjax.ballsport import BallPhysics, fly

RATE = 240.0
"""Moments a second at which ball and body are compared."""
RESTITUTION = 0.35
TAIL_S = 1.6
"""How long a ball is followed after its flight."""
_TAIL_RATE = 30.0
_LIMBS = {
    "shoulder": "upper arm",
    "elbow": "forearm",
    "wrist": "hand",
    "hip": "thigh",
    "knee": "shin",
    "ankle": "foot",
}
_TRUNK = {"root": "pelvis", "chest": "chest", "neck": "neck", "head": "head"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Contact:
    """A ball that meets a body.

    Attributes:
        time: s.
        place: the ball's centre then, m. [3]
        velocity: of the ball after it, m/s. [3]
        part: of the body, in words.
    """

    time: float
    place: Float[np.ndarray, "3"]
    velocity: Float[np.ndarray, "3"]
    part: str


def first_contact(
    attack: Attack,
    spheres: BodySpheres,
    times: Float[np.ndarray, " T"],
    centres: Float[np.ndarray, "T S 3"],
) -> Contact | None:
    """The first moment at which the ball of an attack touches the body, if it does.

    Args:
        attack: one ball, in the world.
        spheres: of the body.
        times: of its poses, s, ascending.
        centres: of its spheres then, straight in between, m.
    """
    first, last = max(times[0], attack.start), min(times[-1], attack.end)
    if last <= first:
        return None
    moments = np.linspace(first, last, int(np.ceil((last - first) * RATE)) + 1)
    low = np.clip(np.searchsorted(times, moments, side="right") - 1, 0, len(times) - 2)
    share = ((moments - times[low]) / (times[low + 1] - times[low]))[:, None, None]
    body = centres[low] * (1 - share) + centres[low + 1] * share
    ball = attack.at(moments)[:, 0]
    gaps = np.linalg.norm(ball[:, None] - body, axis=-1) - spheres.radii - attack.radii[0]
    touched = np.flatnonzero(gaps.min(axis=1) < 0)
    if not touched.size:
        return None
    k = int(touched[0])
    sphere = int(np.argmin(gaps[k]))
    way = ball[k] - body[k, sphere]
    size = float(np.linalg.norm(way))
    normal = way / size if size > 1e-6 else np.array([0.0, 1.0, 0.0])
    step = 1 / RATE
    ahead = attack.at(np.array([moments[k] - step / 2, moments[k] + step / 2]))[:, 0]
    velocity = (ahead[1] - ahead[0]) / step
    against = float(velocity @ normal)
    if against < 0:
        velocity = velocity - (1 + RESTITUTION) * against * normal
    return Contact(
        time=float(moments[k]), place=ball[k], velocity=velocity, part=part_of(spheres, sphere)
    )


def part_of(spheres: BodySpheres, number: int) -> str:
    """The part of the body that a sphere belongs to, in words."""
    joint = spheres.names[number].split("-")[0]
    side, _, end = joint.rpartition("_")
    return f"{side} {_LIMBS[end]}" if end in _LIMBS else _TRUNK.get(joint, joint)


def track(
    attack: Attack, contact: Contact | None, radius: float
) -> tuple[Float[np.ndarray, " K"], Float[np.ndarray, "K 3"]]:
    """The ball's way: its flight, to the contact if there is one, and how it falls and rolls on."""
    if contact is None:
        times, places = attack.times, attack.centres[:, 0]
        step = 1e-3
        ends = attack.at(np.array([attack.end - step, attack.end]))[:, 0]
        velocity = (ends[1] - ends[0]) / step
    else:
        before = attack.times < contact.time
        times = np.append(attack.times[before], contact.time)
        places = np.concatenate([attack.centres[before, 0], contact.place[None]])
        velocity = contact.velocity
    since = np.arange(1, round(TAIL_S * _TAIL_RATE) + 1) / _TAIL_RATE
    start = np.array([places[-1, 0], max(places[-1, 1], radius), places[-1, 2]])
    tail = fly(
        start.astype(np.float32),
        velocity.astype(np.float32),
        np.concatenate([[0.0], since]).astype(np.float32),
        physics=BallPhysics(radius=radius),
    )
    return np.concatenate([times, times[-1] + since]), np.concatenate(
        [places, np.asarray(tail)[1:]]
    )
