"""What came of the targets of a walk, measured on the motion itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.core.body.capsules import arm_clearance
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion
from mgjax.core.shown import Shown
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.config import ReachConfig
from mgjax.hybrid.ik.limbs import find_limb
from mgjax.hybrid.paths.result import PathResult
from mgjax.hybrid.prepared import ReachBody
from mgjax.hybrid.reaching.blend import Hold
from mgjax.hybrid.reaching.duck import Duck, bar_clearance
from mgjax.hybrid.reaching.events import ReachEvent
from mgjax.hybrid.reaching.targets import Target


@dataclass(frozen=True, kw_only=True, eq=False)
class Reached:
    """What came of one target.

    Attributes:
        status: ``"reached"``; ``"out_of_reach"``: nowhere on the walk; ``"too_high"``: the target
            is more than 0.95 Σd above the base; ``"limits"``: near enough, but the joints do not
            allow it, or not over the whole hold; ``"lost"``: no way leads there; ``"too_fast"``: a
            joint turns too fast even with the longest blend; ``"missed"``: other targets or a bar,
            too near in time, draw the body away from it. A bar is ``"cleared"`` or ``"hit"``.
        error_m: distance of the end to the target at the beginning of the hold; of a bar NaN.
        hold_m: the largest one over the hold.
        first, last: frames of the hold, or of being down; None if there is none.
        extended_m: length of the way that was added to the walk, m; 0 for none.
        stopped: the walk stands still meanwhile.
        drop_m: how far the pelvis is down.
        clear_m: of a bar, what is left between it and the body; of a hand, between arm and body.
    """

    target: Target
    status: str
    error_m: float
    hold_m: float
    first: int | None
    last: int | None
    extended_m: float
    stopped: bool
    drop_m: float
    clear_m: float


@dataclass(frozen=True, kw_only=True, eq=False)
class ReachResult(Shown):
    """A walk with reaches.

    Attributes:
        walked: the walk as it is walked, with what extends it, before limbs reach.
        motion: with the reaches.
        plain: the motion with stops, but without reaches.
        shown: the frame of the walk that each frame of the motion shows, also between two. [N]
        targets: one result for each target.
        fastest_deg_s: fastest turn of a joint that the reaches turn, degrees/s.
        fastest_plain_deg_s: that of the walk without reaches.
        slide: metres that planted feet travel per frame, both together, with the reaches.
        solve_s: seconds spent on everything after the first walk.
    """

    walked: PathResult
    motion: Motion
    plain: Motion
    shown: Float[np.ndarray, " N"]
    targets: tuple[Reached, ...]
    fastest_deg_s: float
    fastest_plain_deg_s: float
    slide: float
    solve_s: float


def target_row(
    graph: MotionGraph,
    body: ReachBody,
    motion: Motion,
    target: Target,
    number: int,
    events: list[ReachEvent],
    holds: dict[int, Hold],
    config: ReachConfig,
) -> Reached:
    """What came of a target, measured on the motion."""
    event = next(event for event in events if number in event.numbers)
    hold = holds.get(id(event))
    if hold is None or event.key is None:
        return Reached(
            target=target, status=event.status, first=None, last=None, extended_m=0.0,
            error_m=event.key.error_m if event.key else np.nan,
            hold_m=np.nan, stopped=False, drop_m=0.0, clear_m=np.nan,
        )  # fmt: skip
    positions = np.asarray(global_positions(body.skeleton, motion), np.float64)
    rows = np.arange(hold.first, hold.last + 1)
    wanted = target.at((rows - hold.first) / graph.frame_rate)
    limb = find_limb(body.skeleton, target.limb)
    off = np.linalg.norm(positions[rows, limb.joints[-1]] - wanted, axis=-1)
    missed = event.status == "reached" and off.max() > config.hold_m
    clear_m = np.nan
    if limb.is_arm:
        clear_m = float(arm_clearance(body.capsules, positions[rows], limb.type.side).min())
    return Reached(
        target=target,
        status="missed" if missed else event.status,
        error_m=float(off[0]),
        hold_m=float(off.max()),
        first=hold.first,
        last=hold.last,
        extended_m=event.extended_m,
        stopped=event.key.place.stop,
        drop_m=event.key.drop_m,
        clear_m=clear_m,
    )


def bar_row(
    body: ReachBody, motion: Motion, target: Target, ducked: Duck, drop_m: float
) -> Reached:
    """What came of a bar, measured on the motion with all its reaches."""
    assert target.bar is not None
    left = float(bar_clearance(body, motion, target.bar).min())
    frames = ducked.frames or (None, None)
    return Reached(
        target=target, status="cleared" if left >= 0 else "hit", error_m=np.nan, hold_m=np.nan,
        first=frames[0], last=frames[1], extended_m=0.0, stopped=False,
        drop_m=ducked.depth * drop_m, clear_m=left,
    )  # fmt: skip
