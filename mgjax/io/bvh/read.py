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
from pathlib import Path

import numpy as np

from mgjax.core import quaternion
from mgjax.core.errors import FileFormatError
from mgjax.core.motion import Motion
from mgjax.core.skeleton import MAX_OFFSET_M, Skeleton
from mgjax.io.bvh.hierarchy import BvhJoint, read_hierarchy
from mgjax.io.text import (
    MAX_PLACE_M,
    check_size,
    is_count,
    is_plain,
    parse_number,
    quoted,
    read_text,
    split_lines,
)
from mgjax.io.units import UNITS, Unit, find_unit

_COMMON_RATES = (24, 25, 30, 48, 50, 60, 90, 100, 120, 240)


def read_bvh(
    path: str | Path, *, frame_rate: float | None = None, units: str | None = None
) -> tuple[Skeleton, Motion, Unit]:
    """Reads a BVH file.

    Args:
        path: the file.
        frame_rate: frames per second, instead of what the file states.
        units: ``"m"``, ``"cm"`` or ``"cmu"``, instead of the unit that makes the rest pose a body.

    Returns:
        Skeleton (m), motion (m, rad) and the unit the file was found to be in.

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
    values = _read_rows(path, lines, first, count, channels)
    check_size(path, count, len(joints))

    offsets = np.array([j.offset for j in joints], dtype=np.float64)
    smallest = min(UNITS.values(), key=lambda u: u.metres)
    _check_offsets(path, joints, offsets, UNITS.get(units or "", smallest))
    unit = find_unit(offsets, tuple(j.parent for j in joints), units)
    _check_offsets(path, joints, offsets, unit)
    positions = np.array([kind == "position" for j in joints for _, kind in j.channels])
    far = (np.abs(values) > MAX_PLACE_M / unit.metres) & positions
    if far.any():
        frame = int(np.argmax(far.any(axis=1)))
        got = f"a position of {values[frame, int(np.argmax(far[frame]))]:.3g} in frame {frame}"
        raise FileFormatError(path, None, got, f"at most {MAX_PLACE_M:g} m (unit: {unit.name})")
    skeleton, motion = _assemble(joints, offsets * unit.metres, values, unit.metres)
    _check_offsets(path, joints, np.asarray(skeleton.offsets, np.float64), UNITS["m"])
    rate = frame_rate if frame_rate is not None else _stated_rate(period)
    return skeleton, Motion(**motion, frame_rate=float(rate)), unit


def _check_offsets(
    path: str | Path, joints: list[BvhJoint], offsets: np.ndarray, unit: Unit
) -> None:
    too_long = np.flatnonzero(np.abs(offsets).max(axis=1) > MAX_OFFSET_M / unit.metres)
    if too_long.size:
        joint = joints[int(too_long[0])]
        length = float(np.abs(offsets[too_long[0]]).max()) * unit.metres
        raise FileFormatError(
            path,
            joint.offset_line,
            f"an offset of {length:.3g} m for {quoted(joint.name)}",
            f"at most {MAX_OFFSET_M:g} m (the unit was taken to be the {unit.name})",
        )


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


def _read_rows(
    path: str | Path, lines: list[str], first: int, frames: int, channels: int
) -> np.ndarray:
    """[frames, channels]; rows may be wrapped, but the numbers must come out even."""
    text = " ".join(lines[first:])
    tokens = text.split()
    if len(tokens) != frames * channels:
        got, rest = divmod(len(tokens), max(channels, 1))
        for number, line in enumerate(lines[first:], first + 1):
            if rest and (size := len(line.split())) not in (0, channels):
                raise FileFormatError(path, number, f"{size} values", f"{channels} in each row")
        raise FileFormatError(
            path,
            len(lines),
            f"{got} rows and {rest} values",
            f"the {frames} rows of {channels} stated",
        )
    finite = is_plain(text)
    try:
        values = np.array(tokens, dtype=np.float64)
        finite = finite and bool(np.isfinite(values).all())
    except ValueError:
        finite = False
    if not finite:
        for number, line in enumerate(lines[first:], first + 1):
            for token in line.split():
                parse_number(path, number, token, "a channel")
    return values.reshape(frames, channels)  # pyright: ignore[reportPossiblyUnboundVariable]


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
    joints: list[BvhJoint], offsets: np.ndarray, values: np.ndarray, metres: float
) -> tuple[Skeleton, dict]:
    frames = len(values)
    rotations = np.zeros((frames, len(joints), 4))
    rotations[..., 0] = 1
    moving = np.broadcast_to(offsets, (frames, *offsets.shape)).copy()
    column = 0
    for index, joint in enumerate(joints):
        block = values[:, column : column + len(joint.channels)]
        column += len(joint.channels)
        turns = [i for i, (_, kind) in enumerate(joint.channels) if kind == "rotation"]
        order = "".join(joint.channels[i][0] for i in turns)
        if turns:
            rotations[:, index] = quaternion.from_euler(np.deg2rad(block[:, turns]), order)
        for i, (axis, kind) in enumerate(joint.channels):
            if kind == "position":
                moving[:, index, "XYZ".index(axis)] = block[:, i] * metres
    root = moving[:, 0].copy()
    moving[:, 0] = offsets[0]
    # Position channels that never change are just another way to write the offset. Where they do
    # change, the offset stays what the file says: the rest pose, not the place in frame 0.
    still = (np.ptp(moving, axis=0) <= 1e-6).all(axis=1)
    rigid = bool(still.all())
    skeleton = Skeleton(
        names=tuple(j.name for j in joints),
        parents=tuple(j.parent for j in joints),
        offsets=np.where(still[:, None], moving[0], offsets).astype(np.float32),
        end_joints=tuple(i for i, j in enumerate(joints) if j.is_end),
    )
    motion = {
        "root_translation": root.astype(np.float32),
        "local_rotations": rotations.astype(np.float32),
        "joint_offsets": None if rigid else moving.astype(np.float32),
    }
    return skeleton, motion
