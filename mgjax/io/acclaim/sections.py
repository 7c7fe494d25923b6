"""The sections of an ASF file: its units, root and bones; see :mod:`mgjax.io.acclaim.asf`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mgjax.core.errors import FileFormatError
from mgjax.io.text import MAX_PLACE_M, parse_number, quoted, split_lines

ROOT = "root"


Line = tuple[int, list[str]]


@dataclass(kw_only=True)
class Bone:
    """A bone, or the root, as the file has it: in its units."""

    name: str
    line: int
    direction: np.ndarray = field(default_factory=lambda: np.zeros(3))
    length: float = 0.0
    axis: np.ndarray = field(default_factory=lambda: np.zeros(3))
    axis_order: str = "XYZ"
    dof: list[str] = field(default_factory=list)


def bare_lines(path: str | Path, text: str) -> list[Line]:
    """Numbers and words of the lines that have any, without comments."""
    lines = [(no, s.split("#", 1)[0].split()) for no, s in enumerate(split_lines(text), 1)]
    lines = [(no, words) for no, words in lines if words]
    if not lines:
        raise FileFormatError(path, None, "nothing but comments", "an ASF or AMC file")
    return lines


def sections(path: str | Path, lines: list[Line]) -> Iterator[tuple[str, list[Line]]]:
    """Name and lines of each section."""
    name, body = "", []
    for no, words in lines:
        if words[0].startswith(":"):
            yield name, body
            name, body = words[0][1:].lower(), []
        elif not name:
            raise FileFormatError(path, no, quoted(words[0]), "a section such as :version")
        else:
            body.append((no, words))
    yield name, body


def read_units(path: str | Path, body: list[Line], units: dict) -> None:
    """Sets the unit of length and of angles from the section of that name."""
    for no, words in body:
        key = words[0].lower()
        if key == "length":
            units["length"] = parse_number(
                path, no, _word(path, no, words, 1), "the unit of length"
            )
            if not 1e-4 <= units["length"] <= 1e4:
                got = f"a unit of length of {quoted(words[1])}"
                raise FileFormatError(path, no, got, "0.0001 … 10000")
        elif key == "angle":
            units["angle"] = _word(path, no, words, 1).lower()
            if units["angle"] not in ("deg", "rad"):
                raise FileFormatError(path, no, quoted(words[1]), "deg or rad")


def read_root(path: str | Path, body: list[Line], root: Bone) -> None:
    """Sets the root's channels, orientation and place from the section of that name."""
    for no, words in body:
        key = words[0].lower()
        if key == "order":
            root.dof = [w.lower() for w in words[1:]]
            _check_dof(path, no, root.dof)
        elif key == "axis":
            root.axis_order = _axis_order(path, no, _word(path, no, words, 1))
        elif key == "position":
            root.direction = np.array(_numbers(path, no, words, 3))
            if np.abs(root.direction).max() > MAX_PLACE_M:
                raise FileFormatError(path, no, "a root far away", f"at most {MAX_PLACE_M:g}")
        elif key == "orientation":
            root.axis = np.array(_numbers(path, no, words, 3))


def read_bones(path: str | Path, body: list[Line]) -> dict[str, Bone]:
    """The bones of the section ``:bonedata`` by name."""
    bones: dict[str, Bone] = {}
    bone: Bone | None = None
    for no, words in body:
        key = words[0].lower()
        if key == "begin":
            bone = Bone(name="", line=no)
        elif bone is None:
            raise FileFormatError(path, no, quoted(words[0]), "begin")
        elif key == "end":
            if not bone.name:
                raise FileFormatError(path, no, "a bone without a name", "name")
            bones[bone.name] = bone
            bone = None
        elif key == "name":
            bone.name = _word(path, no, words, 1)
            if bone.name in bones or bone.name == ROOT:
                raise FileFormatError(
                    path, no, f"a second bone called {quoted(bone.name)}", "unique names"
                )
        elif key == "direction":
            bone.direction = np.array(_numbers(path, no, words, 3))
        elif key == "length":
            bone.length = _numbers(path, no, words, 1)[0]
        elif key == "axis":
            bone.axis = np.array(_numbers(path, no, words, 3))
            bone.axis_order = _axis_order(path, no, _word(path, no, words, 4))
        elif key == "dof":
            bone.dof = [w.lower() for w in words[1:]]
            _check_dof(path, no, bone.dof)
            if any(name[0] == "t" for name in bone.dof):
                raise FileFormatError(
                    path, no, "a bone that moves away from its parent", "rx ry rz"
                )
        # Limits, masses and ids are not needed to read a motion; limits run over several lines.
    if bone is not None:
        raise FileFormatError(path, body[-1][0], "a bone without end", "end")
    return bones


def _word(path: str | Path, no: int, words: list[str], index: int) -> str:
    if len(words) <= index:
        raise FileFormatError(path, no, quoted(" ".join(words)), f"a value after {words[0]}")
    return words[index]


def _numbers(path: str | Path, no: int, words: list[str], count: int) -> list[float]:
    if len(words) < count + 1:
        raise FileFormatError(
            path, no, f"{len(words) - 1} values", f"{count} after {quoted(words[0])}"
        )
    return [parse_number(path, no, w, words[0]) for w in words[1 : count + 1]]


def _axis_order(path: str | Path, no: int, word: str) -> str:
    if sorted(word.upper()) != ["X", "Y", "Z"]:
        raise FileFormatError(path, no, quoted(word), "an axis order such as XYZ")
    return word.upper()


def _check_dof(path: str | Path, no: int, dof: list[str]) -> None:
    for name in dof:
        if name not in ("tx", "ty", "tz", "rx", "ry", "rz") or dof.count(name) > 1:
            raise FileFormatError(path, no, quoted(name), "tx ty tz rx ry rz, each at most once")
