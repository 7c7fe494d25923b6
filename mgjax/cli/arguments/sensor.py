"""Commands on live motion."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from mgjax.cli.arguments.shared import KnownReading, Output
from mgjax.sensor.config import HOST, PORT, ReplayConfig


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
