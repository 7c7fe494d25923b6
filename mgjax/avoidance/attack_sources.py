"""Where attacks come from besides a throw: an attacker's limb, several at once, a JSON file.

A file holds the spheres themselves, a list of places for each time (s from now, m)

    {"radii": [0.12], "times": [0.5, 1.0], "centres": [[[0, 1.2, 4]], [[0, 1.2, 0]]]}

or balls that are thrown, whose last three fields may be left out:

    {"balls": [{"from": [3, 1.5, 4], "at": [0, 1.2, 0], "speed": 10, "arrives": 1.2,
                "gravity": true, "drag": 0.1, "radius": 0.12}]}

Both may say ``"frame": "character"``, which is the only frame there is: the planar frame of the
character's start pose.
"""

from __future__ import annotations

import difflib
import json
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attack import (
    BALL_RADIUS_M,
    MAX_SECONDS,
    Attack,
    ball_attack,
    validate_attack,
)
from mgjax.avoidance.volumes import preset_spheres, sphere_centres
from mgjax.core import planar
from mgjax.core.errors import AttackError, FileFormatError
from mgjax.core.kinematics import forward, planar_frames
from mgjax.core.motion import Motion, sample, validate_motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.text import read_text

LIMBS: dict[str, tuple[str, ...]] = {
    f"{side}_{end}": (f"{side}_{inner}-", f"{side}_{outer}-")
    for side in ("left", "right")
    for end, inner, outer in (("hand", "elbow", "wrist"), ("foot", "knee", "ankle"))
}
"""For each limb that may strike, how the names of its body spheres begin, inner part first."""
LIMB_RATE = 240.0
"""Least knots per second of a limb; the frames of its motion are always among them."""


def limb_attack(
    skeleton: Skeleton,
    motion: Motion,
    *,
    limb: str,
    hit_s: float,
    arrives: float,
    place: Float[np.ndarray, "3"] | Sequence[float] | None = None,
    target: Float[np.ndarray, "2"] | Sequence[float] | None = None,
    side: float = 0.0,
    before_s: float = 0.4,
    after_s: float = 0.3,
) -> Attack:
    """The spheres of an attacker's forearm and hand, or shin and foot, around a hit.

    They are those of the body preset, scaled to the attacker's skeleton, inner part first; the last
    one is the limb's end. Where the attacker stands at the hit is given by ``place``, or else so
    chosen that the limb's end is over the floor point ``target`` then; how high it is there is the
    motion's affair.

    Args:
        skeleton: the attacker's.
        motion: a clip, or a walk from :func:`mgjax.avoidance.check.walk_motion`.
        limb: ``left_hand``, ``right_hand``, ``left_foot`` or ``right_foot``.
        hit_s: moment of the hit in the motion, s.
        arrives: when the hit happens, s from now, more than 0.
        place: planar frame (θ, x, z) of the attacker's body at the hit, in the defender's:
            (π, 0, 1) faces a defender who stands at the origin from 1 m in front.
        target: (x, z) in the defender's frame, m.
        side: with ``target``: where the attacker's root is as seen from there, rad; 0 is +Z (the
            defender's front), π/2 is +X (the defender's left).
        before_s, after_s: what part of the motion before and after the hit counts, s; shorter
            where the motion begins or ends, and nothing before now.

    Raises:
        AttackError: no such limb, a number out of range, or not one of ``place`` and ``target``.
        SkeletonError: the attacker lacks a joint.
        MotionError: the motion does not fit the skeleton.
    """
    if limb not in LIMBS:
        raise AttackError(f"got limb {limb!r:.60}, expected one of {', '.join(LIMBS)}")
    validate_motion(skeleton, motion)
    rate = float(motion.frame_rate)
    last = (motion.num_frames - 1) / rate
    for name, value, high in (
        ("hit_s", hit_s, last),
        ("before_s", before_s, MAX_SECONDS),
        ("after_s", after_s, MAX_SECONDS),
    ):
        if not 0 <= value <= high + 1e-9:
            raise AttackError(f"got {name} = {value:g}, expected 0 … {high:g} s")
    if not 0 < arrives <= MAX_SECONDS:
        raise AttackError(f"got arrival {arrives:g}, expected more than 0 and at most 60")
    hit = min(hit_s, last)
    begin = max(hit - min(before_s, arrives), 0.0)
    end = min(hit + min(after_s, MAX_SECONDS - arrives), last)
    times = _knots(begin, hit, end, rate)
    wanted = np.flatnonzero(
        [name.startswith(LIMBS[limb]) for name in preset_spheres(skeleton).names]
    )
    # The middle of each interval says how far the limb is off the straight line there.
    moments = np.sort(np.concatenate([times, 0.5 * (times[1:] + times[:-1])]))
    centres, frames = _limb_centres(skeleton, motion, moments * rate, wanted)
    at_hit = 2 * int(np.searchsorted(times, hit))
    inverse = np.asarray(planar.inverse(frames[at_hit]))
    local_end = np.asarray(planar.apply(inverse, centres[at_hit, -1]))
    stands = _stands(local_end, place, target, side)
    move = np.asarray(planar.compose(stands, inverse))
    centres = np.asarray(planar.apply(move, centres))
    bend = np.zeros(1)
    if len(times) > 1:
        middle = 0.5 * (centres[:-2:2] + centres[2::2])
        off = np.linalg.norm(centres[1::2] - middle, axis=-1).max(axis=1)
        bend = 8 * off / np.diff(times) ** 2
        # A sliver of an interval would turn rounding into an acceleration.
        bend = np.where(off < 1e-7, 0.0, bend)
    attack = Attack(
        times=times - hit + arrives,
        centres=centres[::2],
        radii=preset_spheres(skeleton).radii[wanted].astype(np.float64),
        acceleration=float(bend.max()),
    )
    validate_attack(attack)
    return attack


def _knots(begin: float, hit: float, end: float, rate: float) -> np.ndarray:
    """Begin, hit and end, the frames between, and evenly spaced times between those."""
    parts = max(1, math.ceil(LIMB_RATE / rate - 1e-9))
    step = 1 / (rate * parts)
    inner = np.arange(math.ceil(begin / step), math.floor(end / step) + 1) * step
    fixed = np.unique([begin, hit, end])
    apart = np.abs(inner[:, None] - fixed).min(axis=1) > 1e-6
    inner = inner[apart & (inner > begin) & (inner < end)]
    return np.sort(np.concatenate([fixed, inner]))


def _limb_centres(
    skeleton: Skeleton, motion: Motion, frames: np.ndarray, wanted: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Centres of the wanted spheres at fractional frames, and the planar frames of the body."""
    exact = replace(
        motion,
        root_translation=np.asarray(motion.root_translation, dtype=np.float64),
        local_rotations=np.asarray(motion.local_rotations, dtype=np.float64),
        joint_offsets=None
        if motion.joint_offsets is None
        else np.asarray(motion.joint_offsets, dtype=np.float64),
    )
    poses = sample(exact, frames)
    solid = replace(skeleton, offsets=np.asarray(skeleton.offsets, dtype=np.float64))
    positions, _ = forward(
        solid, poses.root_translation, poses.local_rotations, poses.joint_offsets
    )
    spheres = preset_spheres(skeleton)
    centres = np.asarray(sphere_centres(spheres, positions))[:, wanted]
    return centres, np.asarray(planar_frames(skeleton, positions))


def _stands(
    limb_end: np.ndarray,
    place: np.ndarray | Sequence[float] | None,
    target: np.ndarray | Sequence[float] | None,
    side: float,
) -> np.ndarray:
    """Planar frame of the attacker at the hit; ``limb_end`` is in the attacker's own."""
    if (place is None) == (target is None):
        raise AttackError("got both or none of place and target, expected one of them")
    given, count, name = (place, 3, "place") if target is None else (target, 2, "target")
    values = np.asarray(given, dtype=np.float64)
    if values.shape != (count,) or not (np.abs(values) <= 1000).all():
        raise AttackError(
            f"got {name} {values.tolist()!s:.60}, expected {count} numbers within 1000"
        )
    if not abs(side) <= 1000:
        raise AttackError(f"got side {side:g}, expected an angle in rad")
    if target is None:
        return values
    x, _, z = limb_end
    # A limb that ends over the root comes from nowhere in particular: then the attacker faces it.
    toward_root = math.atan2(-x, -z) if math.hypot(x, z) > 0.01 else math.pi
    turned = np.array([side - toward_root, 0.0, 0.0])
    reach = np.asarray(planar.apply(turned, limb_end))
    return np.array([turned[0], values[0] - reach[0], values[1] - reach[2]])


def merge_attacks(attacks: Sequence[Attack]) -> Attack:
    """One attack with the spheres of all, in order, each there exactly while its own attack lasts.

    The knots are those of all attacks, and more where nothing is known for long, so that what one
    attack bends between its knots does not count for more than it did. Spheres that are not there
    yet, or no more, are where :class:`~mgjax.avoidance.attack.Attack` says.

    Raises:
        AttackError: no attacks, or one that is not valid.
    """
    if not attacks:
        raise AttackError("got no attacks to merge, expected at least one")
    for attack in attacks:
        validate_attack(attack)
    if len(attacks) == 1:
        return attacks[0]
    starts, stops = [], []
    for a in attacks:
        count = len(a.radii)
        starts.append(np.full(count, a.start) if a.starts is None else a.starts)
        stops.append(np.full(count, a.end) if a.stops is None else a.stops)
    times = np.unique(np.concatenate([attack.times for attack in attacks]))
    acceleration = max(attack.acceleration for attack in attacks)
    if acceleration > 0:
        times = _filled(times, _widest(attacks, acceleration))
    merged = Attack(
        times=times,
        centres=np.concatenate([attack.at(times) for attack in attacks], axis=1),
        radii=np.concatenate([attack.radii for attack in attacks]),
        acceleration=acceleration,
        starts=np.concatenate(starts),
        stops=np.concatenate(stops),
    )
    whole = (merged.starts == merged.start).all() and (merged.stops == merged.end).all()
    if whole:
        return replace(merged, starts=None, stops=None)
    return replace(merged, centres=merged.at(times))


def _widest(attacks: Sequence[Attack], acceleration: float) -> float:
    """Knots this far apart bend no more under ``acceleration`` than the attacks do by themselves.

    Not finer than 1/480 s: straight attacks beside a bent one would need endless knots.
    """
    bends = [a.acceleration * np.diff(a.times).max(initial=0.0) ** 2 for a in attacks]
    return max(math.sqrt(max(bends) / acceleration), 1 / 480)


def _filled(times: np.ndarray, widest: float) -> np.ndarray:
    """The times, and evenly spaced ones where two are farther apart than ``widest``."""
    pieces = np.maximum(np.ceil(np.diff(times) / widest - 1e-6).astype(np.int64), 1)
    which = np.repeat(np.arange(len(pieces)), pieces)
    number = np.arange(len(which)) - (np.cumsum(pieces) - pieces)[which]
    filled = times[which] + np.diff(times)[which] * (number / pieces[which])
    return np.append(filled, times[-1])


_LONG = ("radii", "times", "centres", "frame")
_SHORT = ("balls", "frame")
_BALL = ("from", "at", "speed", "arrives", "gravity", "drag", "radius")
_MAX_KNOTS = 1_000_000


def load_attack(path: str | Path) -> Attack:
    """Reads an attack from a JSON file (see this module).

    Between the times of a list its spheres move linearly. Balls become one attack.

    Raises:
        FileFormatError: names the file, the line, what stands there and what should.
    """
    return _Document(path).attack()


_Place = tuple[str | int, ...]
"""Where a value stands in a document: keys and indices, from the outermost."""


class _Document:
    """A JSON document that knows in which line each of its values begins."""

    def __init__(self, path: str | Path) -> None:
        self.path = path
        self.text = text = read_text(path, "attack")

        def refuse(word: str) -> NoReturn:
            raise FileFormatError(path, None, word, "finite numbers")

        try:
            # As floats, numbers of any length can be read; one with too many digits is infinite.
            root = json.loads(
                text, object_pairs_hook=self._unique, parse_int=float, parse_constant=refuse
            )
        except json.JSONDecodeError as error:
            got = f"no JSON ({error.msg})"
            raise FileFormatError(path, error.lineno, got, "a JSON object") from None
        except RecursionError:
            raise FileFormatError(path, None, "JSON nested too deep", "a JSON object") from None
        if not isinstance(root, dict):
            self.fail((), f"{_kind(root)}", "an object with balls, or with radii, times, centres")
        self.root: dict[str, Any] = root

    def _unique(self, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        for key, count in Counter(key for key, _ in pairs).items():
            if count > 1:
                raise FileFormatError(self.path, None, f"key {key!a:.80} twice", "it once")
        return dict(pairs)

    def line_of(self, where: _Place) -> int | None:
        """Line of a value, or of what holds it."""
        lines = _lines(self.text)
        return next(
            (lines[where[:n]] for n in range(len(where), -1, -1) if where[:n] in lines), None
        )

    def fail(self, where: _Place, got: str, expected: str) -> NoReturn:
        name = "".join(f"[{k}]" if isinstance(k, int) else f".{k}" for k in where).lstrip(".")
        line = self.line_of(where)
        raise FileFormatError(self.path, line, f"{name}: {got}" if name else got, expected)

    def keys(self, where: _Place, found: dict[str, Any], known: tuple[str, ...]) -> None:
        for key in found:
            if key not in known:
                near = difflib.get_close_matches(key, known, n=1, cutoff=0.0)[0]
                line = self.line_of((*where, key))
                got = f"unknown key {key!a:.60}"
                place = "".join(f"[{k}]" if isinstance(k, int) else k for k in where)
                raise FileFormatError(
                    self.path,
                    line,
                    f"{place}: {got}" if place else got,
                    f"one such as {near!r} (known: {', '.join(known)})",
                )

    def number(self, where: _Place, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, float) or not math.isfinite(value):
            self.fail(where, _kind(value), "a finite number")
        return value

    def numbers(self, where: _Place, value: Any, count: int | None = None) -> np.ndarray:
        items = self.items(where, value, "numbers", count)
        return np.array([self.number((*where, i), x) for i, x in enumerate(items)])

    def items(self, where: _Place, value: Any, what: str, count: int | None = None) -> list[Any]:
        if not isinstance(value, list) or not value or (count and len(value) != count):
            expected = f"a list of {count} {what}" if count else f"a list of {what}, not empty"
            self.fail(where, _kind(value), expected)
        return value

    def attack(self) -> Attack:
        root = self.root
        short = "balls" in root
        for key in _LONG[:3]:
            if short and key in root:
                self.fail((key,), "it beside balls", "either balls or radii, times and centres")
        self.keys((), root, _SHORT if short else (_LONG if "radii" in root else (*_LONG, "balls")))
        if root.get("frame", "character") != "character":
            self.fail(("frame",), _kind(root["frame"]), "'character'")
        if short:
            balls = self.items(("balls",), root["balls"], "balls")
            return merge_attacks([self.ball(i, ball) for i, ball in enumerate(balls)])
        for key in _LONG[:3]:
            if key not in root:
                self.fail((), f"no {key!r}", "balls, or radii, times and centres")
        radii = self.numbers(("radii",), root["radii"])
        times = self.numbers(("times",), root["times"])
        if len(times) * len(radii) > _MAX_KNOTS:
            self.fail(("times",), f"{len(times)} times {len(radii)} places", "at most a million")
        rows = self.items(("centres",), root["centres"], "places, one list a time", len(times))
        centres = []
        for k, row in enumerate(rows):
            spheres = self.items(("centres", k), row, "places, one a radius", len(radii))
            places = [("centres", k, i) for i in range(len(spheres))]
            centres.append([self.numbers(w, x, 3) for w, x in zip(places, spheres, strict=True)])
        for name, values, wrong, expected in (
            ("radii", radii, radii <= 0, "more than 0"),
            ("times", times, np.append(False, np.diff(times) <= 0), "ascending times"),
            ("times", times, times > MAX_SECONDS, f"at most {MAX_SECONDS:g} s"),
        ):
            if wrong.any():
                first = int(np.argmax(wrong))
                self.fail((name, first), f"{values[first]:g}", expected)
        attack = Attack(times=times, centres=np.array(centres), radii=radii)
        self.checked((), validate_attack, attack)
        return attack

    def ball(self, index: int, ball: Any) -> Attack:
        where: _Place = ("balls", index)
        if not isinstance(ball, dict):
            self.fail(where, _kind(ball), f"an object with {', '.join(_BALL[:4])}")
        self.keys(where, ball, _BALL)
        for key in _BALL[:4]:
            if key not in ball:
                self.fail(where, f"no {key!r}", f"an object with {', '.join(_BALL[:4])}")
        gravity = ball.get("gravity", False)
        if not isinstance(gravity, bool):
            self.fail((*where, "gravity"), _kind(gravity), "true or false")
        return self.checked(
            where,
            ball_attack,
            self.numbers((*where, "from"), ball["from"], 3),
            self.numbers((*where, "at"), ball["at"], 3),
            speed=self.number((*where, "speed"), ball["speed"]),
            arrives=self.number((*where, "arrives"), ball["arrives"]),
            gravity=gravity,
            drag=self.number((*where, "drag"), ball.get("drag", 0.0)),
            radius=self.number((*where, "radius"), ball.get("radius", BALL_RADIUS_M)),
        )

    def checked(self, where: _Place, function: Any, *args: Any, **more: Any) -> Any:
        """Calls a function whose complaints get the file and the line."""
        try:
            return function(*args, **more)
        except AttackError as error:
            got, _, expected = str(error).removeprefix("got ").rpartition(", expected ")
            self.fail(where, got, expected)


def _kind(value: Any) -> str:
    """A value for a message: short, on one line."""
    if isinstance(value, list):
        return f"a list of {len(value)}" if value else "an empty list"
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, str):
        return ascii(value if len(value) <= 40 else value[:37] + "...")
    return f"{value:g}" if type(value) is float else json.dumps(value)


_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[\[\]{},:]|[^\s\[\]{},:"]+|\n')


def _lines(text: str) -> dict[_Place, int]:
    """Line at which each value, or its key, begins in a text that is known to be JSON."""
    found: dict[_Place, int] = {}
    line = 1
    place: list[str | int] = []  # of the value that comes next
    in_object: list[bool] = []
    key_next = False
    for match in _TOKEN.finditer(text):
        token = match.group()
        if token == "\n":
            line += 1
        elif token in "]}":
            place.pop()
            in_object.pop()
            key_next = False
        elif token == ",":
            if in_object[-1]:
                key_next = True
            else:
                place[-1] = int(place[-1]) + 1
        elif token == ":":
            key_next = False
        elif key_next:
            place[-1] = json.loads(token)
            found[tuple(place)] = line
        else:
            found.setdefault(tuple(place), line)
            if token in "[{":
                place.append(0)
                in_object.append(token == "{")
                key_next = token == "{"
    return found
