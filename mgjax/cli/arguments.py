"""The commands and their arguments, with defaults of the configurations: no jax, no numpy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from mgjax.avoidance import config as avoidance
from mgjax.sensor.config import HOST, PORT, ReplayConfig

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Output:
    """How results are printed."""

    json: bool = False
    """Print one JSON object on stdout."""


@dataclass(frozen=True, kw_only=True)
class Reading(Output):
    """What is known of the clips; otherwise it is found in their motion, or in a clips.toml."""

    units: str | None = None
    """Unit of their numbers: m, cm, mm, dm, in, ft or cmu."""
    up: str | None = None
    """Axis that points up: x, -x, y, -y, z or -z."""
    front: str | None = None
    """Axis along which the body looks in the first frame; it is turned to z."""
    fps: float | None = None
    """Frames per second at which they were captured."""
    floor: str | None = None
    """Height of their floor, m, or keep."""
    asf: Path | None = None
    """Skeleton of AMC files."""


@dataclass(frozen=True, kw_only=True)
class KnownReading(Reading):
    """What is known of the clips and of the body in them."""

    roles: Path | None = None
    """TOML file of roles and joint names, where those found are wrong."""


@dataclass(frozen=True, kw_only=True)
class Info(Reading):
    """Describe motion files: skeleton, frames, rate, unit, axes, body, oddities."""

    files: tyro.conf.Positional[tuple[Path, ...]] = ()
    """Motion files, or folders of them."""
    roles: tuple[Path, ...] | None = None
    """Show what is what of the body, with --out as a picture; a TOML file says it better."""
    out: Path | None = None
    """Folder for info.json and the pictures."""


@dataclass(frozen=True, kw_only=True)
class Convert(KnownReading):
    """Write a motion in another format: .bvh, .glb, .vrma, .usd, .usda, .usdc, .npz or .csv."""

    file: tyro.conf.Positional[Path]
    """BVH, GLB or NPZ file (also of AMASS), or AMC file with its ASF beside it; or a folder."""
    out: Path
    """File to write; its suffix says in which format. Of a folder: the folder to write to."""
    to: str | None = None
    """Suffix of the files to write, where a folder is read with all folders below it."""
    frame_rate: float | None = None
    """Frames per second to write, with poses in between interpolated; default: as captured."""
    body_model: Path | None = None
    """NPZ file of the SMPL body whose motion an AMASS file has; default: rough proportions."""


@dataclass(frozen=True, kw_only=True)
class Build(KnownReading):
    """Build a motion graph from a folder of clips."""

    clips: Path
    """Folder of clips; folders below it count too."""
    out: Path
    """Folder for the graph."""
    exclude: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """Glob on the path below the clips' folder; may be given more than once."""
    labels: Path | None = None
    """JSON file of labelled intervals."""
    no_body: bool = False
    """Take what is no body on two legs, too: such a graph is for no room that needs one."""
    skip_bad: bool = False
    """Leave out files that cannot be read, not stop at them."""
    skeleton: Path | None = None
    """File whose skeleton the graph gets; default: that of the first clip."""
    mirror: bool = False
    """Add a left-right mirrored copy of every clip."""
    retarget: bool = False
    """Put clips of other skeletons (names, proportions, rest pose) on the graph's."""
    config: Path | None = None
    """TOML file of graph settings."""
    no_index: bool = False
    """Leave out the grid index, from which candidates of an avoidance are looked up."""


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
    config: Path | None = None
    """TOML file of settings of the search."""


@dataclass(frozen=True, kw_only=True)
class Scene(Output):
    """Make a scene of players who pass a ball to one another."""

    config: Path
    """TOML file of the scene: players, passes, court."""
    out: Path
    """Folder for one BVH file per player, ball.csv, timeline.json and scene.png."""
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
    """Folder for motion.bvh, result.json and scene.png."""
    balls: int = 5
    """How many."""
    seed: int = 0
    """Draws clips, places and throws."""


@dataclass(frozen=True, kw_only=True)
class Coverage(Output):
    """Show which attacks a graph avoids, where it fails, and what to add to it."""

    graph: Path
    """Folder of a graph with labelled avoidance parts."""
    out: Path
    """Folder for coverage.json, coverage.npz and coverage.png."""
    directions: int = avoidance.DIRECTIONS
    """How many directions balls come from, all around."""
    nodes: int = avoidance.NODES
    """At how many places in the graph; at each, one ball comes from every direction."""
    heights: tuple[float, ...] | None = None
    """Where balls pass the body's axis, m; dealt out among them. By default from shins to head."""
    arrivals: tuple[float, ...] = avoidance.ARRIVALS_S
    """Seconds from now until a ball is there; dealt out among them."""
    speed: float = avoidance.BALL_SPEED_M_S
    """Speed of the balls, m/s."""
    seed: int = 0
    """Draws the nodes and deals heights and times."""
    config: Path | None = None
    """TOML file of avoidance settings."""


@dataclass(frozen=True, kw_only=True)
class Bench(Output):
    """Measure speed; rows have medians, quartiles and ratios to a bare kernel of the same run."""

    what: tyro.conf.Positional[Literal["distance", "build", "selection"]]
    """What to measure."""
    graph: Path | None = None
    """Folder of a graph, for selection."""
    balls: int = 200
    """How many are thrown, for selection."""
    out: Path | None = None
    """Folder for bench.json."""


@dataclass(frozen=True, kw_only=True)
class Replay(KnownReading):
    """Send a motion file as a motion sensor would, in real time (VMC protocol, OSC over UDP)."""

    file: tyro.conf.Positional[Path]
    """BVH, GLB or NPZ file, or AMC file with its ASF beside it."""
    out: Path | None = None
    """Folder for replay.json."""
    host: str = HOST
    """Where to send it."""
    port: int = PORT
    """Its port."""
    rate: float | None = ReplayConfig.rate
    """Frames sent per second of motion; default: as captured."""
    speed: float = ReplayConfig.speed
    """Seconds of motion per second."""
    loss: float = ReplayConfig.loss
    """Share of packets that are lost."""
    reorder: float = ReplayConfig.reorder
    """Share of packets that come after those of the next frame."""
    jitter: float = ReplayConfig.jitter_s
    """Each packet is late by a random time up to this, s."""
    seed: int = ReplayConfig.seed
    """Draws what is lost, reordered and late."""


@dataclass(frozen=True, kw_only=True)
class Send(Output):
    """Send a motion to whatever shows VMC: a random walk of a graph, or a clip, in real time."""

    file: tyro.conf.Positional[Path | None] = None
    """BVH file, or AMC file with its ASF beside it, if not a graph."""
    graph: Path | None = None
    """Folder of a graph, of which a random walk is played."""
    host: str = HOST
    """Where to send it."""
    port: int = PORT
    """Its port."""
    seconds: float | None = None
    """For how long; default: the whole clip, or 30 s of a walk."""
    fps: float | None = None
    """Frames sent per second; default: as captured."""
    seed: int = 0
    """Draws the walk."""
    out: Path | None = None
    """Folder for send.json."""


@dataclass(frozen=True, kw_only=True)
class Listen(Output):
    """Wait for a motion sensor; print each kick and the stored hit it resembles, as JSON lines."""

    seconds: float
    """How long to listen."""
    out: Path | None = None
    """Folder for kicks.json."""
    host: str = HOST
    """Address of this machine to listen on; anything but loopback hears the whole network."""
    port: int = PORT
    """Its port; 0 takes a free one."""
    config: Path | None = None
    """TOML file of settings: how kicks are found and compared."""


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """Live motion over the VMC protocol: send it, play a file as a sensor, or listen to one."""

    action: Annotated[
        Annotated[Replay, tyro.conf.subcommand("replay")]
        | Annotated[Send, tyro.conf.subcommand("send")]
        | Annotated[Listen, tyro.conf.subcommand("listen")],
        tyro.conf.arg(name=""),
    ]
