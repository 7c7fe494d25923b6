"""The energies of one path, in plain float64 loops, written from the definitions."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np


def segment_distance(p0: np.ndarray, p1: np.ndarray) -> float:
    """Least distance to the origin of a point that moves linearly from ``p0`` to ``p1``."""
    step = p1 - p0
    length2 = float(step @ step)
    s = 0.0 if length2 == 0.0 else min(1.0, max(0.0, -float(p0 @ step) / length2))
    return float(np.linalg.norm(p0 + s * step))


def sampled_distance(p0: np.ndarray, p1: np.ndarray, count: int = 2001) -> float:
    """The same by dense sampling: too large, by at most half a sample's step."""
    s = np.linspace(0.0, 1.0, count)[:, None]
    return float(np.linalg.norm((1 - s) * p0 + s * p1, axis=1).min())


def clearance(attack, attack_radii, body, body_radii, active, distance=segment_distance) -> float:
    """Least D(attack, body) over the active times and the intervals between two of them."""
    best = math.inf
    for i in range(attack.shape[1]):
        for j in range(body.shape[1]):
            radii = attack_radii[i] + body_radii[j]
            for t in range(len(active)):
                if not active[t]:
                    continue
                now = attack[t, i] - body[t, j]
                best = min(best, float(np.linalg.norm(now)) - radii)
                if t > 0 and active[t - 1]:
                    before = attack[t - 1, i] - body[t - 1, j]
                    best = min(best, distance(before, now) - radii)
    return best


def penetration(attack, attack_radii, body, body_radii, start, counted, dt, form) -> float:
    """e', eqs 4–5: ``counted`` are the times in the avoidance part with the attack active."""
    total = 0.0
    for t in np.flatnonzero(counted):
        for i in range(attack.shape[1]):
            for j in range(body.shape[1]):
                radii = attack_radii[i] + body_radii[j]
                at_start = float(np.linalg.norm(attack[t, i] - start[j])) - radii
                at_time = float(np.linalg.norm(attack[t, i] - body[t, j])) - radii
                if form == "paper":
                    x = at_start - at_time
                else:
                    x = max(0.0, -at_time) - max(0.0, -at_start)
                total += max(0.0, -x) * dt
    return total


def frozen_body(body, start, avoidance_mask) -> np.ndarray:
    """The counterfactual: the body until the first true entry of the mask, then ``start``."""
    frozen = np.array(body, np.float64)
    entries = np.flatnonzero(avoidance_mask)
    if len(entries):
        frozen[entries[0] :] = start
    return frozen


def energies(
    attack, attack_radii, body, body_radii, start, avoidance_mask, active_mask, *, dt, config
) -> SimpleNamespace:
    """Eqs 4–8 for one path; ``d`` and ``d0`` are infinite where no time is active."""
    attack, body, start = (np.asarray(a, np.float64) for a in (attack, body, start))
    attack_radii, body_radii = (np.asarray(a, np.float64) for a in (attack_radii, body_radii))
    avoidance_mask, active_mask = np.asarray(avoidance_mask), np.asarray(active_mask)
    moved = penetration(
        attack,
        attack_radii,
        body,
        body_radii,
        start,
        avoidance_mask & active_mask,
        dt,
        config.form,
    )
    d = clearance(attack, attack_radii, body, body_radii, active_mask)
    held = frozen_body(body, start, avoidance_mask)
    d0 = clearance(attack, attack_radii, held, body_radii, active_mask)
    compared = max(d0, 0.0) if config.d0 == "clamped" else d0
    between = compared < d < compared + config.D_body
    return SimpleNamespace(
        avoidance=max(0.0, 1.0 - moved / config.E_avoidance),
        body=(d - compared) / config.D_body if between else 1.0,
        penetration=moved,
        d=d,
        d0=d0,
    )


def displacement(moved, still) -> float:
    """Mean distance of the spheres of one body from those of another, over moments. [T, S, 3]"""
    total, count = 0.0, 0
    for one, other in zip(moved, still, strict=True):
        for a, b in zip(one, other, strict=True):
            total += math.dist(np.asarray(a, np.float64), np.asarray(b, np.float64))
            count += 1
    return total / count


def time_scale_energy(s: float, limit: float, w_speed_up: float = 1.0) -> float:
    """Eq. 9, what speeding up adds to 1/limit times so much."""
    return s / limit if s > 1 else (1 + w_speed_up * (1 / s - 1)) / limit
