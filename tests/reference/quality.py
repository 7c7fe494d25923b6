"""The measures of motion, written from their definitions: float64, one motion, loops."""

from __future__ import annotations

import numpy as np


def skate_ratio(toes, scale=1.0):
    """[F, 2, 3] at 20 Hz: GMD."""
    steps = len(toes) - 1
    speed = np.zeros((steps, 2))
    for i in range(steps):
        for side in range(2):
            dx, _, dz = toes[i + 1, side] - toes[i, side]
            speed[i, side] = np.hypot(dx, dz) * 20
    skates = 0
    for i in range(steps):
        either = False
        for side in range(2):
            around = [speed[k, side] for k in range(i - 2, i + 3) if 0 <= k < steps]
            low = max(toes[i, side, 1], toes[i + 1, side, 1]) < 0.05 * scale
            fast = speed[i, side] > 0.5 * scale and sum(around) / 5 > 0.5 * scale
            either |= low and fast
        skates += either
    return skates / steps


def contact_speed(toes, rate=30.0, scale=1.0):
    """[F, 2, 3]: the mean speed of toes below 5 cm, and the share above 0.2 m/s."""
    found = [
        np.linalg.norm(toes[i + 1, side] - toes[i, side]) * rate
        for i in range(len(toes) - 1)
        for side in range(2)
        if toes[i, side, 1] < 0.05 * scale
    ]
    return np.mean(found), np.mean(np.array(found) > 0.2 * scale)


def skate_cm(feet, rests, scale=1.0):
    """[F, 4, 3] at 30 Hz: MANN, cm."""
    total = 0.0
    for i in range(len(feet) - 1):
        for joint in range(4):
            height = max(feet[i, joint, 1] - rests[joint], 0.0)
            if height < 0.025 * scale:
                dx, _, dz = feet[i + 1, joint] - feet[i, joint]
                total += np.hypot(dx, dz) * (2 - 2 ** (height / (0.025 * scale)))
    return 100 * total / (4 * (len(feet) - 1))


def normalised_jerk(places, rate=30.0, scale=1.0):
    """[F, J, 3] → [W, J]: T⁵ ∫ |jerk|² dt / path² in windows of 0.4 s."""
    steps = round(0.4 * rate)
    seconds = steps / rate
    out = []
    for start in range(len(places) - steps):
        window = places[start : start + steps + 1]
        jerk = np.diff(window, n=3, axis=0) * rate**3
        mean = (np.linalg.norm(jerk, axis=-1) ** 2).mean(axis=0)
        path = np.linalg.norm(np.diff(window, axis=0), axis=-1).sum(axis=0)
        out.append(seconds**5 * mean * seconds / np.maximum(path, 1e-4 * scale) ** 2)
    return np.array(out)


def velocity_jump(places, rate=30.0):
    velocity = np.diff(places, axis=0) * rate
    return np.linalg.norm(np.diff(velocity, axis=0), axis=-1).max()


def floating(toes, rests, rate=30.0, scale=1.0):
    """[F, 2, 3]: the mean height over its rest of the lower toe while that one stands, m."""
    found = []
    for i in range(len(toes) - 1):
        over = [toes[i, side, 1] - rests[side] for side in range(2)]
        side = 0 if over[0] < over[1] else 1
        speed = np.linalg.norm(toes[i + 1, side] - toes[i, side]) * rate
        if toes[i, side, 1] < 0.05 * scale and speed < 0.2 * scale:
            found.append(over[side])
    return np.mean(found) if found else np.nan


def histogram(places, rate=30.0, scale=1.0):
    """[F, J, 3] → [J, 64]: steps by speed in bins of 0.1 m/s."""
    counts = np.zeros((places.shape[1], 64))
    for i in range(len(places) - 1):
        for joint in range(places.shape[1]):
            speed = np.linalg.norm(places[i + 1, joint] - places[i, joint]) * rate / scale
            counts[joint, min(int(speed / 0.1), 63)] += 1
    return counts


def hellinger(first, second):
    p, q = first / first.sum(), second / second.sum()
    return np.linalg.norm(np.sqrt(p) - np.sqrt(q)) / np.sqrt(2)


def angles(rotation, centre, bone, across):
    """Swing about two axes and twist, rad: rotation = centre · swing · twist, wxyz."""
    relative = product(conjugate(centre), rotation)
    along = relative[1:] @ bone
    twist = 2 * np.arctan2(along, relative[0])
    twist = (twist + np.pi) % (2 * np.pi) - np.pi
    spin = np.concatenate([[np.cos(twist / 2)], np.sin(twist / 2) * bone])
    swing = product(relative, conjugate(spin))
    swing = swing if swing[0] >= 0 else -swing
    size = np.linalg.norm(swing[1:])
    vector = swing[1:] / size * 2 * np.arctan2(size, swing[0]) if size > 1e-9 else np.zeros(3)
    return np.array([vector @ across, vector @ np.cross(bone, across)]), twist


def product(a, b):
    w = a[0] * b[0] - a[1:] @ b[1:]
    return np.concatenate([[w], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])])


def conjugate(q):
    return q * [1, -1, -1, -1]
