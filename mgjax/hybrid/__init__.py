"""Hybrid motion graphs: walks along a sketched path, and hands and head that reach on the way.

After Kalouache and Cherif, *Hybrid Motion Graphs for Character Animation*, and Kovar, Gleicher and
Pighin, *Motion Graphs* (2002).
"""

from __future__ import annotations

import importlib
from typing import Any

_HOMES: dict[str, str] = {
    "PathConfig": "mgjax.hybrid.config",
    "PathResult": "mgjax.hybrid.paths.result",
    "Sketch": "mgjax.hybrid.paths.sketch",
    "follow": "mgjax.hybrid.paths.search",
    "Prepared": "mgjax.hybrid.prepared",
    "prepare": "mgjax.hybrid.prepared",
    "load_sketch": "mgjax.hybrid.paths.sketch",
    "make_sketch": "mgjax.hybrid.paths.sketch",
    "REACHED": "mgjax.hybrid.ik.chain",
    "UNREACHABLE_FAR": "mgjax.hybrid.ik.chain",
    "UNREACHABLE_NEAR": "mgjax.hybrid.ik.chain",
    "NOT_CONVERGED": "mgjax.hybrid.ik.chain",
    "fabrik": "mgjax.hybrid.ik.chain",
    "fabrik_tree": "mgjax.hybrid.ik.tree",
    "JointLimits": "mgjax.hybrid.ik.joint_limits",
    "joint_limits": "mgjax.hybrid.ik.joint_limits",
    "LIMBS": "mgjax.hybrid.ik.limbs",
    "Limb": "mgjax.hybrid.ik.limbs",
    "find_limb": "mgjax.hybrid.ik.limbs",
    "steady_joints": "mgjax.hybrid.ik.limbs",
    "chain_rotations": "mgjax.hybrid.ik.rotations",
    "moved_joints": "mgjax.hybrid.ik.pose",
    "ReachConfig": "mgjax.hybrid.config",
    "ReachResult": "mgjax.hybrid.reaching.result",
    "Target": "mgjax.hybrid.reaching.targets",
    "load_targets": "mgjax.hybrid.reaching.targets",
    "make_target": "mgjax.hybrid.reaching.targets",
    "reach": "mgjax.hybrid.reaching.walk",
    "reach_pose": "mgjax.hybrid.ik.pose",
}
__all__ = list(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mgjax.hybrid' has no attribute {name!r}")
