"""Sketches: what a user draws on the floor, and the files that hold it.

A CSV file has the columns x and z in metres, and speed in m/s if one is wanted; a first line of
names may be left out (:mod:`mgjax.hybrid.paths.sketch_csv`). A JSON file is a list of [x, z], or an
object of which only the points are needed:

    {"points": [[0, 0], [0, 3], [2, 5]], "spline": true, "closed": false, "speed": 1.2,
     "end": {"place": [2, 5], "heading_deg": 90}, "obstacles": [[1, 4, 0.3]]}

``speed`` is one number or one for each point; ``heading_deg`` may be left out, 0 is +z and 90 is
+x; obstacles are circles (x, z, radius). A path whose last point is its first is closed.
A point that comes twice in a row, as where a pen rests, is one point.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from mgjax.core.calls.door import takes_not_finite
from mgjax.core.errors import FileFormatError, PathError
from mgjax.hybrid.paths.sketch_csv import read_csv
from mgjax.io.json_text import parse_json
from mgjax.io.text import quoted, read_text

MAX_LENGTH_M = 1000.0
"""Longest path."""

MAX_OBSTACLES = 32
_KEYS = ("points", "spline", "closed", "speed", "end", "obstacles")
_SAME_M = 1e-6
"""Points nearer than this are one."""
_JUMP = 20.0
"""A step so many times longer than the others is a jump."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sketch:
    """A path on the floor, and what is wanted of the walk along it.

    Attributes:
        points: x and z, m; the first one is not repeated at the end of a closed path. [M, 2]
        speed: wanted speed at the points, m/s; NaN where none is wanted. [M]
        spline: a smooth curve through the points, else straight lines between them.
        closed: the path leads from the last point back to the first.
        end: place at which the walk should end (x, z, m) and heading there (rad, or NaN for any).
        obstacles: circles that the root may not enter (x, z, radius, m). [O, 3]
    """

    points: Float[np.ndarray, "M 2"]
    speed: Float[np.ndarray, " M"]
    spline: bool
    closed: bool
    end: tuple[float, float, float] | None
    obstacles: Float[np.ndarray, "O 3"]


@takes_not_finite
def make_sketch(
    points: Any,
    *,
    speed: Any = None,
    spline: bool = False,
    closed: bool = False,
    end: tuple[float, float, float] | None = None,
    obstacles: Any = (),
) -> Sketch:
    """A sketch from its points; see :class:`Sketch`.

    Raises:
        PathError: fewer than two points that are apart, one that is not finite, a jump, a speed or
            an obstacle that cannot be.
    """
    try:
        places = np.array(points, dtype=np.float64)
        circles = np.array(obstacles, dtype=np.float64).reshape(-1, 3)
        wanted = np.array(np.nan if speed is None else speed, dtype=np.float64)
    except (TypeError, ValueError):
        raise PathError(got="something else", expected="numbers x, z of each point") from None
    if places.ndim != 2 or places.shape[1] != 2:
        raise PathError(
            got=f"an array of shape {places.shape}", expected="two numbers for each point"
        )
    if wanted.ndim > 1 or (wanted.ndim == 1 and wanted.shape != places.shape[:1]):
        raise PathError(got=f"{wanted.size} speeds", expected=f"one or {len(places)}")
    wanted = np.broadcast_to(wanted, len(places))
    apart = np.linalg.norm(np.diff(places, axis=0), axis=1) >= _SAME_M
    # Where a point is not finite this is not true, and it is kept to be found below.
    apart = np.concatenate([[True], apart | ~np.isfinite(places[1:]).all(axis=1)])
    places, wanted = places[apart], wanted[apart]
    if len(places) > 2 and (places[0] == places[-1]).all():
        places, wanted, closed = places[:-1], wanted[:-1], True
    _check_points(places, closed)
    bad = np.flatnonzero((wanted <= 0) | np.isinf(wanted) | (wanted > 20))
    if bad.size:
        raise PathError(
            got=f"speed {wanted[bad[0]]:g} at point {bad[0] + 1}", expected="0 … 20 m/s"
        )
    if len(circles) > MAX_OBSTACLES:
        raise PathError(got=f"{len(circles)} obstacles", expected=f"at most {MAX_OBSTACLES}")
    if not np.isfinite(circles).all() or (circles[:, 2] < 0).any():
        raise PathError(
            got="an obstacle that is no circle", expected="finite x, z and a radius ≥ 0"
        )
    if end is not None and not (math.isfinite(end[0]) and math.isfinite(end[1])):
        raise PathError(got="an end that is not finite", expected="x and z in metres")
    return Sketch(
        points=places, speed=wanted.copy(), spline=spline, closed=closed, end=end, obstacles=circles
    )


def _check_points(places: np.ndarray, closed: bool) -> None:
    bad = np.flatnonzero(~np.isfinite(places).all(axis=1))
    if bad.size:
        values = ", ".join(f"{v:g}" for v in places[bad[0]])
        raise PathError(got=f"({values}) as point {bad[0] + 1}", expected="finite numbers")
    if len(places) < 2:
        raise PathError(
            got=f"a path of {len(places)} point", expected="at least two that are apart"
        )
    around = np.concatenate([places, places[:1]]) if closed else places
    steps = np.linalg.norm(np.diff(around, axis=0), axis=1)
    inner = steps[: len(places) - 1]  # the last way of a closed path may be long
    # Of few steps one may be long on both ways, there and back.
    usual = np.median(inner) if len(inner) > 4 else np.sort(inner)[-2:][0]
    longest = int(np.argmax(inner))
    if len(inner) > 1 and inner[longest] > max(_JUMP * usual, 1.0):
        raise PathError(
            got=f"a jump of {inner[longest]:.3g} m after point {longest + 1}",
            expected=f"steps about as long as the others ({usual:.3g} m)",
        )
    if not 0.1 <= steps.sum() <= MAX_LENGTH_M:
        raise PathError(got=f"a path of {steps.sum():.3g} m", expected=f"0.1 … {MAX_LENGTH_M:g} m")


def load_sketch(path: str | Path, *, spline: bool = False, closed: bool = False) -> Sketch:
    """Reads a sketch from a CSV or JSON file (see this module).

    Args:
        path: the file; ``.json`` is JSON, all else CSV.
        spline, closed: also where the file does not say so.

    Raises:
        FileFormatError: names the file and, where it is known, the line.
    """
    return parse_sketch(path, read_text(path, "path"), spline=spline, closed=closed)


def parse_sketch(
    path: str | Path, text: str, *, spline: bool = False, closed: bool = False
) -> Sketch:
    """The sketch in a text as :func:`load_sketch` reads it from a file of that name."""
    fields = (
        _from_json(path, text) if Path(path).suffix.lower() == ".json" else read_csv(path, text)
    )
    fields["spline"] = fields.get("spline", False) or spline
    fields["closed"] = fields.get("closed", False) or closed
    try:
        return make_sketch(**fields)
    except PathError as error:
        raise FileFormatError(path, None, error.got, error.expected) from None


def _from_json(path: str | Path, text: str) -> dict[str, Any]:
    root = parse_json(path, text, expected="a JSON object with points")
    if isinstance(root, list):
        root = {"points": root}
    if not isinstance(root, dict) or "points" not in root:
        raise FileFormatError(path, None, "no points", 'an object {"points": [[x, z], …]}')
    unknown = sorted(set(root) - set(_KEYS))
    if unknown:
        raise FileFormatError(path, None, f"the key {quoted(unknown[0])}", " | ".join(_KEYS))
    fields = {key: root[key] for key in ("points", "spline", "closed", "speed") if key in root}
    for key in ("spline", "closed"):
        if not isinstance(fields.get(key, False), bool):
            raise FileFormatError(path, None, f"{key} {fields[key]!r:.40}", "true or false")
    for key, width in (("points", 2), ("obstacles", 3)):
        rows = root.get(key, [])
        if not isinstance(rows, list) or not all(_numbers(row, width) for row in rows):
            raise FileFormatError(path, None, f"{key} of another form", f"lists of {width} numbers")
    speed = root.get("speed")
    if not (speed is None or isinstance(speed, float) or _numbers(speed, len(root["points"]))):
        raise FileFormatError(path, None, f"speed {speed!r:.40}", "a number, or one for each point")
    fields["obstacles"] = root.get("obstacles", [])
    if root.get("end") is not None:
        fields["end"] = _end(path, root["end"])
    return fields


def _numbers(value: Any, count: int) -> bool:
    return (
        isinstance(value, list) and len(value) == count and all(isinstance(v, float) for v in value)
    )


def _end(path: str | Path, value: Any) -> tuple[float, float, float]:
    expected = '{"place": [x, z], "heading_deg": number or nothing}'
    if not isinstance(value, dict) or set(value) - {"place", "heading_deg"}:
        raise FileFormatError(path, None, f"end {value!r:.60}", expected)
    heading = value.get("heading_deg", math.nan)
    if not _numbers(value.get("place"), 2) or not isinstance(heading, float):
        raise FileFormatError(path, None, f"end {value!r:.60}", expected)
    return value["place"][0], value["place"][1], math.radians(heading)
