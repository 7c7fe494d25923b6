"""The hierarchy of a BVH file: joints, their offsets and channels; see :mod:`mgjax.io.bvh.read`."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from mgjax.core.errors import FileFormatError
from mgjax.core.skeleton import MAX_DEPTH
from mgjax.io.text import is_count, parse_number, quoted, split_braces

_CHANNEL = re.compile(r"([xyz])(position|rotation)", re.IGNORECASE)


@dataclass(kw_only=True)
class BvhJoint:
    """A joint as the file has it; its offset in the file's unit."""

    name: str
    parent: int
    line: int
    is_end: bool = False
    offset: tuple[float, ...] | None = None
    offset_line: int = 0
    channels: list[tuple[str, str]] = field(default_factory=list)  # (axis, kind)


def read_hierarchy(path: str | Path, lines: list[str]) -> list[BvhJoint]:
    """The joints of the lines above MOTION, a parent before its children."""
    tokens = [(no, t) for no, line in enumerate(lines, 1) for t in split_braces(line)]
    end = (max(len(lines), 1), "the end of the hierarchy")
    at = 0

    def take(expected: str) -> tuple[int, str]:
        nonlocal at
        if at >= len(tokens):
            raise FileFormatError(path, end[0], end[1], expected)
        at += 1
        return tokens[at - 1]

    def must(word: str) -> None:
        line, token = take(word)
        if token.upper() != word:
            raise FileFormatError(path, line, quoted(token), word)

    joints: list[BvhJoint] = []
    names: dict[str, int] = {}
    stack: list[int] = []
    must("HIERARCHY")
    while True:
        expected = "ROOT" if not joints else "JOINT, End Site, OFFSET, CHANNELS or }"
        if joints and not stack:
            if at < len(tokens):
                line, token = tokens[at]
                raise FileFormatError(path, line, quoted(token), "MOTION after a single ROOT")
            break
        line, token = take(expected)
        word = token.upper()
        if (word == "ROOT" and not joints) or (word in ("JOINT", "END") and stack):
            label: list[str] = []
            while (item := take("{"))[1] != "{":
                label.append(item[1])
            name, is_end = " ".join(label), word == "END"
            if not name and not is_end:
                raise FileFormatError(path, line, "no name", f"{word} and a name")
            if not is_end and name in names:
                got = f"a second joint called {quoted(name)} (the first is in line {names[name]})"
                raise FileFormatError(path, line, got, "unique joint names")
            if len(stack) >= MAX_DEPTH:
                raise FileFormatError(path, line, f"joints nested {MAX_DEPTH} deep", "a skeleton")
            if stack and joints[stack[-1]].is_end:
                raise FileFormatError(path, line, f"{token} in an End Site", "OFFSET or }")
            if not is_end:
                names[name] = line
            parent = stack[-1] if stack else -1
            joints.append(BvhJoint(name=name, parent=parent, line=line, is_end=is_end))
            stack.append(len(joints) - 1)
        elif word == "OFFSET" and stack:
            numbers = [parse_number(path, *take("a number"), "OFFSET") for _ in range(3)]
            joints[stack[-1]].offset, joints[stack[-1]].offset_line = tuple(numbers), line
        elif word == "CHANNELS" and stack:
            joints[stack[-1]].channels = _read_channels(path, take)
            if joints[stack[-1]].is_end and joints[stack[-1]].channels:
                raise FileFormatError(path, line, "channels of an End Site", "OFFSET or }")
        elif token == "}" and stack:
            joint = joints[stack.pop()]
            if joint.offset is None:
                raise FileFormatError(path, line, f"no OFFSET for {quoted(joint.name)}", "OFFSET")
        else:
            raise FileFormatError(path, line, quoted(token), expected)
    _name_ends(joints, names)
    return joints


def _name_ends(joints: list[BvhJoint], taken: dict[str, int]) -> None:
    """Calls end sites ``<parent>_end``, ``<parent>_end2`` …, but for names that joints have."""
    numbers: dict[str, int] = {}
    for joint in joints:
        if joint.is_end:
            parent = joints[joint.parent].name
            name = ""
            while not name or name in taken:
                number = numbers[parent] = numbers.get(parent, 0) + 1
                name = f"{parent}_end{number if number > 1 else ''}"
            taken[name], joint.name = joint.line, name


def _read_channels(
    path: str | Path, take: Callable[[str], tuple[int, str]]
) -> list[tuple[str, str]]:
    line, token = take("a number of channels")
    if not is_count(token) or int(token) > 6:
        raise FileFormatError(path, line, quoted(token), "0 … 6 channels")
    channels: list[tuple[str, str]] = []
    for _ in range(int(token)):
        line, token = take("a channel")
        match = _CHANNEL.fullmatch(token)
        if match is None:
            raise FileFormatError(path, line, quoted(token), "Xposition … Zrotation")
        channels.append((match[1].upper(), match[2].lower()))
    positions = [axis for axis, kind in channels if kind == "position"]
    if len(set(positions)) < len(positions):
        raise FileFormatError(path, line, "the same position channel twice", "each at most once")
    return channels
