"""Commands on motion files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from mgjax.cli.arguments.shared import KnownReading, Output, Reading


@dataclass(frozen=True, kw_only=True)
class Info(Reading):
    """Describe motion files: skeleton, frames, rate, unit, axes, body, oddities."""

    files: tyro.conf.Positional[tuple[Path, ...]] = ()
    """Motion files, or folders of them."""
    roles: tuple[Path, ...] | None = None
    """Show what is what of the body, with --out as a picture; a TOML file says it better."""
    out: Path | None = None
    """Folder for info.json and the pictures."""
    html: bool = False
    """Also write to --out a page for each file that plays it offline in any browser."""


@dataclass(frozen=True, kw_only=True)
class Convert(KnownReading):
    """Write a motion in another format: BVH, GLB, VRMA, USD, NPZ, CSV, or .html, which plays it."""

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
class Quality(KnownReading):
    """Measure how good motion files are: feet, smoothness, limits, limbs in the body; see seams."""

    files: tyro.conf.Positional[tuple[Path, ...]]
    """Motion files, or folders of them; seams are those that a result.json beside a file names."""
    against: tuple[Path, ...] = ()
    """Files or folders of uncut capture, whose figures stand beside those of the files."""
    out: Path | None = None
    """Folder for quality.json and a picture of each file."""


@dataclass(frozen=True, kw_only=True)
class Fetch(Output):
    """Fetch motion capture from the network into the cache folder; what is there is not fetched."""

    database: tyro.conf.Positional[Literal["cmu"]]
    """cmu: the CMU Graphics Lab Motion Capture Database."""
    subjects: tyro.conf.Positional[tuple[int, ...]] = ()
    """Numbers of subjects, such as 14 49 127; without them all are listed."""
    server: str | None = None
    """Address of a copy of the database; default: its own."""
