"""How fast a walk is played: with speeds that jump between edges, or smoothly (§4.1).

The paper scales whole edges, so that the speed jumps where a scaled edge meets another; it names
the problem and leaves it. The smooth form plays the same poses at the same moment of avoidance,
with a speed that is continuous and changes as slowly as it can.
"""

from __future__ import annotations

import math
from itertools import groupby
from typing import TypeAlias

import numpy as np
from jaxtyping import Float

from mgjax.core.errors import MotionError
from mgjax.core.timing.time_warp import TimeWarp, scaled_warp
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk

LEEWAY = 1.25
"""How much faster (or slower, where a walk is slowed down) than the linear form the smooth one may
play an edge: room to make up for what it loses while its speed changes."""
_HALVINGS = 60
_ROOM = 0.01
"""Share of the time that must be to spare for a speed to change smoothly."""
_NOTHING = 1e-9
"""Seconds by which nothing is shown earlier or later."""

_Run: TypeAlias = tuple[float, float]
"""Seconds of the walk, and the speed at which they are played."""
_Knot: TypeAlias = tuple[float, float, float]
"""Time, position and speed."""


def speed_change(warp: TimeWarp, until: float, rate: float) -> float:
    """Largest change of speed per second, of a motion that is written ``rate`` times a second.

    The largest difference between the speeds at two frames that follow one another, times the rate.
    It counts from the frame before now, which is played at natural speed, to ``until`` s. Of a
    continuous speed it is the largest slope, but for what changes within a frame.
    """
    frames = np.arange(-1, max(math.ceil(until * rate - 1e-6), 0) + 1)
    speeds = np.where(frames < 0, 1.0, warp.speed(frames / rate))
    return float(np.abs(np.diff(speeds)).max()) * rate


def natural_starts(graph: MotionGraph, walk: Walk) -> Float[np.ndarray, " L1"]:
    """Seconds of the walk as captured at which each edge begins, and at which it ends."""
    return np.concatenate([[0.0], np.cumsum(graph.edge_frames[walk.edges] / graph.frame_rate)])


def part_moments(graph: MotionGraph, walk: Walk, length: int, part: int) -> Float[np.ndarray, " 3"]:
    """Beginning, middle and end of an avoidance part, in seconds of the walk as captured.

    Args:
        graph: the graph.
        walk: of which edge number ``length`` (from 1) holds the part.
        length: edges of the path.
        part: the part.
    """
    edge = int(graph.label_edge[part])
    ends = np.array([graph.label_starts[part], graph.label_stops[part]]) - graph.edge_starts[edge]
    first, last = ends / graph.frame_rate + natural_starts(graph, walk)[length - 1]
    return np.array([first, 0.5 * (first + last), last])


def both_warps(
    graph: MotionGraph,
    walk: Walk,
    length: int,
    part: int,
    near: tuple[float, float],
    fastest: float = math.inf,
) -> tuple[TimeWarp, TimeWarp]:
    """How a walk to an avoidance part is played with one speed per edge, and smoothly.

    Args:
        graph, walk, length, part: as of :func:`part_moments`.
        near: when the attack comes near, and when it has gone, s from now.
        fastest: see :func:`smooth_warp`.
    """
    linear = linear_warp(graph, walk)
    middle = part_moments(graph, walk, length, part)[1:2]
    return linear, smooth_warp(linear, float(linear.when(middle)[0]), near, fastest)


def linear_warp(graph: MotionGraph, walk: Walk) -> TimeWarp:
    """The walk as its scales say: each edge at one speed."""
    return scaled_warp(graph.edge_frames[walk.edges] / graph.frame_rate, walk.scales)


def smooth_warp(
    warp: TimeWarp, t_avoid: float, near: tuple[float, float], fastest: float = math.inf
) -> TimeWarp:
    """A warp that shows the same pose at ``t_avoid``, its speed changing as slowly as it can.

    It begins at 1 now and meets ``warp``, position and speed, where the attack comes near; so while
    it is near the same poses are shown at the same times, and what was clear stays clear. It meets
    it at ``t_avoid`` only, where the speed of ``warp`` jumps in between or could not be reached
    earlier. Of all speeds that do so and on no edge exceed that of ``warp`` by more than
    ``LEEWAY``, it is the one whose largest change per second is least: rising and falling at one
    rate, and constant at what the edges allow. For a given rate such a speed is, squared and over
    the position, the lower envelope of the bounds and of cones of one slope, so it is known in
    closed form; the rate follows by bisection. Where the walk is slowed down, the same holds upside
    down. When the attack has gone, the speed goes back to 1 at the same rate.

    Where that would take speeds beyond ``fastest``, and no other would do, it is ``warp`` itself.

    Deviation:
        Edges that §4.1 does not scale are played up to ``LEEWAY`` times as fast or slow. What
        follows the avoidance is shown earlier or later by a constant time than the scales say.

    Args:
        warp: of piecewise constant speed.
        t_avoid: middle of the avoidance part as ``warp`` shows it, s from now.
        near: when the attack comes near, and when it has gone, s from now. At least half of the
            time up to ``t_avoid`` is used for getting there.
        fastest: largest speed that ``warp`` does not have itself.

    Raises:
        MotionError: ``t_avoid`` is not after now, or edges before it are both sped up and slowed
            down.
    """
    if not t_avoid > 0:
        raise MotionError(f"got an avoidance at {t_avoid:g} s, expected one after now")
    runs = _runs(warp, t_avoid)
    if any(speed > 1 for _, speed in runs) and any(speed < 1 for _, speed in runs):
        raise MotionError("got edges sped up and slowed down, expected one or the other")
    if abs(sum(length for length, _ in runs) - t_avoid) < _NOTHING:
        return TimeWarp(times=np.zeros(1), positions=np.zeros(1), speeds=np.ones(1))
    meets = min(max(near[0], 0.5 * t_avoid), t_avoid)
    wanted = runs[-1][1]
    if runs[-1][0] < (t_avoid - meets) * wanted:  # a jump in between
        meets = t_avoid
    first = _runs(warp, meets)
    if not _has_room(first, meets, fastest):
        return warp
    rate, profile = _slowest_change(first, meets, fastest)
    if abs(profile[-1][2] - wanted) > 1e-9:
        meets = t_avoid
        if not _has_room(runs, meets, fastest):
            return warp
        rate, profile = _slowest_change(runs, meets, fastest)
    speed = profile[-1][2]
    for durations, then in ((max(near[1], t_avoid) - meets, speed), (abs(speed - 1) / rate, 1.0)):
        time, position, before = profile[-1]
        profile.append((time + durations, position + 0.5 * durations * (before + then), then))
    times, positions, speeds = np.array(profile).T
    return TimeWarp(times=times, positions=positions, speeds=speeds)


def _runs(warp: TimeWarp, until: float) -> list[_Run]:
    """The stretches of one speed up to a time."""
    ends = np.minimum(warp.times, until)
    pieces = zip(np.diff(ends).tolist(), warp.speeds[:-1].tolist(), strict=True)
    longer = [(durations, speed) for durations, speed in pieces if durations > 0]
    if until > warp.times[-1]:
        longer.append((until - float(warp.times[-1]), 1.0))
    grouped = groupby(longer, key=lambda piece: piece[1])
    return [(sum(durations for durations, _ in group) * speed, speed) for speed, group in grouped]


def _top(speed: float, fastest: float) -> float:
    """The largest speed at which a run of the given speed may be played."""
    return min(speed * LEEWAY, max(speed, fastest))


def _has_room(runs: list[_Run], seconds: float, fastest: float) -> bool:
    """Whether runs can be over clearly sooner than they are, if they are sped up at all."""
    if all(speed <= 1 for _, speed in runs):
        return True
    return sum(length / _top(speed, fastest) for length, speed in runs) < seconds * (1 - _ROOM)


def _slowest_change(runs: list[_Run], seconds: float, fastest: float) -> tuple[float, list[_Knot]]:
    """The least rate with which some runs are over after the given time, and the speed's knots."""
    faster = any(speed > 1 for _, speed in runs)
    position = sum(length for length, _ in runs)
    # A speed that changes by less than this per second moves the end by half of what is needed.
    low = max(abs(position - seconds), _NOTHING) / seconds**2
    high = 4 * low
    while (_profile(runs, high, fastest)[-1][0] > seconds) == faster:
        low, high = high, 4 * high
    for _ in range(_HALVINGS):
        rate = 0.5 * (low + high)
        if (_profile(runs, rate, fastest)[-1][0] > seconds) == faster:
            low = rate
        else:
            high = rate
    return high, _profile(runs, high, fastest)


def _profile(runs: list[_Run], rate: float, fastest: float) -> list[_Knot]:
    """The fastest (or slowest) speed over some runs that changes by ``rate`` a second.

    It begins at 1 and ends at that of the last run, or as near to it as it comes.
    """
    # The square of the speed changes by 2 rate for each second of the walk. Slowing down is the
    # same with its sign changed.
    if any(speed > 1 for _, speed in runs):
        sign, bounds = 1.0, [_top(speed, fastest) ** 2 for _, speed in runs]
    else:
        sign, bounds = -1.0, [-((speed / LEEWAY) ** 2) for _, speed in runs]
    ends = [sign, *map(min, bounds[:-1], bounds[1:]), sign * runs[-1][1] ** 2]
    for i, (length, _) in enumerate(runs):
        ends[i + 1] = min(ends[i + 1], ends[i] + 2 * rate * length)
    for i in reversed(range(1, len(runs))):
        ends[i] = min(ends[i], ends[i + 1] + 2 * rate * runs[i][0])
    knots = [(0.0, 0.0, 1.0)]
    for (length, _), bound, begin, end in zip(runs, bounds, ends[:-1], ends[1:], strict=True):
        top = max(min(bound, 0.5 * (begin + end) + rate * length), begin, end)
        up, down = (top - begin) / (2 * rate), (top - end) / (2 * rate)
        flat = max(length - up - down, 0.0)
        for far, square in ((up, top), (flat, top), (down, end)):
            time, position, before = knots[-1]
            speed = math.sqrt(sign * square)
            knots.append((time + 2 * far / (before + speed), position + far, speed))
    return knots
