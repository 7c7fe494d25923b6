"""The walk along a drawing, and what hands and head reach: only what an edit has changed."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

from mgjax.core.errors import ConfigError, MgjaxError
from mgjax.core.motion import Motion
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.config import PathConfig, ReachConfig
from mgjax.hybrid.paths.curve import Curve, make_curve
from mgjax.hybrid.paths.result import PathResult
from mgjax.hybrid.paths.search import follow
from mgjax.hybrid.paths.sketch import Sketch
from mgjax.hybrid.prepared import Prepared
from mgjax.hybrid.reaching.result import ReachResult
from mgjax.hybrid.reaching.walk import reach
from mgjax.stage.apps.sketch.drawing import Drawing, Key

Effort = Literal["drag", "quick", "full"]
QUICK = PathConfig(method="beam", time_limit_s=0.12)
"""While something is dragged, and until the better walk is there."""
LIMIT_S = 8.0
"""The exact search takes no longer; it hardly ever takes a second."""
_KEPT = 16


@dataclass(frozen=True, kw_only=True, eq=False)
class Solution:
    """What came of a drawing.

    Attributes:
        drawing: which.
        sketch: its path; None where there is none, or none that can be followed.
        walked: the walk; None without a path.
        reached: the same with reaches; None without targets, or where one cannot be.
        trouble: why there is no walk, or no reaching.
        better: whether a longer search may find another walk.
        extended: walks were extended to targets out of reach.
    """

    drawing: Drawing
    sketch: Sketch | None = None
    walked: PathResult | None = None
    reached: ReachResult | None = None
    trouble: str = ""
    better: bool = False
    extended: bool = True

    @cached_property
    def curve(self) -> Curve | None:
        """The path by arc length."""
        return None if self.sketch is None else make_curve(self.sketch)

    @property
    def motion(self) -> Motion | None:
        """What is played."""
        if self.reached is not None:
            return self.reached.motion
        return None if self.walked is None else self.walked.motion

    @property
    def route(self) -> PathResult | None:
        """The walk that is played, with what extends it."""
        return self.walked if self.reached is None else self.reached.walked


class Solver:
    """Solves drawings on one graph; walks found before are kept, for undo and for moved targets."""

    def __init__(self, graph: MotionGraph, prepared: Prepared) -> None:
        self.graph, self._prepared = graph, prepared
        self._walks: OrderedDict[Key, tuple[PathResult, bool]] = OrderedDict()

    def solve(self, drawing: Drawing, effort: Effort) -> Solution:
        """The walk and the reaches of a drawing.

        Args:
            drawing: what is drawn.
            effort: ``"drag"``: at once, a known walk if there is one, and nothing is extended;
                ``"quick"``: likewise, but walks are extended to targets; ``"full"``: by the
                drawing's own method.
        """
        if drawing.path is None:
            return Solution(drawing=drawing)
        try:
            sketch = drawing.sketch()
            walked, final = self._walk(drawing, sketch, effort)
        except MgjaxError as error:
            return Solution(drawing=drawing, trouble=str(error))
        targets = drawing.targets()
        reached, trouble = None, ""
        config = ReachConfig(extend=effort != "drag")
        if targets:
            try:
                reached = reach(
                    self.graph, sketch, targets, config=config,
                    path=_config(drawing), walked=walked, prepared=self._prepared,
                )  # fmt: skip
            except MgjaxError as error:
                trouble = str(error)
        return Solution(
            drawing=drawing,
            sketch=sketch,
            walked=walked,
            reached=reached,
            trouble=trouble,
            better=not final or not config.extend,
            extended=config.extend,
        )

    def _walk(self, drawing: Drawing, sketch: Sketch, effort: Effort) -> tuple[PathResult, bool]:
        """The walk, and whether it is the one that the full search finds."""
        key = drawing.walk_key()
        known = self._walks.get(key)
        if known is not None and (known[1] or effort != "full"):
            self._walks.move_to_end(key)
            return known
        config = _config(drawing) if effort == "full" else QUICK
        walked = follow(self.graph, sketch, config=config, prepared=self._prepared)
        if walked.status == "time_limit" and known is not None and known[0].status == "followed":
            walked = known[0]
        self._walks[key] = found = walked, effort == "full"
        while len(self._walks) > _KEPT:
            self._walks.popitem(last=False)
        return found


def _config(drawing: Drawing) -> PathConfig:
    """As ``mgjax walk`` searches by default, so that saved files give the same walk there."""
    limit = LIMIT_S if drawing.method == "exact" else 0.0
    return replace(PathConfig(method=drawing.method), time_limit_s=limit)


def require_motion(solution: Solution) -> Motion:
    """What is played; :class:`ConfigError` where nothing is."""
    if solution.motion is None:
        raise ConfigError(got="no walk yet", expected="a path to walk along")
    return solution.motion
