"""Labelled intervals from a JSON file.

    {"clips": {"cmu14/14_02.amc": [{"start_s": 3.74, "end_s": 4.3, "kind": "duck",
                                    "direction": "left", "genuine": true}]}}

Clip paths are relative to the labels file's folder, else to the clips' folder. ``direction``
(default none) and ``genuine`` (default true) may be left out; further keys are left unread. In
paths ``\\`` means ``/``, as Windows writes it, unless a file is called so.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from mgjax.clips.types import Clip, Label, Labels
from mgjax.core.errors import LabelError
from mgjax.io.json_text import parse_json
from mgjax.io.text import read_text
from mgjax.io.user_path import user_path


def load_labels(
    path: str | Path, clips: list[Clip], clips_folder: str | Path
) -> dict[str, tuple[Label, ...]]:
    """Reads labels for ``clips``, whose names are paths relative to ``clips_folder``.

    Raises:
        LabelError: names the file, the clip and the interval: no such clip, an interval outside
            its clip, empty, or overlapping another.
    """
    document = parse_labels(path)
    known = {(user_path(clips_folder) / clip.name).resolve(): clip for clip in clips}
    labels_of: dict[str, tuple[Label, ...]] = {}
    for name, intervals in document.items():
        try:
            places = clip_places(path, name, clips_folder)
            there = any(p.is_file() for p in places)
        except (OSError, ValueError):  # a name that no file can have
            places, there = [], False
        clip = next((known[p] for p in places if p in known), None)
        if clip is None:
            if there:
                continue  # the file is there but was left out of this graph
            raise LabelError(
                path, _line_of(path, name), f"clip {name!r}, which is not there", "a clip"
            )
        if not isinstance(intervals, list):
            raise LabelError(path, _line_of(path, name), f"{name!r}: {intervals!r:.40}", "a list")
        labels = [read_label(path, name, i, item) for i, item in enumerate(intervals)]
        labels_of[clip.name] = labels_of.get(clip.name, ()) + tuple(labels)
    validate_labels(labels_of, clips, source=path)
    return labels_of


def validate_labels(labels: Labels, clips: list[Clip], *, source: str | Path = "labels") -> None:
    """Raises :class:`LabelError` unless every interval lies in its clip and none overlap."""
    motions = {clip.name: clip.motion for clip in clips}
    for name, items in labels.items():
        if name not in motions:
            raise LabelError(source, None, f"labels for {name!r}", "the name of a clip")
        line = _line_of(source, name)
        rate, frames = motions[name].frame_rate, motions[name].num_frames
        before: Label | None = None
        for label in sorted(items, key=lambda x: x.start_s):
            text = f"{name!r}: interval {label.start_s:g} … {label.end_s:g} s"
            limit = frames / rate
            usable = all(abs(x) < 1e9 for x in (label.start_s, label.end_s))  # NaN is not
            start, stop = (
                (round(label.start_s * rate), round(label.end_s * rate)) if usable else (-1, -1)
            )
            if start < 0 or stop > frames:
                raise LabelError(source, line, f"{text} outside the clip", f"0 … {limit:g} s")
            if stop <= start:
                raise LabelError(
                    source, line, f"{text}, which has no frame", "an end after its start"
                )
            if before is not None and start < round(before.end_s * rate):
                raise LabelError(
                    source,
                    line,
                    f"{text} overlapping {before.start_s:g} … {before.end_s:g} s",
                    "intervals that at most touch",
                )
            before = label


def clip_places(path: str | Path, name: str, clips_folder: str | Path) -> list[Path]:
    """Where the clip may lie that a labels file names, the likeliest first.

    Raises:
        OSError, ValueError: no file can have such a name.
    """
    bases = (Path(path).parent, user_path(clips_folder))
    names = (name, name.replace("\\", "/"))
    return [(base / user_path(each)).resolve() for each in names for base in bases]


def parse_labels(path: str | Path) -> dict[str, Any]:
    """The intervals of each clip as they stand in a labels file, numbers as floats.

    Raises:
        LabelError: the file is no JSON object with an object ``clips``.
    """

    def twice(key: str) -> LabelError:
        return LabelError(path, _line_of(path, key), f"{key!r:.80} twice", "it once")

    document = parse_json(
        path,
        read_text(path, "labels"),
        expected="a JSON object",
        error=LabelError,
        twice=twice,
        finite=False,
    )
    clips = document.get("clips") if isinstance(document, dict) else None
    if not isinstance(clips, dict):
        raise LabelError(path, 1, "no object 'clips'", '{"clips": {file: [intervals]}}')
    return clips


def read_label(path: str | Path, clip: str, index: int, item: Any) -> Label:
    """One interval of a clip, as :func:`parse_labels` gives it.

    Raises:
        LabelError: a key is missing or of another type.
    """

    def fail(got: str, expected: str) -> LabelError:
        return LabelError(
            path, _line_of(path, clip), f"{clip!r}, interval {index}: {got}", expected
        )

    if not isinstance(item, dict):
        raise fail(f"{item!r:.40}", "an object with start_s, end_s and kind")
    for key in ("start_s", "end_s"):
        value = item.get(key)
        if isinstance(value, bool) or not isinstance(value, float) or not math.isfinite(value):
            raise fail(f"{key} = {value!r:.40}", "a finite number of seconds")
    if not isinstance(item.get("kind"), str) or not item["kind"]:
        raise fail(f"kind = {item.get('kind')!r:.40}", "a word such as duck")
    direction, genuine = item.get("direction", ""), item.get("genuine", True)
    if not isinstance(direction, str):
        raise fail(f"direction = {direction!r:.40}", "left, right or none")
    if not isinstance(genuine, bool):
        raise fail(f"genuine = {genuine!r:.40}", "true or false")
    return Label(
        start_s=float(item["start_s"]),
        end_s=float(item["end_s"]),
        kind=item["kind"],
        direction="" if direction == "none" else direction,
        genuine=genuine,
    )


def _line_of(path: str | Path, clip: str) -> int | None:
    """Line in which a clip is named, for messages; None where the labels are no file."""
    try:
        lines = Path(path).read_text(errors="replace").splitlines()
    except OSError:
        return None
    keys = json.dumps(clip), json.dumps(clip.replace("/", "\\"))
    return next((no for no, line in enumerate(lines, 1) if any(k in line for k in keys)), None)
