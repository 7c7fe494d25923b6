"""Commands that make or measure a graph."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from mgjax.avoidance import config as avoidance
from mgjax.cli.arguments.shared import KnownReading, Output


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
    html: bool = False
    """Also write index.html, a page that plays a random walk over the graph."""
    work: Path | None = None
    """Folder that keeps finished stages: a build that ended goes on, and one with more clips does
    only what is new. Default: the cache folder, of large input only."""
    executor: Literal["serial", "threads", "devices", "processes", "ray"] | None = None
    """Where stages are computed: here, in threads, on jax devices, in processes, on Ray."""
    workers: int | None = None
    """How many threads, devices, processes or Ray workers; default: as many as there are."""
    device: str | None = None
    """Kind of jax devices that stages are computed on, such as gpu, spread over all of them."""
    address: str | None = None
    """Of a running Ray cluster, for --executor ray; default: one of this machine for the build."""


@dataclass(frozen=True, kw_only=True)
class Coverage(Output):
    """Show which attacks a graph avoids, where it fails, and what to add to it."""

    graph: Path
    """Folder of a graph with labelled avoidance parts."""
    out: Path
    """Folder for coverage.json, coverage.npz and coverage.png."""
    html: bool = False
    """Also write index.html, a page that shows it in space, offline."""
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

    what: tyro.conf.Positional[Literal["all", "compare", "distance", "build", "selection"]]
    """What to measure; compare reads what two runs of all have written."""
    files: tyro.conf.Positional[tuple[Path, ...]] = ()
    """For compare: two files bench.json, or the folders they are in."""
    graph: Path | None = None
    """Folder of a graph, for selection, and for the searches of all."""
    balls: int = 200
    """How many are thrown, for selection."""
    only: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """For all: cases whose name or quantity has this word; may be given more than once."""
    repeats: int = 9
    """For all: timed calls of each size, in turns with the bare kernel."""
    sizes: int | None = None
    """For all: how many sizes of each case, the smallest first; default: all."""
    out: Path | None = None
    """Folder for bench.json."""
