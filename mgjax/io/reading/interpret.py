"""From the numbers of a file to metres, Y up and a floor at 0: what was found, and how sure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.core.body.height import chain_height
from mgjax.core.body.limbs import LEG, Limbs
from mgjax.core.body.roles import roles_in
from mgjax.core.body.tree import Tree
from mgjax.core.errors import ConfigError, FileFormatError
from mgjax.core.motion import Motion
from mgjax.core.skeleton import MAX_OFFSET_M, Skeleton
from mgjax.io.reading.capture import Capture, Reading
from mgjax.io.reading.raw import Note, RawMotion
from mgjax.io.reading.read_as import ReadAs
from mgjax.io.reading.roots import fold_root
from mgjax.io.reading.stand import sampled, stand, with_roles
from mgjax.io.reading.units import UNITS, FoundUnit, Unit, unit_of_body, unit_of_thing
from mgjax.io.reading.upright import on_four_legs
from mgjax.io.text import MAX_PLACE_M, quoted

BODY_M = (0.9, 2.6)
"""Shortest and tallest body of a person, m."""


def interpret(raw: RawMotion, read_as: ReadAs) -> Capture:
    """Skeleton and motion in metres, Y up, with the floor at 0 where feet show where it is.

    Raises:
        FileFormatError: two units are about as likely; an offset or place is no body's in the unit.
        ConfigError: a role names a joint that is not there.
    """
    smallest = min(UNITS.values(), key=lambda unit: unit.metres)
    said = UNITS[read_as.units] if read_as.units else raw.unit
    _check_size(raw, said or smallest)
    folded, above, limbs = fold_root(raw)
    tree = Tree(folded.names, folded.parents, folded.end_joints, folded.offsets)
    roles = _roles(folded, tree, limbs, read_as)
    height = None if limbs is None and not read_as.roles else _height(folded, tree, roles)
    found = _unit(folded, height, read_as)
    metres = found.unit.metres
    _check_size(folded, found.unit)
    capture = _metric(folded, found, None if height is None else height * metres)
    if above is not None:
        above = replace(above, translation=above.translation * metres)
    if height is not None and not read_as.roles and on_four_legs(sampled(capture), roles):
        return replace(_on_four_legs(capture), floor_root=above)
    if height is not None and not (raw.settled and read_as == ReadAs()):
        capture, above = stand(capture, above, roles, read_as, stated=raw.settled)
    capture = with_roles(capture, limbs, roles, read_as)
    return replace(capture, floor_root=above)


def _on_four_legs(capture: Capture) -> Capture:
    """An animal with the joints of a body: it has a root and no other role."""
    note = Note("four_legs", "it stands on four legs: no body for avoiding, walking or kicking")
    reading = replace(
        capture.reading, height_m=None, notes=(*capture.reading.notes, note), unit_sure=0.0
    )
    skeleton = replace(capture.skeleton, roles=(("root", 0),))
    return replace(capture, skeleton=skeleton, reading=reading)


def _roles(raw: RawMotion, tree: Tree, limbs: Limbs | None, read_as: ReadAs) -> dict[str, int]:
    roles = roles_in(tree, limbs)
    for role, name in read_as.roles:
        if name not in raw.names:
            raise ConfigError(
                f"{raw.path}: got no joint {name!r} for {role!r}, expected one of"
                f" {', '.join(raw.names)}"
            )
        roles[role] = raw.names.index(name)
    return roles


def _height(raw: RawMotion, tree: Tree, roles: dict[str, int]) -> float | None:
    """Height of the body in the unit of the file, or None where its legs are not known."""
    legs = [f"{side}_{part}" for side in ("left", "right") for part in LEG]
    if not set(legs) <= roles.keys():
        return None
    for upper, lower in zip((*legs[:2], *legs[3:5]), (*legs[1:3], *legs[4:6]), strict=True):
        if roles[upper] not in tree.ancestors(roles[lower]):
            names = raw.names[roles[lower]], raw.names[roles[upper]]
            raise ConfigError(
                f"{raw.path}: got {names[0]!r} as {lower!r}, expected a joint below {names[1]!r}"
            )
    return chain_height(tree, roles)


def _unit(raw: RawMotion, height: float | None, read_as: ReadAs) -> FoundUnit:
    if read_as.units is not None:
        return FoundUnit(unit=UNITS[read_as.units], probability=1.0)
    if raw.unit is not None:
        return FoundUnit(unit=raw.unit, probability=1.0)
    if height is None:
        return unit_of_thing(raw.offsets, raw.parents)
    found = unit_of_body(height)
    if found.rival is not None:
        tall = " or ".join(
            f"{height * u.metres:.2f} m in the {u.name}" for u in (found.unit, found.rival)
        )
        raise FileFormatError(
            raw.path, None, f"a body of {tall}", "one unit that is far likelier; say it: --units"
        )
    return found


def _check_size(raw: RawMotion, unit: Unit) -> None:
    """No bone and no place is larger than anything captured."""
    reach = np.abs(raw.offsets).max(axis=1) * unit.metres
    if (reach > MAX_OFFSET_M).any():
        joint = int(np.argmax(reach > MAX_OFFSET_M))
        raise FileFormatError(
            raw.path,
            raw.lines[joint] or None,
            f"an offset of {reach[joint]:.3g} m for {quoted(raw.names[joint])}",
            f"at most {MAX_OFFSET_M:g} m (the unit was taken to be the {unit.name})",
        )
    places = [raw.root[:, None]] if raw.moving is None else [raw.root[:, None], raw.moving]
    for values in places:
        far = np.abs(values).max(axis=(1, 2)) * unit.metres
        if (far > MAX_PLACE_M).any():
            frame = int(np.argmax(far > MAX_PLACE_M))
            got = f"a position of {np.abs(values[frame]).max():.3g} in frame {frame}"
            raise FileFormatError(
                raw.path, None, got, f"at most {MAX_PLACE_M:g} m (unit: {unit.name})"
            )


def _metric(raw: RawMotion, found: FoundUnit, height: float | None) -> Capture:
    metres = found.unit.metres
    skeleton = Skeleton(
        names=raw.names,
        parents=raw.parents,
        offsets=(raw.offsets * metres).astype(np.float32),
        end_joints=raw.end_joints,
    )
    moving = None if raw.moving is None else (raw.moving * metres).astype(np.float32)
    motion = Motion(
        root_translation=(raw.root * metres).astype(np.float32),
        local_rotations=raw.rotations.astype(np.float32),
        frame_rate=float(raw.frame_rate),
        joint_offsets=moving,
    )
    notes = list(raw.notes)
    if height is not None and not BODY_M[0] <= height <= BODY_M[1]:
        text = f"no person is {height:.2f} m tall: is the unit the {found.unit.name}? See --units"
        notes.append(Note("size", text))
    reading = Reading(
        unit=found.unit, unit_sure=found.probability, height_m=height, notes=tuple(notes)
    )
    return Capture(skeleton=skeleton, motion=motion, reading=reading)
