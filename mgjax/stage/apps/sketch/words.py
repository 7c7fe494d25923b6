"""What came of a drawing, in words and figures."""

from __future__ import annotations

import math
from typing import Literal

from mgjax.core.errors import ConfigError
from mgjax.hybrid.paths.result import PathResult
from mgjax.hybrid.reaching.result import Reached
from mgjax.stage.apps.sketch.solve import Solution

Tone = Literal["good", "bad", "plain", "busy"]
EMPTY = "Draw on the floor where to walk, or take a ready-made path."
DONE = ("reached", "cleared")


def sentence(solution: Solution) -> tuple[str, Tone]:
    """What came of it, and whether that is good."""
    if solution.trouble and solution.walked is None:
        return f"Cannot walk there: {solution.trouble}.", "bad"
    route, curve = solution.route, solution.curve
    if route is None or curve is None:
        return EMPTY, "plain"
    text, tone = _walk_words(solution, route, curve.length)
    if solution.trouble:
        return f"{text}. Nothing is reached: {solution.trouble}.", "bad"
    if solution.reached is not None:
        rows = solution.reached.targets
        done = sum(row.status in DONE for row in rows)
        if done < len(rows):
            tone = "bad" if solution.extended else "plain"
        names = list(solution.drawing.names().values())[len(solution.drawing.obstacles) :]
        if len(rows) == 1:
            text += f"; {names[0]} {target_words(solution, 0)}"
        else:
            text += f"; {done} of {len(rows)} targets reached"
    return text + ".", tone


def _walk_words(solution: Solution, route: PathResult, length: float) -> tuple[str, Tone]:
    if route.failed_at is not None:
        x, z = route.failed_at
        place = f"beyond ({x:.1f}, {z:.1f}), after {route.failed_s or 0:.1f} of {length:.1f} m"
        if route.status == "time_limit":
            return f"No way found yet {place}", "busy"
        return f"Cannot follow {place}: no walk stays near the path there", "bad"
    added = way_added(solution)
    if added:
        return f"Walks {route.seconds:.1f} s, {added:.1f} m of it aside to what is reached", "good"
    text = (
        f"Follows {length:.1f} m in {route.seconds:.1f} s, mean distance"
        f" {_cm(route.mean_distance)}, largest {_cm(route.largest_distance)}"
    )
    return text, "good"


def way_added(solution: Solution) -> float:
    """Length of the ways that lead aside to targets, m; 0 where the path is followed."""
    rows = () if solution.reached is None else solution.reached.targets
    return sum(row.extended_m for row in rows)


def target_words(solution: Solution, number: int) -> str:
    """What came of one target."""
    if solution.reached is None:
        return "not looked for yet"
    row = solution.reached.targets[number]
    rate = solution.reached.motion.frame_rate
    if row.target.bar is not None:
        return _bar_words(row)
    if row.status != "reached":
        return _missed(row, solution.extended)
    assert row.first is not None
    assert row.last is not None
    held = (row.last - row.first) / rate
    text = f"reached, {1000 * row.error_m:.1f} mm off, held {held:.2f} s"
    if row.extended_m:
        text += f", {row.extended_m:.1f} m of way added"
    elif row.stopped:
        text += ", standing"
    return text


def _bar_words(row: Reached) -> str:
    if row.status == "hit":
        return f"hit: {_cm(-row.clear_m)} too low even for the deepest duck"
    if row.first is None:
        return f"passed upright, {_cm(row.clear_m)} clear"
    return f"ducked under, {_cm(row.clear_m)} clear"


def _missed(row: Reached, extended: bool) -> str:
    if row.status == "out_of_reach":
        if not extended:
            return "out of reach here; let go, and the walk goes there"
        return "not reached: the walk comes nowhere near enough"
    if row.status == "too_high":
        return "not reached: too high"
    if row.status == "limits":
        short = "" if math.isnan(row.error_m) else f", {_cm(row.error_m)} short"
        return f"not reached: the joints do not turn so far{short}"
    if row.status == "lost":
        return "not reached: no walk leads there"
    if row.status == "missed":
        return f"not reached: another target or bar is too near in time, {_cm(row.hold_m)} off"
    if row.status == "too_fast":
        return "not reached: a joint would turn too fast"
    raise ConfigError(got=f"status {row.status!r}", expected="one of a target's")


def figures(solution: Solution) -> list[tuple[str, str]]:
    """Name and value of what is worth knowing, in the order in which it is read."""
    route, curve = solution.route, solution.curve
    if route is None or curve is None:
        return []
    length = curve.length
    rows = [("path", f"{length:.1f} m")]
    motion = solution.motion
    assert motion is not None
    seconds = (motion.num_frames - 1) / motion.frame_rate
    rows.append(("motion", f"{seconds:.1f} s"))
    if not way_added(solution):
        rows += [
            ("mean distance", _cm(route.mean_distance)),
            ("largest distance", _cm(route.largest_distance)),
        ]
    rows.append(("foot slide", f"{1000 * route.slide:.2f} mm a frame"))
    if solution.reached is not None:
        rows.append(("fastest joint", f"{solution.reached.fastest_deg_s:.0f}°/s"))
    proven = f", {route.proven} of {route.windows} horizons proven" if route.windows else ""
    rows.append(("search", f"{1000 * route.search_s:.0f} ms{proven}"))
    if solution.reached is not None:
        rows.append(("reaching", f"{1000 * solution.reached.solve_s:.0f} ms"))
    return rows


def _cm(metres: float) -> str:
    centimetres = 100 * metres
    return f"{centimetres:.1f} cm" if abs(centimetres) < 10 else f"{centimetres:.0f} cm"
