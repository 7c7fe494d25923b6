"""Attacks from a JSON file.

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
import math
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from mgjax.avoidance.attacks.attack import MAX_SECONDS, Attack, validate_attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.attacks.merge import merge_attacks
from mgjax.avoidance.config import BALL_RADIUS_M
from mgjax.core.errors import AttackError, FileFormatError
from mgjax.io.json_text import Place, line_of, parse_json, shown
from mgjax.io.text import read_text

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


class _Document:
    """A JSON document that knows in which line each of its values begins."""

    def __init__(self, path: str | Path) -> None:
        self.path = path
        self.text = text = read_text(path, "attack")

        root = parse_json(path, text, expected="a JSON object", twice=self._twice)
        if not isinstance(root, dict):
            self.fail((), shown(root), "an object with balls, or with radii, times, centres")
        self.root: dict[str, Any] = root

    def _twice(self, key: str) -> FileFormatError:
        return FileFormatError(self.path, None, f"key {key!a:.80} twice", "it once")

    def fail(self, where: Place, got: str, expected: str) -> NoReturn:
        name = "".join(f"[{k}]" if isinstance(k, int) else f".{k}" for k in where).lstrip(".")
        line = line_of(self.text, where)
        raise FileFormatError(self.path, line, f"{name}: {got}" if name else got, expected)

    def keys(self, where: Place, found: dict[str, Any], known: tuple[str, ...]) -> None:
        for key in found:
            if key not in known:
                near = difflib.get_close_matches(key, known, n=1, cutoff=0.0)[0]
                line = line_of(self.text, (*where, key))
                got = f"unknown key {key!a:.60}"
                place = "".join(f"[{k}]" if isinstance(k, int) else k for k in where)
                raise FileFormatError(
                    self.path,
                    line,
                    f"{place}: {got}" if place else got,
                    f"one such as {near!r} (known: {', '.join(known)})",
                )

    def number(self, where: Place, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, float) or not math.isfinite(value):
            self.fail(where, shown(value), "a finite number")
        return value

    def numbers(self, where: Place, value: Any, count: int | None = None) -> np.ndarray:
        items = self.items(where, value, "numbers", count)
        return np.array([self.number((*where, i), x) for i, x in enumerate(items)])

    def items(self, where: Place, value: Any, what: str, count: int | None = None) -> list[Any]:
        if not isinstance(value, list) or not value or (count and len(value) != count):
            expected = f"a list of {count} {what}" if count else f"a list of {what}, not empty"
            self.fail(where, shown(value), expected)
        return value

    def attack(self) -> Attack:
        root = self.root
        short = "balls" in root
        for key in _LONG[:3]:
            if short and key in root:
                self.fail((key,), "it beside balls", "either balls or radii, times and centres")
        self.keys((), root, _SHORT if short else (_LONG if "radii" in root else (*_LONG, "balls")))
        if root.get("frame", "character") != "character":
            self.fail(("frame",), shown(root["frame"]), "'character'")
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
        where: Place = ("balls", index)
        if not isinstance(ball, dict):
            self.fail(where, shown(ball), f"an object with {', '.join(_BALL[:4])}")
        self.keys(where, ball, _BALL)
        for key in _BALL[:4]:
            if key not in ball:
                self.fail(where, f"no {key!r}", f"an object with {', '.join(_BALL[:4])}")
        gravity = ball.get("gravity", False)
        if not isinstance(gravity, bool):
            self.fail((*where, "gravity"), shown(gravity), "true or false")
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

    def checked(self, where: Place, function: Any, *args: Any, **more: Any) -> Any:
        """Calls a function whose complaints get the file and the line."""
        try:
            return function(*args, **more)
        except AttackError as error:
            self.fail(where, error.got, error.expected)
