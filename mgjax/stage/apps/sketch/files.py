"""The files of ``mgjax walk``: what is saved as them, and what is opened of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from mgjax.core.errors import FileFormatError
from mgjax.hybrid.paths.sketch import Sketch, parse_sketch
from mgjax.hybrid.reaching.targets import Target, parse_targets


def sketch_text(sketch: Sketch) -> str:
    """A sketch as the JSON that ``mgjax walk --path`` reads."""
    root: dict[str, Any] = {"points": sketch.points.tolist()}
    if sketch.spline:
        root["spline"] = True
    if sketch.closed:
        root["closed"] = True
    if not np.isnan(sketch.speed).any():
        root["speed"] = sketch.speed.tolist()
    if sketch.end is not None:
        x, z, heading = sketch.end
        turned = {} if np.isnan(heading) else {"heading_deg": float(np.degrees(heading))}
        root["end"] = {"place": [x, z], **turned}
    if len(sketch.obstacles):
        root["obstacles"] = sketch.obstacles.tolist()
    return json.dumps(root, allow_nan=False) + "\n"


def targets_text(targets: tuple[Target, ...]) -> str:
    """Targets as the JSON that ``mgjax walk --reach`` reads."""
    rows = [json.dumps(_row(target), allow_nan=False) for target in targets]
    return "[" + ",\n ".join(rows) + "]\n"


def _row(target: Target) -> dict[str, Any]:
    if target.bar is not None:
        start, end = target.bar.ends.tolist()
        bar = {"from": start, "to": end, "radius": target.bar.radius}
        return {"limb": target.limb, "bar": bar}
    if len(target.seconds) > 1:
        track = np.column_stack([target.seconds, target.places]).tolist()
        return {"limb": target.limb, "track": track, "when": target.when}
    return {
        "limb": target.limb,
        "place": target.places[0].tolist(),
        "when": target.when,
        "hold_s": target.hold_s,
    }


def read_upload(name: str, text: str) -> Sketch | tuple[Target, ...]:
    """A path or targets, whichever an uploaded file holds.

    Args:
        name: of the file, for its suffix and for messages; nothing is read from there.
        text: what stands in it.

    Raises:
        FileFormatError: as the command's own loaders.
    """
    named = Path(name).name or "file"
    if not text.strip():
        raise FileFormatError(named, None, "an empty file", "a path or targets")
    if "\0" in text:
        raise FileFormatError(named, None, "binary data", "a path or targets, which are text")
    if Path(named).suffix.lower() == ".json" and _has_targets(text):
        return parse_targets(named, text)
    return parse_sketch(named, text)


def _has_targets(text: str) -> bool:
    """Whether a JSON text looks like targets; what is no JSON does not."""
    try:
        root = json.loads(text)
    except (ValueError, RecursionError):
        return False
    if isinstance(root, dict):
        return "targets" in root
    return isinstance(root, list) and bool(root) and isinstance(root[0], dict)
