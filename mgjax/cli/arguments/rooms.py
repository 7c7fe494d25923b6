"""Commands of the rooms: avoid, walk, scene, and the demo."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from mgjax.avoidance import config as avoidance
from mgjax.cli.arguments.shared import Output, Vector
from mgjax.sensor.config import HOST, PORT


@dataclass(frozen=True, kw_only=True)
class Avoid(Output):
    """Throw a ball at a character and write the motion that avoids it."""

    graph: Path
    """Folder of a graph."""
    start: Annotated[Vector | None, tyro.conf.arg(name="from", metavar="X Y Z")] = None
    """Where the ball is thrown from, m, in the character's frame (x left, y up, z ahead)."""
    at: Annotated[Vector | None, tyro.conf.arg(metavar="X Y Z")] = None
    """Where it is thrown at, m."""
    speed: float | None = None
    """Speed at launch, m/s."""
    arrives: float | None = None
    """Seconds from now until the ball is there."""
    attack: Path | None = None
    """JSON file of balls or moving spheres, in place of one ball."""
    out: Path
    """Folder for motion.bvh, result.json, scene.png and volumes.npz."""
    gravity: bool = False
    """The ball falls; otherwise it flies straight."""
    radius: float = avoidance.BALL_RADIUS_M
    """Radius of the ball, m."""
    html: bool = False
    """Also write index.html, a page that plays it offline in any browser."""
    node: int | None = None
    """Where the character stands in the graph; default: drawn by the seed."""
    seed: int = 0
    """Draws the node, and what is played where nothing avoids."""
    config: Path | None = None
    """TOML file of avoidance settings."""


@dataclass(frozen=True, kw_only=True)
class Walk(Output):
    """Walk along a path sketched on the floor."""

    graph: Path
    """Folder of a graph with locomotion."""
    path: Path
    """CSV (x,z or x,z,speed) or JSON file of the path, m."""
    out: Path
    """Folder for motion.bvh, result.json and walk.png."""
    reach: Path | None = None
    """JSON file of targets that hands and head reach on the way."""
    spline: bool = False
    """A smooth curve through the points, not straight lines between them."""
    closed: bool = False
    """The path leads back to its first point."""
    method: Literal["exact", "beam"] | None = None
    """Branch and bound, or only the best partial walks; default: exact."""
    seconds: float | None = None
    """Time limit of the search, s; then the best walk so far is taken."""
    html: bool = False
    """Also write index.html, a page that plays it offline in any browser."""
    config: Path | None = None
    """TOML file of settings of the search."""


@dataclass(frozen=True, kw_only=True)
class Scene(Output):
    """Make a scene of players who pass a ball to one another."""

    config: Path
    """TOML file of the scene: players, passes, court."""
    out: Path
    """Folder for one BVH file per player, ball.csv, timeline.json and scene.png."""
    html: bool = False
    """Also write index.html, a page that plays it offline in any browser."""
    live: float | None = None
    """Seconds to listen to a motion sensor: each kick decides the next pass of kind any."""
    host: str = HOST
    """Address of this machine to listen on."""
    port: int = PORT
    """Its port; 0 takes a free one."""


@dataclass(frozen=True, kw_only=True)
class Demo(Output):
    """Throw balls at a character made of the embedded clips."""

    out: Path = Path("out/demo")
    """Folder for index.html, motion.bvh, result.json and scene.png."""
    balls: int = 5
    """How many."""
    seed: int = 0
    """Draws clips, places and throws."""
    no_browser: bool = False
    """Do not open index.html, where there is a display."""
