"""Acclaim ASF skeletons and AMC motions, as the CMU motion capture library has them.

A bone of an ASF file turns about its own beginning, so each bone becomes a joint at the place where
it begins; the ends of the last bones become joints called ``<bone>_end``. With C the rotation given
by a bone's ``axis`` and M that of its channels, the local rotation is C·M·C⁻¹: rest directions are
world directions, as everywhere in this package. Angles apply in the order in which they are listed:
``rx ry rz`` means Rz·Ry·Rx.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mgjax.core import quaternion
from mgjax.core.arrays import Array
from mgjax.core.errors import FileFormatError
from mgjax.core.skeleton import MAX_DEPTH, MAX_OFFSET_M, Skeleton
from mgjax.io.acclaim.sections import (
    ROOT,
    Bone,
    Line,
    bare_lines,
    read_bones,
    read_root,
    read_units,
    sections,
)
from mgjax.io.reading.units import UNITS, Unit
from mgjax.io.text import (
    quoted,
    read_text,
)


@dataclass(frozen=True, kw_only=True)
class AsfFile:
    """An ASF skeleton, with what is needed to read motions for it."""

    path: Path
    skeleton: Skeleton
    unit: Unit
    channels: dict[str, tuple[str, ...]]
    axes: dict[str, Array]  # bone → quaternion C
    root_position: np.ndarray


def read_asf(path: str | Path, units: str | None = None) -> AsfFile:
    """Reads an ASF skeleton; :class:`FileFormatError` names file and line of what is wrong.

    Args:
        path: the file.
        units: a key of :data:`mgjax.io.reading.units.UNITS`, instead of the length it states.
    """
    lines = bare_lines(path, read_text(path, "ASF"))
    stated = {"length": 1.0, "angle": "deg"}
    root = Bone(name=ROOT, line=1)
    root.dof = ["tx", "ty", "tz", "rx", "ry", "rz"]
    bones: dict[str, Bone] = {}
    tree: list[Line] = []
    seen: set[str] = set()
    for section, body in sections(path, lines):
        seen.add(section)
        if section == "units":
            read_units(path, body, stated)
        elif section == "root":
            read_root(path, body, root)
        elif section == "bonedata":
            bones = read_bones(path, body)
        elif section == "hierarchy":
            tree = body
    for section in ("root", "bonedata", "hierarchy"):
        if section not in seen:
            raise FileFormatError(path, lines[-1][0], f"no section :{section}", "a whole ASF file")
    metres = 0.0254 / float(stated["length"])
    unit = Unit(name=f"inch / {stated['length']:g} (as stated)", metres=metres)
    unit = UNITS[units] if units is not None else unit
    return _assemble(Path(path), root, bones, tree, unit, str(stated["angle"]))


def _assemble(
    path: Path, root: Bone, bones: dict[str, Bone], tree: list[Line], unit: Unit, angle: str
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


def _reach(path: Path, bone: Bone, unit: Unit) -> np.ndarray:
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
    path: Path, bones: dict[str, Bone], order: list[str], parents: dict[str, str]
) -> None:
    depth = {ROOT: 1}
    for name in order:
        depth[name] = depth[parents[name]] + 1
        if depth[name] >= MAX_DEPTH:
            got = f"bones nested {MAX_DEPTH} deep"
            raise FileFormatError(path, bones[name].line, got, "a skeleton")


def _end_names(bones: list[str], taken: set[str]) -> list[str]:
    """``<bone>_end`` for each, with more underscores where a bone has that name already."""
    ends: list[str] = []
    for bone in bones:
        name = f"{bone}_end"
        while name in taken:
            name += "_"
        taken.add(name)
        ends.append(name)
    return ends


def _turn(angles: np.ndarray, order: str) -> Array:
    """Angles (x, y, z), applied in ``order``: XYZ means Rz·Ry·Rx."""
    columns = ["XYZ".index(letter) for letter in reversed(order)]
    return quaternion.from_euler(angles[..., columns], order[::-1])


def _order_bones(
    path: Path, bones: dict[str, Bone], tree: list[Line]
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
