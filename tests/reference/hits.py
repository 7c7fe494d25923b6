"""Hits of one bone, in plain loops written from the definitions."""

from __future__ import annotations

import math


def smooth(values: list[float], rate: float, seconds: float) -> list[float]:
    """Gaussian mean over three standard deviations to either side, of the frames there are."""
    half = math.ceil(3 * seconds * rate - 1e-9)
    result = []
    for f in range(len(values)):
        total = weight = 0.0
        for k in range(-half, half + 1):
            if 0 <= f + k < len(values):
                w = math.exp(-0.5 * (k / (seconds * rate)) ** 2) if half else 1.0
                total, weight = total + w * values[f + k], weight + w
        result.append(total / weight)
    return result


def curves(path, rate: float, seconds: float) -> tuple[list[float], list[float]]:
    """Height and speed, from a path of (x, y, z)."""
    x, y, z = (smooth([float(p[i]) for p in path], rate, seconds) for i in range(3))
    count, speed = len(path), []
    for f in range(count):
        a, b = max(f - 1, 0), min(f + 1, count - 1)
        step = math.sqrt((x[b] - x[a]) ** 2 + (y[b] - y[a]) ** 2 + (z[b] - z[a]) ** 2)
        speed.append(step * rate / (b - a))
    return y, speed


def maxima(curve: list[float]) -> list[int]:
    return [
        f for f in range(1, len(curve) - 1) if curve[f - 1] < curve[f] and curve[f] >= curve[f + 1]
    ]


def marks(height, speed, rate: float, config) -> tuple[list[int], list[int]]:
    """F_H, and F_S after merging."""
    highest = [f for f in maxima(height) if height[f] > config.height_m]
    ripples = maxima(speed)
    fastest = []
    for a in ripples:
        beaten = False
        for b in ripples:
            stronger = speed[b] > speed[a] or (speed[b] == speed[a] and b < a)
            close = abs(a - b) < config.merge_s * rate - 1e-6
            between = any(min(a, b) <= h < max(a, b) for h in highest)
            beaten |= b != a and stronger and close and not between
        if not beaten:
            fastest.append(a)
    return highest, fastest


def neighbours(fastest, top: int, reach: int) -> tuple[int | None, int | None]:
    before = [f for f in fastest if f <= top]
    after = [f for f in fastest if f > top]
    first = before[-1] if before and top - before[-1] <= reach else None
    last = after[0] if after and after[0] - top <= reach else None
    return first, last


def hits(path, rate: float, config) -> list[dict]:
    """All hits, each as a dict of frames."""
    height, speed = curves(path, rate, config.smoothing_s)
    highest, fastest = marks(height, speed, rate, config)
    reach = round(config.reach_s * rate)
    groups: list[dict] = []
    for top in highest:
        near = [f for f in neighbours(fastest, top, reach) if f is not None]
        if not near:
            continue
        chosen = near[0] if len(near) == 1 or speed[near[0]] >= speed[near[1]] else near[1]
        if groups and groups[-1]["fastest"] in (chosen, top):
            groups[-1]["highest"].append(top)
        else:
            groups.append({"fastest": chosen, "highest": [top]})
    result: list[dict] = []
    for i, group in enumerate(groups):
        first = min(group["fastest"], group["highest"][0])
        last = max(group["fastest"], group["highest"][-1])
        low = groups[i - 1]["highest"][-1] if i else 0
        high = groups[i + 1]["highest"][0] if i + 1 < len(groups) else len(path) - 1
        low, high = max(low, first - reach), min(high, last + reach)
        start = first
        while height[start] > min(height[low : first + 1]) + config.margin_m:
            start -= 1
        end = last
        while height[end] > min(height[last : high + 1]) + config.margin_m:
            end += 1
        if result:
            start = max(start, result[-1]["stop"])
        top = max(group["highest"], key=lambda f: (height[f], -f))
        before, after = neighbours(fastest, top, reach)
        result.append(
            {
                "highest": tuple(group["highest"]),
                "fastest": group["fastest"],
                "top": top,
                "before": -1 if before is None or before < start else before,
                "after": -1 if after is None or after > end else after,
                "hit_start": max(first, start),
                "hit_stop": last + 1,
                "start": start,
                "stop": end + 1,
            }
        )
    return result
