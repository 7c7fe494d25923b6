"""What stands on the floor of a session: a path, obstacles, and what hands and head reach for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from mgjax.core.errors import ConfigError
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.sketch import Sketch, make_sketch
from mgjax.hybrid.reaching.targets import Target

Method = Literal["exact", "beam"]
METHODS = ("exact", "beam")
LONGEST_M = 60.0
"""Longest path on the page; ``mgjax walk`` takes longer ones."""
MOST_TARGETS = 16
Key = tuple[object, ...]


@dataclass(frozen=True, kw_only=True)
class Obstacle:
    """A circle on the floor that the root may not enter: x, z and radius, m."""

    id: str
    x: float
    z: float
    radius: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Goal:
    """A target of a hand or of the head, or a bar."""

    id: str
    target: Target

    @property
    def kind(self) -> str:
        """``bar``, or the limb."""
        return "bar" if self.target.bar is not None else self.target.limb


@dataclass(frozen=True, kw_only=True, eq=False)
class Path:
    """A path and what was drawn for it.

    Attributes:
        points: x and z, m. [M, 2]
        stroke: of the pen, from which the points were made; None where they were given.
        spline: a smooth curve through the points.
        closed: it leads back to its first point.
        speed: wanted at the points, m/s, NaN for any. [M]
        end: place and heading at the end, as a sketch has them, or None.
    """

    points: Float[np.ndarray, "M 2"]
    stroke: Float[np.ndarray, "N 2"] | None = None
    spline: bool = False
    closed: bool = False
    speed: Float[np.ndarray, " M"] | None = None
    end: tuple[float, float, float] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawing:
    """All that a person has drawn and placed. Never changed: edits make another one.

    Attributes:
        path: None before anything is drawn.
        obstacles, goals: in the order in which they were placed.
        smooth: paths drawn from now on are smooth.
        method: of the path search.
        count: things placed so far, from which ids are made.
    """

    path: Path | None = None
    obstacles: tuple[Obstacle, ...] = ()
    goals: tuple[Goal, ...] = ()
    smooth: bool = True
    method: Method = "exact"
    count: int = 0

    def sketch(self) -> Sketch:
        """The path with the obstacles, as a path search takes it.

        Raises:
            PathError: of :func:`mgjax.hybrid.make_sketch`.
            ConfigError: no path, or one that is too long for the page.
        """
        if self.path is None:
            raise ConfigError(got="no path", expected="one drawn on the floor")
        sketch = make_sketch(
            self.path.points,
            speed=self.path.speed,
            spline=self.path.spline,
            closed=self.path.closed,
            end=self.path.end,
            obstacles=[(o.x, o.z, o.radius) for o in self.obstacles],
        )
        length = make_curve(sketch).length
        if length > LONGEST_M:
            raise ConfigError(
                got=f"a path of {length:.0f} m",
                expected=f"at most {LONGEST_M:g} m here (mgjax walk takes longer ones)",
            )
        return sketch

    def targets(self) -> tuple[Target, ...]:
        """What is to be reached."""
        return tuple(goal.target for goal in self.goals)

    def walk_key(self) -> Key:
        """Same for drawings whose walks are the same before anything is reached."""
        path = self.path
        if path is None:
            return ()
        speed = b"" if path.speed is None else path.speed.tobytes()
        circles = tuple((o.x, o.z, o.radius) for o in self.obstacles)
        shape = (path.points.tobytes(), path.spline, path.closed, speed, path.end)
        return (*shape, circles, self.method)

    def names(self) -> dict[str, str]:
        """What each thing is called, by id; numbered where there are several of a kind."""
        things = [(o.id, "obstacle") for o in self.obstacles]
        things += [(g.id, g.kind.replace("_", " ")) for g in self.goals]
        kinds = [kind for _, kind in things]
        named: dict[str, str] = {}
        for i, (id_, kind) in enumerate(things):
            number = kinds[: i + 1].count(kind)
            named[id_] = kind if kinds.count(kind) == 1 else f"{kind} {number}"
        return named
