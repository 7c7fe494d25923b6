"""Hybrid motion graphs: walks along a sketched path, and hands and head that reach on the way.

After Kalouache and Cherif, *Hybrid Motion Graphs for Character Animation*, and Kovar, Gleicher and
Pighin, *Motion Graphs* (2002).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mgjax._lazy import attach

if TYPE_CHECKING:
    from mgjax.core.body.joint_limits import JointLimits as JointLimits
    from mgjax.core.body.joint_limits import joint_limits as joint_limits
    from mgjax.hybrid.config import PathConfig as PathConfig
    from mgjax.hybrid.config import ReachConfig as ReachConfig
    from mgjax.hybrid.ik.chain import NOT_CONVERGED as NOT_CONVERGED
    from mgjax.hybrid.ik.chain import REACHED as REACHED
    from mgjax.hybrid.ik.chain import UNREACHABLE_FAR as UNREACHABLE_FAR
    from mgjax.hybrid.ik.chain import UNREACHABLE_NEAR as UNREACHABLE_NEAR
    from mgjax.hybrid.ik.chain import fabrik as fabrik
    from mgjax.hybrid.ik.limbs import LIMBS as LIMBS
    from mgjax.hybrid.ik.limbs import Limb as Limb
    from mgjax.hybrid.ik.limbs import find_limb as find_limb
    from mgjax.hybrid.ik.limbs import steady_joints as steady_joints
    from mgjax.hybrid.ik.pose import moved_joints as moved_joints
    from mgjax.hybrid.ik.pose import reach_pose as reach_pose
    from mgjax.hybrid.ik.rotations import chain_rotations as chain_rotations
    from mgjax.hybrid.ik.tree import fabrik_tree as fabrik_tree
    from mgjax.hybrid.paths.curve import Curve as Curve
    from mgjax.hybrid.paths.result import PathResult as PathResult
    from mgjax.hybrid.paths.result import Track as Track
    from mgjax.hybrid.paths.search import follow as follow
    from mgjax.hybrid.paths.sketch import Sketch as Sketch
    from mgjax.hybrid.paths.sketch import load_sketch as load_sketch
    from mgjax.hybrid.paths.sketch import make_sketch as make_sketch
    from mgjax.hybrid.prepared import Prepared as Prepared
    from mgjax.hybrid.prepared import prepare as prepare
    from mgjax.hybrid.reaching.result import Reached as Reached
    from mgjax.hybrid.reaching.result import ReachResult as ReachResult
    from mgjax.hybrid.reaching.targets import Bar as Bar
    from mgjax.hybrid.reaching.targets import Target as Target
    from mgjax.hybrid.reaching.targets import load_targets as load_targets
    from mgjax.hybrid.reaching.targets import make_target as make_target
    from mgjax.hybrid.reaching.walk import reach as reach
else:
    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "Bar": "mgjax.hybrid.reaching.targets",
            "chain_rotations": "mgjax.hybrid.ik.rotations",
            "Curve": "mgjax.hybrid.paths.curve",
            "fabrik": "mgjax.hybrid.ik.chain",
            "fabrik_tree": "mgjax.hybrid.ik.tree",
            "find_limb": "mgjax.hybrid.ik.limbs",
            "follow": "mgjax.hybrid.paths.search",
            "joint_limits": "mgjax.core.body.joint_limits",
            "JointLimits": "mgjax.core.body.joint_limits",
            "Limb": "mgjax.hybrid.ik.limbs",
            "LIMBS": "mgjax.hybrid.ik.limbs",
            "load_sketch": "mgjax.hybrid.paths.sketch",
            "load_targets": "mgjax.hybrid.reaching.targets",
            "make_sketch": "mgjax.hybrid.paths.sketch",
            "make_target": "mgjax.hybrid.reaching.targets",
            "moved_joints": "mgjax.hybrid.ik.pose",
            "NOT_CONVERGED": "mgjax.hybrid.ik.chain",
            "PathConfig": "mgjax.hybrid.config",
            "PathResult": "mgjax.hybrid.paths.result",
            "prepare": "mgjax.hybrid.prepared",
            "Prepared": "mgjax.hybrid.prepared",
            "reach": "mgjax.hybrid.reaching.walk",
            "reach_pose": "mgjax.hybrid.ik.pose",
            "ReachConfig": "mgjax.hybrid.config",
            "REACHED": "mgjax.hybrid.ik.chain",
            "Reached": "mgjax.hybrid.reaching.result",
            "ReachResult": "mgjax.hybrid.reaching.result",
            "Sketch": "mgjax.hybrid.paths.sketch",
            "steady_joints": "mgjax.hybrid.ik.limbs",
            "Target": "mgjax.hybrid.reaching.targets",
            "Track": "mgjax.hybrid.paths.result",
            "UNREACHABLE_FAR": "mgjax.hybrid.ik.chain",
            "UNREACHABLE_NEAR": "mgjax.hybrid.ik.chain",
        },
    )
