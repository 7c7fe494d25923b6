"""The answer to an attack: the chosen walk, its motion, and the proof that it is clear."""

from __future__ import annotations

from dataclasses import dataclass, fields

from mgjax.avoidance.answer import Choice
from mgjax.avoidance.attack import Attack
from mgjax.avoidance.check import CLEAR_M, Trace, clearance, trace_motion, walk_motion
from mgjax.avoidance.choice import choose
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.grid_index import GridIndex
from mgjax.avoidance.volumes import preset_spheres
from mgjax.core.motion import Motion
from mgjax.graph.types import MotionGraph


@dataclass(frozen=True, kw_only=True, eq=False)
class Selection(Choice):
    """The answer to an attack: a choice, and its motion.

    ``status`` and ``clearance_m`` are those of the motion as it is written.

    Attributes:
        motion: from now until the attack is over, in the planar frame of its first pose.
        trace: the body's spheres over that motion.
    """

    motion: Motion
    trace: Trace


def select(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    *,
    config: AvoidanceConfig | None = None,
    seed: int = 0,
    index: GridIndex | None = None,
) -> Selection:
    """Chooses and time-scales the walk that avoids an attack with the least movement.

    The character stands at ``node`` now, and the path begins now. Candidates are all walks to an
    avoidance part whose middle is within T_window/2 of the middle of the cropped attack (eq. 1);
    each is scaled in time to meet it (eq. 3) and judged by its energies (eq. 10). In the order of
    their energy they are checked exactly, by forward kinematics, against the whole attack, and the
    first that stays clear wins. What follows its end is chosen so that it stays clear until
    ``settle_s`` after the attack.

    Args:
        graph: a motion graph with labelled avoidance parts.
        node: where the character stands.
        attack: in the planar frame of the body at the node.
        config: settings.
        seed: for the walk that is taken where there is no candidate.
        index: the graph's grid index, from which candidates are looked up (§5.1); without it, or
            where it holds none that is clear, they are enumerated.

    Raises:
        AttackError: the attack is not finite, or begins inside the body.
        ConfigError: no such node, or a setting out of range.
    """
    config = config or AvoidanceConfig()
    return write(
        graph, attack, choose(graph, node, attack, config=config, seed=seed, index=index), config
    )


def write(graph: MotionGraph, attack: Attack, choice: Choice, config: AvoidanceConfig) -> Selection:
    """Makes the motion of a choice, and checks that very motion once more.

    Its clearance, and so the status, come from the forward kinematics of what is written.
    """
    spheres = preset_spheres(graph.skeleton)
    motion = walk_motion(graph, choice.walk, attack.end + config.settle_s)
    trace = trace_motion(graph, spheres, motion)
    exact = None if choice.part is None else clearance(attack, trace, spheres.radii)[1]
    status = choice.status
    if exact is not None:
        status = "avoided" if choice.status == "avoided" and exact >= CLEAR_M else "hit"
    chosen = {field.name: getattr(choice, field.name) for field in fields(choice)}
    chosen |= {"status": status, "clearance_m": exact}
    return Selection(**chosen, motion=motion, trace=trace)
