"""Acclaim ASF skeletons and AMC motions, as the CMU motion capture library has them.

A bone of an ASF file turns about its own beginning, so each bone becomes a joint at the place where
it begins; the ends of the last bones become joints called ``<bone>_end``. With C the rotation given
by a bone's ``axis`` and M that of its channels, the local rotation is C·M·C⁻¹: rest directions are
world directions, as everywhere in this package. Angles apply in the order in which they are listed:
``rx ry rz`` means Rz·Ry·Rx.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mgjax.core import quaternion
from mgjax.core.arrays import Array
from mgjax.core.errors import FileFormatError
from mgjax.core.skeleton import MAX_DEPTH, MAX_OFFSET_M, Skeleton
from mgjax.io.text import (
    MAX_PLACE_M,
    parse_number,
    quoted,
    read_text,
    split_lines,
)
from mgjax.io.units import Unit

ROOT = "root"

Line = tuple[int, list[str]]


@dataclass(kw_only=True)
class _Bone:
    name: str
    line: int
    direction: np.ndarray = field(default_factory=lambda: np.zeros(3))
    length: float = 0.0
    axis: np.ndarray = field(default_factory=lambda: np.zeros(3))
    axis_order: str = "XYZ"
    dof: list[str] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class AsfFile:
    """An ASF skeleton, with what is needed to read motions for it."""

    path: Path
    skeleton: Skeleton
    unit: Unit
    channels: dict[str, tuple[str, ...]]
    axes: dict[str, Array]  # bone → quaternion C
    root_position: np.ndarray


def read_asf(path: str | Path) -> AsfFile:
    """Reads an ASF skeleton; :class:`FileFormatError` names file and line of what is wrong."""
    lines = _lines(path, read_text(path, "ASF"))
    units = {"length": 1.0, "angle": "deg"}
    root = _Bone(name=ROOT, line=1)
    root.dof = ["tx", "ty", "tz", "rx", "ry", "rz"]
    bones: dict[str, _Bone] = {}
    tree: list[Line] = []
    seen: set[str] = set()
    for section, body in _sections(path, lines):
        seen.add(section)
        if section == "units":
            _read_units(path, body, units)
        elif section == "root":
            _read_root(path, body, root)
        elif section == "bonedata":
            bones = _read_bones(path, body)
        elif section == "hierarchy":
            tree = body
    for section in ("root", "bonedata", "hierarchy"):
        if section not in seen:
            raise FileFormatError(path, lines[-1][0], f"no section :{section}", "a whole ASF file")
    metres = 0.0254 / float(units["length"])
    unit = Unit(name=f"inch / {units['length']:g} (as stated)", metres=metres)
    return _assemble(Path(path), root, bones, tree, unit, str(units["angle"]))


def _lines(path: str | Path, text: str) -> list[Line]:
    found = [(no, s.split("#", 1)[0].split()) for no, s in enumerate(split_lines(text), 1)]
    found = [(no, words) for no, words in found if words]
    if not found:
        raise FileFormatError(path, None, "nothing but comments", "an ASF or AMC file")
    return found


def _sections(path: str | Path, lines: list[Line]) -> Iterator[tuple[str, list[Line]]]:
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


def _read_units(path: str | Path, body: list[Line], units: dict) -> None:
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


def _read_root(path: str | Path, body: list[Line], root: _Bone) -> None:
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


def _read_bones(path: str | Path, body: list[Line]) -> dict[str, _Bone]:
    bones: dict[str, _Bone] = {}
    bone: _Bone | None = None
    for no, words in body:
        key = words[0].lower()
        if key == "begin":
            bone = _Bone(name="", line=no)
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


def _assemble(
    path: Path, root: _Bone, bones: dict[str, _Bone], tree: list[Line], unit: Unit, angle: str
) -> AsfFile:
    order, parents = _order_bones(path, bones, tree)
    _check_depth(path, bones, order, parents)
    names = [ROOT, *order]
    index = {name: i for i, name in enumerate(names)}
    offsets = [np.zeros(3)]
    for name in order:
        offsets.append(
            np.zeros(3) if parents[name] == ROOT else _reach(path, bones[parents[name]], unit)
        )
    with_children = set(parents.values())
    ends = [name for name in order if name not in with_children]
    skeleton = Skeleton(
        names=(*names, *_end_names(ends, set(names))),
        parents=(-1, *(index[parents[n]] for n in order), *(index[n] for n in ends)),
        offsets=np.array(offsets + [_reach(path, bones[n], unit) for n in ends], np.float32),
        end_joints=tuple(range(len(names), len(names) + len(ends))),
    )
    scale = np.pi / 180 if angle == "deg" else 1.0
    members = {ROOT: root, **bones}
    return AsfFile(
        path=path,
        skeleton=skeleton,
        unit=unit,
        channels={n: tuple(members[n].dof) for n in names if members[n].dof},
        axes={n: _turn(members[n].axis * scale, members[n].axis_order) for n in names},
        root_position=root.direction * unit.metres,
    )


def _reach(path: Path, bone: _Bone, unit: Unit) -> np.ndarray:
    """From a bone's beginning to its end, m; the direction need not be a unit vector."""
    length = bone.length * unit.metres
    if abs(length) > MAX_OFFSET_M:
        raise FileFormatError(
            path, bone.line, f"a bone of {length:.3g} m", f"at most {MAX_OFFSET_M:g} m"
        )
    largest = float(np.abs(bone.direction).max())
    if largest < 1e-9:
        return np.zeros(3)
    direction = bone.direction / largest
    return direction / np.linalg.norm(direction) * length


def _check_depth(
    path: Path, bones: dict[str, _Bone], order: list[str], parents: dict[str, str]
) -> None:
    depth = {ROOT: 1}
    for name in order:
        depth[name] = depth[parents[name]] + 1
        if depth[name] >= MAX_DEPTH:
            got = f"bones nested {MAX_DEPTH} deep"
            raise FileFormatError(path, bones[name].line, got, "a skeleton")


def _end_names(bones: list[str], taken: set[str]) -> list[str]:
    """``<bone>_end`` for each, with more underscores where a bone has that name already."""
    found: list[str] = []
    for bone in bones:
        name = f"{bone}_end"
        while name in taken:
            name += "_"
        taken.add(name)
        found.append(name)
    return found


def _turn(angles: np.ndarray, order: str) -> Array:
    """Angles (x, y, z), applied in ``order``: XYZ means Rz·Ry·Rx."""
    columns = ["XYZ".index(letter) for letter in reversed(order)]
    return quaternion.from_euler(angles[..., columns], order[::-1])


def _order_bones(
    path: Path, bones: dict[str, _Bone], tree: list[Line]
) -> tuple[list[str], dict[str, str]]:
    """Bones depth first as the hierarchy lists them, and each one's parent."""
    children: dict[str, list[str]] = {}
    parents: dict[str, str] = {}
    for no, words in tree:
        if len(words) == 1 and words[0].lower() in ("begin", "end"):
            continue
        if words[0] != ROOT and words[0] not in parents:
            raise FileFormatError(path, no, quoted(words[0]), "root or a bone placed before")
        for name in words[1:]:
            if name not in bones:
                raise FileFormatError(path, no, quoted(name), "a bone of :bonedata")
            if name in parents:
                raise FileFormatError(path, no, f"{quoted(name)} a second time", "one parent each")
            parents[name] = words[0]
            children.setdefault(words[0], []).append(name)
    for name, bone in bones.items():
        if name not in parents:
            raise FileFormatError(
                path, bone.line, f"{quoted(name)} without a parent", "all in :hierarchy"
            )
    order: list[str] = []
    stack = children.get(ROOT, [])[::-1]
    while stack:
        order.append(stack.pop())
        stack += children.get(order[-1], [])[::-1]
    return order, parents
