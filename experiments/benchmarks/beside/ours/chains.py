"""Work of chains: ends that meet targets, by positions (FABRIK) or by the joints' rotations."""

from __future__ import annotations

from functools import partial
from typing import Any

import jax
import numpy as np

from experiments.benchmarks.beside.calls import Calls
from experiments.benchmarks.beside.types import Job
from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core import kinematics, quaternion
from mgjax.core.skeleton import Skeleton
from mgjax.hybrid import fabrik, find_limb, reach_pose
from mgjax.hybrid.ik.limbs import Limb

MET_M = 1e-3
SPREAD = np.radians(45.0)
"""Of the random turns whose ends are the hand's targets."""
FIRST = {4: 3, 8: 0}
"""By the number of bones, the joint of the limb at which they begin: collar bone, lower back."""


def points(seed: int, items: int, *, links: int) -> Job:
    """Even chains of length 1 m, a little bent; targets at 0.3 to 0.95 m. Joints are wanted."""
    joints, targets = _bent_chain(seed, items, links)

    def call(number: int) -> Any:
        return jax.block_until_ready(fabrik(joints, targets[number], tolerance=MET_M)[0])

    def miss(number: int, found: Any) -> float:
        return float(np.linalg.norm(np.asarray(found)[-1] - targets[number]))

    data = {"joints": joints.tolist(), "targets": targets.tolist(), "tolerance": MET_M}
    return Job(data=data, ours=Calls(count=items, call=call, miss=miss), tolerance=_slack())


def angles(seed: int, items: int, *, links: int) -> Job:
    """The same chains of ball joints and targets; rotations are wanted."""
    joints, targets = _bent_chain(seed, items, links)
    offsets = np.concatenate([np.zeros((1, 3)), np.diff(joints, axis=0)]).astype(np.float32)
    data = {"offsets": offsets.tolist(), "targets": targets.tolist(), "tolerance": MET_M}
    return Job(data=data, ours=_solved(offsets, targets), tolerance=_slack())


def hand(seed: int, items: int, *, bones: int, together: bool = False) -> Job:
    """The right hand of the embedded body, from rest, to where random turns bring it."""
    offsets = _arm(bones)
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(items, bones + 1, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    turns = quaternion.from_axis_angle(axes, rng.uniform(0, SPREAD, (items, bones + 1)))
    chain = _skeleton(offsets)
    targets = np.asarray(kinematics.forward(chain, np.zeros((items, 3)), np.asarray(turns))[0])
    targets = targets[:, -1].astype(np.float32)
    data = {"offsets": offsets.tolist(), "targets": targets.tolist(), "tolerance": MET_M}
    ours = _solved(offsets, targets, together)
    data |= {"together": True} if together else {}
    return Job(data=data, ours=ours, tolerance=_slack(), each=items if together else 1)


def _slack() -> float:
    """The tolerance, and what single precision may add to it."""
    return 1.01 * MET_M


def _solved(offsets: np.ndarray, targets: np.ndarray, together: bool = False) -> Calls:
    """mgjax's half: the rotations of a chain with its base at the origin, from rest."""
    count, items = len(offsets), len(targets)
    chain = _skeleton(offsets)
    reach = float(np.linalg.norm(offsets[1:], axis=1).sum())
    limb = Limb(name="right_hand", joints=tuple(range(count)), reach_m=reach)
    solve = partial(reach_pose, chain, limbs=(limb,), tolerance=MET_M)
    shape = (items,) if together else ()
    root = np.zeros((*shape, 3), np.float32)
    rest = np.zeros((*shape, count, 4), np.float32)
    rest[..., 0] = 1

    def call(number: int) -> Any:
        wanted = targets[:, None] if together else targets[number][None]
        return jax.block_until_ready(solve(root, rest, wanted)[0])

    def miss(number: int, found: Any) -> float:
        ends = kinematics.forward(chain, np.asarray(root), np.asarray(found))[0][..., -1, :]
        wanted = targets if together else targets[number]
        return float(np.linalg.norm(ends - wanted, axis=-1).max())

    return Calls(count=1 if together else items, call=call, miss=miss)


def _skeleton(offsets: np.ndarray) -> Skeleton:
    count = len(offsets)
    names = tuple(f"joint {number}" for number in range(count))
    return Skeleton(names=names, parents=tuple(range(-1, count - 1)), offsets=offsets)


def _arm(bones: int) -> np.ndarray:
    """Offsets of joints of the right arm, one more than bones; the first is at the origin."""
    skeleton = synthetic_skeleton()
    limb = find_limb(skeleton, "right_hand").joints
    first = FIRST[bones]
    offsets = np.array(skeleton.offsets, np.float32)[list(limb[first : first + bones + 1])]
    offsets[0] = 0
    return offsets


def _bent_chain(seed: int, items: int, links: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    ways = np.array([0.0, 1.0, 0.0]) + 0.25 * rng.normal(size=(links, 3))
    ways /= links * np.linalg.norm(ways, axis=1, keepdims=True)
    joints = np.concatenate([np.zeros((1, 3)), np.cumsum(ways, axis=0)])
    targets = rng.normal(size=(items, 3))
    targets /= np.linalg.norm(targets, axis=1, keepdims=True)
    targets *= rng.uniform(0.3, 0.95, (items, 1))
    return joints.astype(np.float32), targets.astype(np.float32)
