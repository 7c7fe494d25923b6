"""The skeleton: named joints in a tree with fixed bones."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from mgjax.core.arrays import Array
from mgjax.core.body.names import bare
from mgjax.core.errors import SkeletonError
from mgjax.core.xla.pytree import register

MAX_OFFSET_M = 10.0
"""No bone of a body is longer; a larger offset means a wrong unit or a broken file."""

MAX_DEPTH = 256
"""No body has more joints one below the other; a file that nests deeper is broken."""


@register("names", "parents", "end_joints", "roles")
@dataclass(frozen=True, kw_only=True)
class Skeleton:
    """A tree of joints.

    Attributes:
        names: one for each joint, unique.
        parents: index of each joint's parent, −1 for the root; a parent comes before its children.
        offsets: each joint's place in its parent's frame, m. In the rest pose all rotations are
            the identity, so offsets are in world directions.
        end_joints: indices of the joints that only mark the end of a bone (BVH end sites, ASF bone
            ends) and have no rotation of their own.
        roles: (role, joint) where somebody said or saw which joint is which; empty where
            :func:`mgjax.core.body.roles.find_roles` is to find them in the tree.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: Float[Array, "J 3"]
    end_joints: tuple[int, ...] = ()
    roles: tuple[tuple[str, int], ...] = ()

    @property
    def num_joints(self) -> int:
        return len(self.names)

    def index(self, name: str) -> int:
        """Index of the joint called ``name``; :class:`SkeletonError` if there is none."""
        try:
            return self.names.index(name)
        except ValueError:
            raise SkeletonError(f"no joint {name!r}; joints are {', '.join(self.names)}") from None


def rest_positions(skeleton: Skeleton) -> np.ndarray:
    """[J,3] joint positions of the rest pose with the root at the origin."""
    places = np.zeros((skeleton.num_joints, 3))
    offsets = np.asarray(skeleton.offsets, dtype=np.float64)
    for joint, parent in enumerate(skeleton.parents):
        places[joint] = offsets[joint] if parent < 0 else places[parent] + offsets[joint]
    return places - places[0]


@lru_cache(maxsize=64)
def depth_levels(parents: tuple[int, ...]) -> tuple[tuple[int, ...], ...]:
    """Joints grouped by depth, root first: kinematics goes one level at a time."""
    depth: list[int] = []
    levels: list[list[int]] = []
    for joint, parent in enumerate(parents):
        depth.append(0 if parent < 0 else depth[parent] + 1)
        if depth[joint] == len(levels):
            levels.append([])
        levels[depth[joint]].append(joint)
    return tuple(tuple(level) for level in levels)


def validate_skeleton(skeleton: Skeleton) -> None:
    """Raises :class:`SkeletonError` unless names, parents and offsets are usable."""
    names, parents = skeleton.names, skeleton.parents
    offsets = np.asarray(skeleton.offsets)
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise SkeletonError(f"two joints are called {name!r}, expected unique names")
        seen.add(name)
    if len(parents) != len(names) or offsets.shape != (len(names), 3):
        raise SkeletonError(
            f"{len(names)} names, {len(parents)} parents and offsets of shape {offsets.shape},"
            " expected one of each per joint"
        )
    for role, joint in skeleton.roles:
        if not 0 <= joint < len(names):
            raise SkeletonError(f"role {role!r} is joint {joint} of {len(names)}, expected one")
    if not parents or parents[0] != -1:
        raise SkeletonError("the first joint must be the root, with parent -1")
    for joint, parent in enumerate(parents[1:], start=1):
        if not 0 <= parent < joint:
            raise SkeletonError(
                f"joint {names[joint]!r} has parent {parent}, expected an earlier joint"
            )
    if len(depth_levels(parents)) > MAX_DEPTH:
        raise SkeletonError(f"joints are nested more than {MAX_DEPTH} deep, expected a body")
    bad = np.flatnonzero(~(np.abs(offsets) <= MAX_OFFSET_M).all(axis=1))
    if bad.size:
        joint = int(bad[0])
        raise SkeletonError(
            f"joint {names[joint]!r} has offset {offsets[joint].tolist()} m, expected finite"
            f" numbers of at most {MAX_OFFSET_M:g} m"
        )


def first_difference(reference: Skeleton, other: Skeleton) -> str | None:
    """How the hierarchy of ``other`` differs first, or None; bone lengths and namespaces may."""
    for a, b, pa, pb in zip(
        reference.names, other.names, reference.parents, other.parents, strict=False
    ):
        if bare(a) != bare(b):
            return f"joint {b!r} where the reference has {a!r}"
        if pa != pb:
            return (
                f"joint {b!r} hangs on {other.names[pb]!r}"
                f" where the reference has {reference.names[pa]!r}"
            )
    if reference.num_joints != other.num_joints:
        longer = max((reference, other), key=lambda s: s.num_joints)
        which = "only the reference has" if longer is reference else "the reference lacks"
        return f"{which} joint {longer.names[min(reference.num_joints, other.num_joints)]!r}"
    return None
