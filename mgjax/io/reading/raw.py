"""A motion as a file has it, before anything is said about unit, axes and floor."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.reading.units import UNITS, Unit


@dataclass(frozen=True)
class Note:
    """Something to say of a file.

    Attributes:
        kind: ``rows``, ``root_folded``, ``beside_body``, ``up_axis``, ``lies``, ``upside_down``,
            ``floor``, ``sides``, ``four_legs`` or ``size``.
        text: one line for a reader.
    """

    kind: str
    text: str


@dataclass(frozen=True, kw_only=True, eq=False)
class RawMotion:
    """Poses in the numbers of a file.

    Attributes:
        path: the file.
        names, parents, end_joints: as in :class:`mgjax.core.skeleton.Skeleton`.
        offsets: [J,3] each joint's place in its parent's frame; the root's is zero.
        lines: [J] line of each joint's offset, 0 where there is none.
        root: [F,3] the root's place.
        rotations: [F,J,4] local rotations, wxyz.
        moving: [F,J,3] each joint's place in its parent's frame where one of them moves, else None.
        frame_rate: frames per second as stated, or as is usual for the format.
        unit: the unit that the file states, or None.
        settled: the file or its format says that Y is up and the floor is at 0.
        notes: what was noticed while reading.
    """

    path: Path
    names: tuple[str, ...]
    parents: tuple[int, ...]
    end_joints: tuple[int, ...]
    offsets: np.ndarray
    lines: tuple[int, ...]
    root: np.ndarray
    rotations: np.ndarray
    moving: np.ndarray | None
    frame_rate: float
    unit: Unit | None = None
    settled: bool = False
    notes: tuple[Note, ...] = ()


def settled(path: str | Path, skeleton: Skeleton, motion: Motion) -> RawMotion:
    """What was read from a format that says metres and Y up; no digit is lost."""
    moving = motion.joint_offsets
    return RawMotion(
        path=Path(path),
        names=skeleton.names,
        parents=skeleton.parents,
        end_joints=skeleton.end_joints,
        offsets=np.asarray(skeleton.offsets, np.float64),
        lines=(0,) * skeleton.num_joints,
        root=np.asarray(motion.root_translation, np.float64),
        rotations=np.asarray(motion.local_rotations, np.float64),
        moving=None if moving is None else np.asarray(moving, np.float64),
        frame_rate=motion.frame_rate,
        unit=UNITS["m"],
        settled=True,
    )
