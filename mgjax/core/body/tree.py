"""A skeleton as a tree of bones with lengths, and the questions that finding a body asks of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mgjax.core.body.names import NameHint, read_name

_BESIDE = ("helper", "prop", "face")
_LIMB = ("hip", "knee", "ankle", "toe", "clavicle", "shoulder", "elbow", "wrist", "finger")


@dataclass(frozen=True, eq=False)
class Tree:
    """Joints in a tree.

    Attributes:
        names, parents, end_joints: as in :class:`mgjax.core.skeleton.Skeleton`.
        offsets: [J,3] place of each joint in its parent's frame.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    end_joints: tuple[int, ...]
    offsets: np.ndarray

    @cached_property
    def hints(self) -> tuple[NameHint, ...]:
        nothing = NameHint(side="", words=(), weights={})
        ends = set(self.end_joints)
        return tuple(nothing if j in ends else read_name(n) for j, n in enumerate(self.names))

    @cached_property
    def children(self) -> tuple[tuple[int, ...], ...]:
        below: list[list[int]] = [[] for _ in self.names]
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                below[parent].append(joint)
        return tuple(tuple(x) for x in below)

    @cached_property
    def lengths(self) -> np.ndarray:
        """[J] length of the bone from the parent to the joint; the root has none."""
        lengths = np.linalg.norm(self.offsets, axis=1)
        lengths[0] = 0.0
        return lengths

    @cached_property
    def reach(self) -> np.ndarray:
        """[J] length of the longest chain below a joint, without end joints and what is beside.

        The end of a hand or foot is often set to anything; helpers, props and faces are no limbs.
        """
        ends = set(self.end_joints)
        reach = np.zeros(len(self.names))
        for joint in range(len(self.names) - 1, 0, -1):
            if joint not in ends and not self.beside[joint]:
                parent = self.parents[joint]
                reach[parent] = max(reach[parent], reach[joint] + self.lengths[joint])
        return reach

    @cached_property
    def beside(self) -> tuple[bool, ...]:
        """Whether a joint only helps, holds a prop or moves a face, and carries no limb."""
        carries = [hint.has(*_LIMB) and not hint.has(*_BESIDE) for hint in self.hints]
        for joint in range(len(self.names) - 1, 0, -1):
            carries[self.parents[joint]] |= carries[joint]
        return tuple(
            hint.has(*_BESIDE) and not carry
            for hint, carry in zip(self.hints, carries, strict=True)
        )

    @cached_property
    def counts(self) -> list[int]:
        """Number of joints at and below each joint."""
        counts = [1] * len(self.names)
        for joint in range(len(self.names) - 1, 0, -1):
            counts[self.parents[joint]] += counts[joint]
        return counts

    @cached_property
    def sides_above(self) -> list[frozenset[str]]:
        """The sides that the names of each joint's ancestors have."""
        sides: list[frozenset[str]] = [frozenset()]
        for parent in self.parents[1:]:
            own = self.hints[parent].side
            sides.append(sides[parent] | {own} if own else sides[parent])
        return sides

    def ancestors(self, joint: int) -> list[int]:
        """The joint, its parent, … and the root."""
        chain = [joint]
        while self.parents[chain[-1]] >= 0:
            chain.append(self.parents[chain[-1]])
        return chain

    def below(self, joint: int) -> list[int]:
        """The joint and all that hang on it."""
        found = [joint]
        for j in found:
            found.extend(self.children[j])
        return found

    def common(self, joints: list[int]) -> int:
        """The deepest joint on which all ``joints`` hang (or that is one of them)."""
        shared = set(self.ancestors(joints[0])).intersection(*map(self.ancestors, joints[1:]))
        return max(shared)  # a parent comes before its children

    def path(self, top: int, joint: int) -> list[int]:
        """Joints from ``top`` down to ``joint``, both included."""
        chain = self.ancestors(joint)
        return chain[: chain.index(top) + 1][::-1]

    def distance(self, top: int, joint: int) -> float:
        """Length of the bones from ``top`` down to ``joint``."""
        return float(sum(self.lengths[j] for j in self.path(top, joint)[1:]))
