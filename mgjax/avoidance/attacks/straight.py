"""Many balls at once that fly straight between a few knots: what is asked of each, for all of them.

Every number is, to the last bit, what :mod:`~mgjax.avoidance.attacks.crop` and
:mod:`~mgjax.avoidance.attacks.batch` say of one attack. Others than such balls are left to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attacks.attack import MAX_SECONDS, Attack
from mgjax.avoidance.attacks.batch import FRAME_BUCKET, AttackColumn
from mgjax.avoidance.attacks.crop import MARGIN_M, RATE
from mgjax.avoidance.attacks.sag import sag_of
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.rates import EXPORT_RATE

FEW = 8
"""Most knots of a ball that is looked at with others."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Balls:
    """Single spheres that move straight between K knots, each there from the first to the last.

    Attributes:
        attacks: each of them.
        number: where each stands among the attacks that were given. [A]
        times: of the knots, s, ascending. [A, K]
        centres: m. [A, K, 3]
        radii: m. [A]
        sound: whether nothing is wrong with a ball; of others more has to be asked. [A]
    """

    attacks: list[Attack]
    number: Int[np.ndarray, " A"]
    times: Float[np.ndarray, "A K"]
    centres: Float[np.ndarray, "A K 3"]
    radii: Float[np.ndarray, " A"]
    sound: Bool[np.ndarray, " A"]

    def some(self, rows: Int[np.ndarray, " B"]) -> Balls:
        """Those in some rows."""
        return Balls(
            attacks=[self.attacks[row] for row in rows.tolist()],
            number=self.number[rows],
            times=self.times[rows],
            centres=self.centres[rows],
            radii=self.radii[rows],
            sound=self.sound[rows],
        )


def straight_balls(attacks: Sequence[Attack]) -> list[Balls]:
    """The straight balls among some attacks, those with equally many knots together."""
    of_knots: dict[int, list[int]] = {}
    for number, attack in enumerate(attacks):
        times, centres = attack.times, attack.centres
        single = centres.shape == (len(times), 1, 3) and attack.radii.shape == (1,)
        kinds = {times.dtype, centres.dtype, attack.radii.dtype}
        lives = attack.starts is not None or attack.stops is not None
        if single and 1 < len(times) <= FEW and kinds == {np.dtype(np.float64)} and not lives:
            of_knots.setdefault(len(times), []).append(number)
    return [_together([attacks[i] for i in own], own) for own in of_knots.values()]


def _together(attacks: list[Attack], numbers: list[int]) -> Balls:
    times = np.array([attack.times for attack in attacks])
    centres = np.array([attack.centres for attack in attacks])[:, :, 0]
    radii = np.array([attack.radii for attack in attacks])[:, 0]
    bend = np.array([attack.acceleration for attack in attacks], np.float64)
    with np.errstate(invalid="ignore"):
        sound = np.isfinite(times).all(axis=1) & np.isfinite(centres).all(axis=(1, 2))
        sound &= (times[:, 1:] > times[:, :-1]).all(axis=1) & (times[:, -1] <= MAX_SECONDS)
        sound &= (radii > 0) & np.isfinite(radii) & (bend >= 0) & (bend < np.inf)
    return Balls(
        attacks=attacks,
        number=np.array(numbers),
        times=times,
        centres=centres,
        radii=radii,
        sound=sound,
    )


def begins_far(balls: Balls, farthest: float) -> Bool[np.ndarray, " A"]:
    """Whether a ball begins later than now, and farther from the origin than ``farthest``, m."""
    x, y, z = balls.centres[:, 0].T
    return (balls.times[:, 0] >= 0) & (np.sqrt(x * x + y * y + z * z) - balls.radii > farthest)


def crops_of(
    balls: Balls, *, radius: float, height: float
) -> tuple[Float[np.ndarray, " A"], Float[np.ndarray, " A"]]:
    """First and last second of the part of each ball that is near; NaN where it never is.

    Args:
        balls: all of them ``sound``.
        radius, height: see :func:`~mgjax.avoidance.attacks.crop.crop_attack`.
    """
    end = balls.times[:, -1]
    begin = np.maximum(balls.times[:, 0], 0.0)
    with np.errstate(all="ignore"):
        count = np.ceil((end - begin) * RATE) + 2
        moments = _Moments(begin=begin, end=end, step=(end - begin) / (count - 1), count=count)
        lines = [_Line(balls, k) for k in range(balls.times.shape[1] - 1)]
        spans = [line.about_inside(moments, radius, height) for line in lines]
        first = _first_inside(lines, spans, moments, radius, height, 1)
        last = _first_inside(lines[::-1], spans[::-1], moments, radius, height, -1)
    near = np.isfinite(first) & (begin < end)
    low, high = np.minimum(first, last), np.maximum(first, last)
    return np.where(near, moments.time(low), np.nan), np.where(near, moments.time(high), np.nan)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Moments:
    """Evenly spaced moments of each ball. All [A]"""

    begin: np.ndarray
    end: np.ndarray
    step: np.ndarray
    count: np.ndarray

    def time(self, number: np.ndarray) -> np.ndarray:
        return np.where(number == self.count - 1, self.end, number * self.step + self.begin)

    def between(self, start: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The first and last of the moments from start to stop, and one more at either end."""
        first = np.ceil((np.maximum(start, self.begin) - self.begin) / self.step - 0.01)
        last = np.floor((np.maximum(stop, self.begin) - self.begin) / self.step + 0.01)
        return np.maximum(first, 0), np.minimum(last, self.count - 1)


class _Line:
    """A stretch between two knots, of each ball."""

    def __init__(self, balls: Balls, number: int) -> None:
        self.start, self.stop = balls.times[:, number], balls.times[:, number + 1]
        self.a, self.b = balls.centres[:, number].T, balls.centres[:, number + 1].T

    def about_inside(
        self, moments: _Moments, radius: float, height: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """First and last of the moments at which it may be inside; the last is −1 if at none."""
        a, b = self.a, self.b
        dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        ends = (-MARGIN_M - a[1]) / dy, (height + MARGIN_M - a[1]) / dy
        steep = np.abs(dy) > MARGIN_M
        low = np.where(steep, np.maximum(0.0, np.minimum(*ends)), 0.0)
        high = np.where(steep, np.minimum(1.0, np.maximum(*ends)), 1.0)
        squared, along = dx * dx + dz * dz, a[0] * dx + a[2] * dz
        excess = a[0] * a[0] + a[2] * a[2] - (radius + MARGIN_M) ** 2
        root = along * along - squared * excess
        moves, never = squared > MARGIN_M**2, root < 0
        root = np.sqrt(np.maximum(root, 0.0))
        low = np.where(moves, np.maximum(low, (-along - root) / squared), low)
        high = np.where(moves, np.minimum(high, (-along + root) / squared), high)
        span = self.stop - self.start
        first, last = moments.between(self.start + low * span, self.start + high * span)
        level = ~steep & ((a[1] < -2 * MARGIN_M) | (a[1] > height + 2 * MARGIN_M))
        none = (moves & never) | (low > high) | level
        return np.where(none, 0, first), np.where(none, -1, last)

    def is_inside(self, time: np.ndarray, radius: float, height: float) -> np.ndarray:
        """Whether each is in the cylinder at a time of its own."""
        since, span = time - self.start, self.stop - self.start
        ended = time >= self.stop
        x, y, z = (
            np.where(ended, q, (q - p) / span * since + p)
            for p, q in zip(self.a, self.b, strict=True)
        )
        share = (x * x + z * z) / (radius * radius)
        sure = np.abs(share - 1) > 1e-9
        within = np.where(sure, share < 1, np.hypot(x, z) <= radius)
        return within & (y >= 0) & (y <= height) & (self.start <= time) & (time <= self.stop)


def _first_inside(
    lines: list[_Line],
    spans: list[tuple[np.ndarray, np.ndarray]],
    moments: _Moments,
    radius: float,
    height: float,
    turn: int,
) -> np.ndarray:
    """The first of the moments at which each ball is inside, from one end; infinite without one."""
    found = np.full(len(moments.begin), np.inf)
    for line, (first, last) in zip(lines, spans, strict=True):
        number = first if turn > 0 else last
        open_ = np.isinf(found) & (first <= last)
        while open_.any():
            inside = open_ & line.is_inside(moments.time(number), radius, height)
            found = np.where(inside, number, found)
            number = number + turn
            open_ &= ~inside & (first <= number) & (number <= last)
    return found


def batch_rows(
    balls: Balls,
    crops: tuple[Float[np.ndarray, " A"], Float[np.ndarray, " A"]],
    config: AvoidanceConfig,
    reach: float,
) -> tuple[Float[np.ndarray, "A N 3"], Float[np.ndarray, "A M"], Bool[np.ndarray, " A"]]:
    """``frames`` and ``numbers`` of an :class:`~mgjax.avoidance.attacks.batch.AttackBatch`, and
    which of the balls are short enough for them.

    Args:
        balls: those that come near, all ``sound``.
        crops: of :func:`crops_of`.
        config, reach: see :func:`~mgjax.avoidance.attacks.batch.make_attack_batch`.
    """
    start, stop = crops
    begin, end = np.maximum(balls.times[:, 0], 0.0), balls.times[:, -1]
    first = np.floor(begin * EXPORT_RATE)
    count = np.maximum(np.ceil(end * EXPORT_RATE), first + 1) - first + 1
    fits = count <= FRAME_BUCKET
    step = 1 / EXPORT_RATE
    used = int(min(count.max(initial=1), FRAME_BUCKET))
    index = np.minimum(np.arange(used), count[:, None] - 1)
    frames = np.empty((len(begin), FRAME_BUCKET, 3), np.float32)
    frames[:, :used] = _places(balls, (first[:, None] + index) * step)
    frames[:, used:] = frames[:, used - 1 : used]
    speed = _speeds(balls)
    longest = np.minimum(config.evaluation_step_s, balls.radii / np.maximum(speed, 1e-6))
    numbers = np.empty((len(begin), len(AttackColumn) + 3), np.float32)
    columns = {
        AttackColumn.T_ATTACK: 0.5 * (start + stop),
        AttackColumn.CROP_START: start,
        AttackColumn.CROP_END: stop,
        AttackColumn.EVALUATED: np.maximum(np.ceil((stop - start) / longest) + 1, 2),
        AttackColumn.SPHERE_COUNT: 1,
        AttackColumn.BEGIN: begin,
        AttackColumn.END: np.maximum(end, begin),
        AttackColumn.FIRST_FRAME: first,
        AttackColumn.FRAME_COUNT: count,
        AttackColumn.MARGIN: reach + speed * step + 0.1,
        AttackColumn.SAG: _sags(balls, step),
        AttackColumn.SPEED: speed,
    }
    for column, values in columns.items():
        numbers[:, column] = values
    numbers[:, len(AttackColumn) :] = np.stack([balls.radii, balls.times[:, 0], end], axis=1)
    return frames, numbers, fits


def _places(balls: Balls, times: Float[np.ndarray, "A T"]) -> Float[np.ndarray, "A T 3"]:
    """Where balls are at times of their own, m: to the last bit that of ``np.interp``."""
    knots, centres = balls.times, balls.centres
    after = np.zeros(times.shape, np.int64)
    for k in range(1, knots.shape[1] - 1):
        after += times >= knots[:, k : k + 1]
    row = np.arange(len(times))[:, None]
    slopes = (centres[:, 1:] - centres[:, :-1]) / (knots[:, 1:] - knots[:, :-1])[..., None]
    places = slopes[row, after] * (times - knots[row, after])[..., None] + centres[row, after]
    places = np.where((times < knots[:, :1])[..., None], centres[:, :1], places)
    return np.where((times >= knots[:, -1:])[..., None], centres[:, -1:], places)


def _speeds(balls: Balls) -> Float[np.ndarray, " A"]:
    """:attr:`~mgjax.avoidance.attacks.attack.Attack.largest_speed` of each."""
    moved = balls.centres[:, 1:] - balls.centres[:, :-1]
    speeds = np.sqrt(np.einsum("kix,kix->ki", moved, moved))
    return (speeds / (balls.times[:, 1:] - balls.times[:, :-1])).max(axis=1)


def _sags(balls: Balls, step: float) -> Float[np.ndarray, " A"]:
    """:func:`~mgjax.avoidance.attacks.sag.sag_of` each; most have no corners and need no look."""
    velocity = (balls.centres[:, 1:] - balls.centres[:, :-1]) / (
        balls.times[:, 1:] - balls.times[:, :-1]
    )[..., None]
    turns = np.abs(velocity[:, 1:] - velocity[:, :-1]).sum(axis=(1, 2))
    sags = np.zeros(len(turns))
    for row, attack in enumerate(balls.attacks):
        if attack.acceleration or turns[row] > 1e-7:
            sags[row] = sag_of(attack, step)
    return sags
