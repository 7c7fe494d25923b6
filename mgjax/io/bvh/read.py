"""BVH files: any hierarchy, any number and order of channels, wrapped rows, either line end.

Euler channels are read left to right: ``Zrotation Yrotation Xrotation`` means Rz·Ry·Rx. Position
channels replace the joint's OFFSET, for the root as for every other joint, as the common tools
write them. End sites become joints called ``<parent>_end``.

One reader serves every file. A reader from a library in front of it would be a second code path
for the same format, since joints with 0, 1, 2 or 6 channels and errors with a line number need
this one anyhow; the library is the oracle in the tests instead.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import orjson

from mgjax.core import quaternion
from mgjax.core.errors import FileFormatError
from mgjax.io.bvh.hierarchy import BvhJoint, read_hierarchy
from mgjax.io.reading.raw import Note, RawMotion
from mgjax.io.reading.units import UNITS
from mgjax.io.text import (
    check_size,
    is_count,
    is_plain,
    parse_number,
    quoted,
    read_text,
    split_lines,
)

STILL = 1e-5
"""Position channels that change by less than this share of the longest bone do not move."""

_COMMON_RATES = (24, 25, 30, 48, 50, 60, 90, 100, 120, 240)


MARK = "HIERARCHY \t "
"""First line of a file that ``save_bvh`` wrote: centimetres, Y up, floor at 0. Blanks at the end of
a line are nothing to other tools, and without them the same is found in the motion."""


def read_bvh(path: str | Path) -> RawMotion:
    """Reads a BVH file, its numbers as they are.

    Rows count, not the number of frames that is stated: where they differ, a note says so.

    Raises:
        FileFormatError: names file and line, what stands there and what was expected.
    """
    lines = split_lines(read_text(path, "BVH").rstrip())
    start = next((i for i, s in enumerate(lines) if s.strip().upper() == "MOTION"), None)
    joints = read_hierarchy(path, lines[: len(lines) if start is None else start])
    if start is None:
        raise FileFormatError(path, len(lines), "the end of the file", "MOTION")
    count, period, first = _read_motion_header(path, lines, start)
    channels = sum(len(j.channels) for j in joints)
    if not channels:
        raise FileFormatError(path, start + 1, "a hierarchy without channels", "CHANNELS")
    values = _read_rows(path, lines, first, channels)
    notes: list[Note] = []
    if len(values) != count:
        text = f"{len(values)} rows where {count} frames are stated; all rows were taken"
        notes.append(Note("rows", text))
    check_size(path, len(values), len(joints))
    marked = lines[0] == MARK
    raw = _assemble(Path(path), joints, values, _stated_rate(period))
    return replace(raw, unit=UNITS["cm"] if marked else None, settled=marked, notes=tuple(notes))


def _read_motion_header(
    path: str | Path, lines: list[str], start: int
) -> tuple[int, tuple[float, str], int]:
    """Number of frames, (frame time, its text), index of the first row."""
    at = start + 1
    stated: list[tuple[int, str]] = []
    for word, pattern in (("Frames:", r"frames\s*:(.*)"), ("Frame Time:", r"frame\s*time\s*:(.*)")):
        while at < len(lines) and not lines[at].strip():
            at += 1
        if at >= len(lines):
            raise FileFormatError(path, len(lines), "the end of the file", word)
        match = re.fullmatch(pattern, lines[at].strip(), re.IGNORECASE)
        if match is None:
            raise FileFormatError(path, at + 1, quoted(lines[at].strip()), word)
        stated.append((at + 1, match[1].strip()))
        at += 1
    (count_line, count), (time_line, time) = stated
    if not is_count(count) or int(count) < 1:
        raise FileFormatError(path, count_line, quoted(count), "a number of frames, 1 or more")
    period = parse_number(path, time_line, time, "the frame time")
    if not 1e-4 <= period <= 10:
        got = f"a frame time of {quoted(time)}"
        raise FileFormatError(path, time_line, got, "0.0001 … 10 seconds")
    return int(count), (period, time), at


def _read_rows(path: str | Path, lines: list[str], first: int, channels: int) -> np.ndarray:
    """[frames, channels]; rows may be wrapped, but the numbers must come out even."""
    text = " ".join(lines[first:])
    values = _numbers(text)
    if values is None:
        for number, line in enumerate(lines[first:], first + 1):
            for token in line.split():
                parse_number(path, number, token, "a channel")
        raise FileFormatError(path, first + 1, "what is no number", "numbers")
    got, rest = divmod(len(values), channels)
    if rest:
        for number, line in enumerate(lines[first:], first + 1):
            if (size := len(line.split())) not in (0, channels):
                raise FileFormatError(path, number, f"{size} values", f"{channels} in each row")
    if rest or not got:
        said = f"{got} rows and {rest} values"
        raise FileFormatError(path, len(lines), said, f"rows of {channels} values")
    return values.reshape(got, channels)


def _numbers(text: str) -> np.ndarray | None:
    """All numbers of a text, or None where something in it is no finite number.

    Most files have numbers as JSON has them, which orjson reads three times as fast as Python.
    """
    if not is_plain(text):
        return None
    tokens = text.split()
    try:
        if "t" in text or "f" in text:  # true and false are JSON, too
            raise ValueError
        values = np.fromiter(orjson.loads(f"[{','.join(tokens)}]"), np.float64, len(tokens))
    except (ValueError, TypeError):
        try:
            values = np.fromiter(map(float, tokens), np.float64, len(tokens))
        except ValueError:
            return None
    return values if np.isfinite(values).all() else None


def _stated_rate(period: tuple[float, str]) -> float:
    """Frames per second: a whole rate where the printed frame time is that rate's, rounded.

    ``.0083333`` is 120, ``0.0417`` is 24, ``0.03`` is 30 (of several rates that print alike, a
    common one), ``0.01`` is exactly 100, ``0.0334`` is no rounded whole rate: 29.94.
    """
    seconds, text = period
    mantissa, _, exponent = text.lower().partition("e")
    decimals = len(mantissa.partition(".")[2]) - int(exponent or 0)
    nearest = max(round(1 / seconds), 1)
    if abs(1 / nearest - seconds) <= 1e-9 * seconds:
        return float(nearest)
    likely = min(_COMMON_RATES, key=lambda rate: abs(1 / rate - seconds))
    for rate in (likely, nearest):
        if abs(1 / rate - seconds) <= 0.5 * 10.0**-decimals + 1e-12:
            return float(rate)
    return 1 / seconds


def _assemble(
    path: Path, joints: list[BvhJoint], values: np.ndarray, frame_rate: float
) -> RawMotion:
    frames = len(values)
    offsets = np.array([j.offset for j in joints], dtype=np.float64)
    rotations = np.zeros((frames, len(joints), 4))
    rotations[..., 0] = 1
    places: dict[int, np.ndarray] = {}
    turned: dict[str, tuple[list[int], list[int]]] = {}
    column = 0
    for index, joint in enumerate(joints):
        block = values[:, column : column + len(joint.channels)]
        turns = [i for i, (_, kind) in enumerate(joint.channels) if kind == "rotation"]
        order = "".join(joint.channels[i][0] for i in turns)
        if turns:  # joints whose angles have one order are turned together
            members, columns = turned.setdefault(order, ([], []))
            members.append(index)
            columns += [column + i for i in turns]
        column += len(joint.channels)
        moves = [i for i, (_, kind) in enumerate(joint.channels) if kind == "position"]
        if moves:
            places[index] = np.tile(offsets[index], (frames, 1))
            axes = ["XYZ".index(joint.channels[i][0]) for i in moves]
            places[index][:, axes] = block[:, moves]
    for order, (members, columns) in turned.items():
        angles = np.deg2rad(values[:, columns]).reshape(frames, len(members), -1)
        rotations[:, members] = quaternion.from_euler(angles, order)
    # Where position channels move the root, its OFFSET is a place and no bone.
    root = places.pop(0, np.tile(offsets[0], (frames, 1)))
    offsets[0] = 0
    still = STILL * max(float(np.abs(offsets).max()), 1e-9)
    # Position channels that never change are just another way to write the offset. Where they do
    # change, the offset stays what the file says: the rest pose, not the place in frame 0.
    for index, place in places.items():
        if (np.ptp(place, axis=0) <= still).all():
            offsets[index] = place[0]
    moved = {j: place for j, place in places.items() if (np.ptp(place, axis=0) > still).any()}
    moving = np.tile(offsets, (frames, 1, 1)) if moved else None
    for index, place in moved.items():
        moving[:, index] = place  # type: ignore[index]
    return RawMotion(
        path=path,
        names=tuple(j.name for j in joints),
        parents=tuple(j.parent for j in joints),
        end_joints=tuple(i for i, j in enumerate(joints) if j.is_end),
        offsets=offsets,
        lines=tuple(j.offset_line for j in joints),
        root=root,
        rotations=rotations,
        moving=moving,
        frame_rate=frame_rate,
    )
