"""A folder of ``walk``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.sketch import make_sketch
from mgjax.hybrid.reaching.targets import make_target
from mgjax.io.load import load_motion
from mgjax.stage.show.body import body_of
from mgjax.stage.show.folders.avoid import walk_spans
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.paths import sketch_lines, sketch_things, target_lines, target_things
from mgjax.stage.show.standing import standing
from mgjax.stage.show.types import Actor, Colour, Show, Span
from mgjax.stage.show.walk import floor_path

_DONE = ("reached", "cleared")


def walk_folder(path: Path, result: dict[str, Any]) -> Show:
    """``result.json`` and ``motion.bvh`` of ``mgjax walk``."""
    skeleton, motion = standing(*load_motion(path / "motion.bvh"))
    asked = result["sketch"]
    end = asked.get("end")
    sketch = make_sketch(
        asked["points"],
        spline=asked["spline"],
        closed=asked["closed"],
        obstacles=asked["obstacles"],
        end=None
        if end is None
        else (*end["place"], np.radians(end.get("heading_deg", float("nan")))),
    )
    rows = result.get("targets", [])
    targets = [
        make_target(
            row["limb"],
            place=row.get("place"),
            track=row.get("track"),
            bar=None
            if "bar" not in row
            else tuple(row["bar"][k] for k in ("from", "to", "radius")),
            when=None if "bar" in row else row["when"],
        )
        for row in rows
    ]
    colours: list[Colour] = ["green" if row["status"] in _DONE else "red" for row in rows]
    names = ["bar" if "bar" in row else row["limb"].replace("_", " ") for row in rows]
    statuses = [row["status"].replace("_", " ") for row in rows]
    reaches = [
        Span(
            row="reaches", start=float(row["from_s"]), end=float(row["to_s"]),
            text=f"{name}: {said}", colour=colour,
        )
        for row, name, said, colour in zip(rows, names, statuses, colours, strict=True)
        if row["from_s"] is not None
    ]  # fmt: skip
    return Show(
        title="Reaching on the way" if rows else "A walk along a path",
        words=_words(result, rows),
        seconds=(motion.num_frames - 1) / motion.frame_rate,
        bodies=[body_of(skeleton)],
        actors=[Actor(id="body", body=0, frames=frames_of(motion))],
        lines=[*sketch_lines(sketch), floor_path("track", motion, "blue"), *target_lines(targets)],
        things=[*sketch_things(sketch), *target_things(targets, colours)],
        spans=reaches if rows else walk_spans(result["walk"]),
        notes=[
            *(
                (name, row["status"].replace("_", " "))
                for name, row in zip(names, rows, strict=True)
            ),
            ("path", f"{make_curve(sketch).length:.2f} m"),
            ("mean distance", f"{100 * result['mean_distance_m']:.1f} cm"),
            ("largest distance", f"{100 * result['largest_distance_m']:.1f} cm"),
            ("search", f"{1000 * result['search_s']:.0f} ms"),
        ],
    )


def _bar(value: dict[str, Any]) -> tuple[Any, Any, Any]:
    return value["from"], value["to"], value["radius"]


def _words(result: dict[str, Any], rows: list[dict[str, Any]]) -> str:
    off = f"{100 * result['mean_distance_m']:.1f} cm off on average"
    if rows:
        done = sum(row["status"] in _DONE for row in rows)
        return f"{done} of {len(rows)} reached; {off}"
    if result["failed_at"] is not None:
        x, z = result["failed_at"]
        return f"{result['status'].replace('_', ' ')}: it leads to ({x:.2f}, {z:.2f}); {off}"
    return f"followed, {off}, {100 * result['largest_distance_m']:.0f} cm at most"
