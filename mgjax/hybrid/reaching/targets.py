"""What hands and head are to reach on a walk, and the files that say so.

A JSON file is a list of targets, or an object with the list as ``targets``:

    [{"limb": "right_hand", "place": [0.6, 1.9, 4], "when": "passing", "hold_s": 0.3},
     {"limb": "left_hand", "track": [[0, -0.3, 1.1, 6], [0.5, -0.3, 1.4, 6.2]], "when": 4.5},
     {"limb": "head", "bar": {"from": [-1, 1.5, 8], "to": [1, 1.5, 8], "radius": 0.03}}]

Places are x, y, z in metres, y up. ``when`` is a number, ``"start"``, ``"passing"`` or ``"end"``
(see :class:`Target`); a bar has none, the head ducks where the walk passes it. A track is a moving
target: seconds from the beginning of the hold, and places; it is held as long as it lasts. Several
targets with the same time that is not ``"passing"`` are reached together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.interpolate import PchipInterpolator

from mgjax.core.errors import FileFormatError, ReachError
from mgjax.hybrid.ik.limbs import LIMB_TYPES, LIMBS, LimbKind
from mgjax.io.json_text import parse_json
from mgjax.io.text import quoted, read_text

WORDS = ("start", "passing", "end")
HOLD_S = 0.3
"""How long a target is held where nothing is said."""
MAX_HOLD_S = 60.0
MAX_PLACE_M = 1000.0
MAX_TARGETS = 64
_KEYS = ("limb", "place", "track", "bar", "when", "hold_s")


@dataclass(frozen=True, kw_only=True)
class Bar:
    """A straight bar to be ducked under.

    Attributes:
        ends: of its axis, m. [2, 3]
        radius: m.
    """

    ends: Float[np.ndarray, "2 3"]
    radius: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Target:
    """Where a limb's end is to be, and when.

    Attributes:
        limb: one of :data:`mgjax.hybrid.ik.limbs.LIMBS`.
        when: ``"start"``: before the walk, which begins when it is over. ``"passing"``: where the
            walk comes by. ``"end"``: when the walk is over. A number: that many seconds of the
            walk's own time after its beginning (time during which it stands still for a target not
            counted), or the first time after that at which the target is within reach.
        hold_s: how long the end stays, s.
        seconds: of the places, from the beginning of the hold, s. [K]
        places: of the target, m; one if it does not move. [K, 3]
        bar: the bar that the head ducks under; then there are no places.
    """

    limb: str
    when: float | str
    hold_s: float
    seconds: Float[np.ndarray, " K"]
    places: Float[np.ndarray, "K 3"]
    bar: Bar | None = None

    def at(self, seconds: Float[np.ndarray, " T"]) -> Float[np.ndarray, "T 3"]:
        """Places at times from the beginning of the hold, m; before and after it those at its ends.

        Between the given places a monotone cubic, so that the hand stops nowhere on the way.
        """
        if len(self.seconds) == 1:
            return np.broadcast_to(self.places[0], (len(seconds), 3)).copy()
        inside = np.clip(seconds, self.seconds[0], self.seconds[-1])
        return np.asarray(PchipInterpolator(self.seconds, self.places)(inside))


def make_target(
    limb: str,
    *,
    place: Any = None,
    track: Any = None,
    bar: tuple[Any, Any, Any] | None = None,
    when: Any = None,
    hold_s: Any = HOLD_S,
) -> Target:
    """A target; see :class:`Target`. Exactly one of place, track ([s, x, y, z] rows) and bar.

    Raises:
        ReachError: an unknown limb, no time, a place under the floor, numbers that are not finite.
    """
    if limb not in LIMBS:
        raise ReachError(got=f"the limb {quoted(str(limb))}", expected=" | ".join(LIMBS))
    kinds = [
        name for name, x in (("place", place), ("track", track), ("bar", bar)) if x is not None
    ]
    if len(kinds) != 1:
        got = " and ".join(kinds) or "no place"
        raise ReachError(got=f"{got} for the {limb}", expected="one of place | track | bar")
    if bar is not None:
        return _bar_target(limb, bar, when)
    _check_when(limb, when, hold_s)
    assert when is not None
    rows = _numbers(limb, track, 4) if place is None else _numbers(limb, [[0.0, *_row(place)]], 4)
    seconds, places = rows[:, 0], rows[:, 1:]
    if seconds[0] != 0 or (np.diff(seconds) < 1e-3).any() or seconds[-1] > MAX_HOLD_S:
        raise ReachError(
            got=f"a track of the {limb} with times {seconds.tolist()!s:.60}",
            expected=f"growing ones from 0 to at most {MAX_HOLD_S:g} s",
        )
    low = np.flatnonzero(places[:, 1] < 0)
    if low.size:
        height = places[low[0], 1]
        got = f"a target of the {limb} under the floor (y = {height:g} m)"
        raise ReachError(got=got, expected="y ≥ 0")
    hold_s = float(seconds[-1]) if len(seconds) > 1 else float(hold_s)
    return Target(limb=limb, when=when, hold_s=hold_s, seconds=seconds, places=places)


def _bar_target(limb: str, bar: tuple[Any, Any, Any], when: Any) -> Target:
    if LIMB_TYPES[limb].kind is not LimbKind.HEAD:
        raise ReachError(got=f"a bar for the {limb}", expected="one for the head")
    if when not in (None, "passing"):
        raise ReachError(got=f"a bar at {when!r:.40}", expected="no time: it is where it is passed")
    ends = _numbers(limb, bar[:2], 3)
    radius = bar[2]
    if not (isinstance(radius, int | float) and 0 <= radius <= 1):
        raise ReachError(got=f"a bar of radius {radius!r:.40}", expected="0 … 1 m")
    if (ends[:, 1] < 0).any() or np.linalg.norm(ends[1] - ends[0]) < 1e-3:
        raise ReachError(got="a bar of no length or under the floor", expected="two ends, y ≥ 0")
    none = np.zeros((0, 3))
    return Target(limb=limb, when="passing", hold_s=0.0, seconds=np.zeros(0), places=none,
                  bar=Bar(ends=ends, radius=float(radius)))  # fmt: skip


def _check_when(limb: str, when: Any, hold_s: Any) -> None:
    expected = f"seconds ≥ 0 | {' | '.join(WORDS)}"
    if when is None:
        raise ReachError(got=f"no time for the {limb}", expected=f"when: {expected}")
    number = isinstance(when, int | float) and not isinstance(when, bool)
    if not (when in WORDS if isinstance(when, str) else number and 0 <= when < math.inf):
        raise ReachError(got=f"when = {when!r:.40} for the {limb}", expected=expected)
    if not (isinstance(hold_s, int | float) and 0 <= hold_s <= MAX_HOLD_S):
        raise ReachError(got=f"hold_s = {hold_s!r:.40}", expected=f"0 … {MAX_HOLD_S:g} s")


def _row(place: Any) -> list[Any]:
    return list(place) if isinstance(place, list | tuple | np.ndarray) else [place]


def _numbers(limb: str, rows: Any, width: int) -> np.ndarray:
    """Rows of finite numbers."""
    what = "[s, x, y, z] of each place" if width == 4 else "[x, y, z]"
    try:
        numbers: np.ndarray = np.array(rows, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.ndim != 2 or numbers.shape[1] != width or not len(numbers):
        got = f"{rows!r:.60}"
        raise ReachError(got=f"{got} for the {limb}", expected=f"numbers {what}")
    if not np.isfinite(numbers).all() or (np.abs(numbers) > MAX_PLACE_M).any():
        raise ReachError(
            got=f"{numbers.tolist()!s:.60} for the {limb}", expected=f"finite {what} in m"
        )
    return numbers


def load_targets(path: str | Path) -> tuple[Target, ...]:
    """Reads targets from a JSON file (see this module).

    Raises:
        FileFormatError: names the file, the target, what stands there and what should.
    """
    return parse_targets(path, read_text(path, "reach"))


def parse_targets(path: str | Path, text: str) -> tuple[Target, ...]:
    """The targets in a text as :func:`load_targets` reads them from a file of that name."""
    root = parse_json(
        path,
        text,
        expected="a JSON list of targets",
        nested="a list of targets",
    )
    rows = root.get("targets") if isinstance(root, dict) and set(root) == {"targets"} else root
    if not isinstance(rows, list) or not 1 <= len(rows) <= MAX_TARGETS:
        got = f"{len(rows)} targets" if isinstance(rows, list) else "something else"
        raise FileFormatError(path, None, got, f"a list of 1 … {MAX_TARGETS} targets")
    return tuple(_target(path, number, row) for number, row in enumerate(rows, 1))


def _target(path: str | Path, number: int, row: Any) -> Target:
    if not isinstance(row, dict) or "limb" not in row:
        got = f"target {number} without a limb"
        raise FileFormatError(path, None, got, '{"limb": …, "place": [x, y, z], "when": …}')
    unknown = sorted(set(row) - set(_KEYS))
    if unknown:
        raise FileFormatError(path, None, f"the key {quoted(unknown[0])}", " | ".join(_KEYS))
    fields = {key: row[key] for key in _KEYS[1:] if key in row}
    bar = fields.get("bar")
    if bar is not None:
        if not isinstance(bar, dict) or set(bar) - {"from", "to", "radius"} or len(bar) < 2:
            expected = '{"from": [x, y, z], "to": [x, y, z], "radius": m}'
            raise FileFormatError(path, None, f"the bar {bar!r:.60}", expected)
        fields["bar"] = (bar.get("from"), bar.get("to"), bar.get("radius", 0.0))
    try:
        return make_target(row["limb"], **fields)
    except ReachError as error:
        got = f"{error.got} (target {number})"
        raise FileFormatError(path, None, got, error.expected) from None
