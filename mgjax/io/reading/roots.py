"""Joints above the hips: a floor root, a reference or a scene node, folded into the hips."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mgjax.core import quaternion
from mgjax.core.body.limbs import Limbs, find_limbs
from mgjax.core.body.roles import hips_of
from mgjax.core.body.tree import Tree
from mgjax.io.reading.raw import Note, RawMotion


@dataclass(frozen=True, kw_only=True, eq=False)
class FloorRoot:
    """What was above the hips: a joint that may hold the trajectory over the floor.

    Attributes:
        name: of the joint just above the hips.
        translation: its place in the world, m. [F,3]
        rotation: wxyz. [F,4]
    """

    name: str
    translation: np.ndarray
    rotation: np.ndarray


def fold_root(raw: RawMotion) -> tuple[RawMotion, FloorRoot | None, Limbs | None]:
    """The motion with the hips as its root, and where it has one, the root above them.

    Joints that hang on a joint above the hips (targets of inverse kinematics, props) are no part
    of the body and are left out, with a note. A skeleton without a body stays as it is.

    Returns:
        The motion, its floor root in the unit of the file, its limbs.
    """
    tree = Tree(raw.names, raw.parents, raw.end_joints, raw.offsets)
    limbs = find_limbs(tree)
    if limbs is None:
        return raw, None, None
    hips = hips_of(tree, limbs)
    if hips == 0:
        return raw, None, limbs
    place, turn = _world_of(raw, tree.ancestors(hips)[1])
    offset = raw.offsets[hips] if raw.moving is None else raw.moving[:, hips]
    root = place + np.asarray(quaternion.rotate(turn, np.broadcast_to(offset, place.shape)))
    kept = sorted(tree.below(hips))
    above = [j for j in tree.ancestors(hips)[1:] if j != hips]
    lost = [raw.names[j] for j in range(len(raw.names)) if j not in {*kept, *above}]
    names = ", ".join(raw.names[j] for j in above[::-1])
    notes = [Note("root_folded", f"{names} above the hips folded into them")]
    if lost := [name for name in lost if raw.names.index(name) not in set(raw.end_joints)]:
        text = f"{len(lost)} joints beside the body left out: {', '.join(lost[:5])}"
        notes.append(Note("beside_body", text))
    rotations = raw.rotations[:, kept].copy()
    rotations[:, 0] = np.asarray(quaternion.multiply(turn, raw.rotations[:, hips]))
    folded = replace(_part(raw, kept), root=root, rotations=rotations)
    folded = replace(folded, notes=(*raw.notes, *notes))
    floor = FloorRoot(name=raw.names[above[0]], translation=place, rotation=turn)
    tree = Tree(folded.names, folded.parents, folded.end_joints, folded.offsets)
    return folded, floor, find_limbs(tree)


def _world_of(raw: RawMotion, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """[F,3] place and [F,4] rotation of a joint in the world."""
    chain = [joint]
    while raw.parents[chain[-1]] >= 0:
        chain.append(raw.parents[chain[-1]])
    place, turn = raw.root, raw.rotations[:, 0]
    for j in chain[-2::-1]:
        offset = raw.offsets[j] if raw.moving is None else raw.moving[:, j]
        place = place + np.asarray(quaternion.rotate(turn, np.broadcast_to(offset, place.shape)))
        turn = np.asarray(quaternion.multiply(turn, raw.rotations[:, j]))
    return place, turn


def _part(raw: RawMotion, kept: list[int]) -> RawMotion:
    """The joints ``kept``, the first of which becomes the root; rigid where they all are."""
    number = {joint: new for new, joint in enumerate(kept)}
    offsets = raw.offsets[kept].copy()
    offsets[0] = 0
    moving = None if raw.moving is None else raw.moving[:, kept].copy()
    if moving is not None:
        moving[:, 0] = 0
        if (np.ptp(moving, axis=0) <= 1e-6 * max(np.abs(offsets).max(), 1e-9)).all():
            moving = None
    return replace(
        raw,
        names=tuple(raw.names[j] for j in kept),
        parents=tuple(number.get(raw.parents[j], -1) for j in kept),
        end_joints=tuple(number[j] for j in raw.end_joints if j in number),
        offsets=offsets,
        lines=tuple(raw.lines[j] for j in kept),
        moving=moving,
    )
