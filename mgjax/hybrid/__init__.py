"""Hybrid motion graphs: walks along a sketched path, and hands and head that reach on the way.

After Kalouache and Cherif, *Hybrid Motion Graphs for Character Animation*, and Kovar, Gleicher and
Pighin, *Motion Graphs* (2002).
"""

from __future__ import annotations

import importlib
from typing import Any

_HOMES: dict[str, str] = {
    "PathConfig": "mgjax.hybrid.path_config",
    "PathResult": "mgjax.hybrid.path_result",
    "Sketch": "mgjax.hybrid.path_sketch",
    "follow": "mgjax.hybrid.path_search",
    "load_sketch": "mgjax.hybrid.path_sketch",
    "make_sketch": "mgjax.hybrid.path_sketch",
    "REACHED": "mgjax.hybrid.fabrik_chain",
    "UNREACHABLE_FAR": "mgjax.hybrid.fabrik_chain",
    "UNREACHABLE_NEAR": "mgjax.hybrid.fabrik_chain",
    "NOT_CONVERGED": "mgjax.hybrid.fabrik_chain",
    "fabrik": "mgjax.hybrid.fabrik_chain",
    "fabrik_tree": "mgjax.hybrid.fabrik_body",
    "JointLimits": "mgjax.hybrid.limits",
    "joint_limits": "mgjax.hybrid.limits",
    "limits_of_motion": "mgjax.hybrid.limits",
    "LIMBS": "mgjax.hybrid.limbs",
    "Limb": "mgjax.hybrid.limbs",
    "find_limb": "mgjax.hybrid.limbs",
    "steady_joints": "mgjax.hybrid.limbs",
    "chain_rotations": "mgjax.hybrid.rotations",
    "moved_joints": "mgjax.hybrid.limb_pose",
    "ReachConfig": "mgjax.hybrid.reach_config",
    "ReachResult": "mgjax.hybrid.reach_result",
    "Target": "mgjax.hybrid.reach_targets",
    "load_targets": "mgjax.hybrid.reach_targets",
    "make_target": "mgjax.hybrid.reach_targets",
    "reach": "mgjax.hybrid.reach_walk",
    "reach_pose": "mgjax.hybrid.limb_pose",
}
__all__ = list(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mgjax.hybrid' has no attribute {name!r}")
