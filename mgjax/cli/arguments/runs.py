"""Commands on recorded runs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from mgjax.cli.arguments.shared import Output


@dataclass(frozen=True, kw_only=True)
class Recorded(Output):
    """Which runs are looked through."""

    below: tyro.conf.UseAppendAction[tuple[Path, ...]] = ()
    """Folder with records or folders of results; may be given more than once. Default:
    experiments/records and out."""


@dataclass(frozen=True, kw_only=True)
class ListRuns(Recorded):
    """One line for each recorded run."""


@dataclass(frozen=True, kw_only=True)
class ShowRun(Recorded):
    """How a run was made, and what it found."""

    run: tyro.conf.Positional[str]
    """Path of a record or of a folder of results, or the name of the only run of an experiment."""


@dataclass(frozen=True, kw_only=True)
class CompareRuns(Recorded):
    """Which settings, inputs, programs, versions and figures of two runs differ."""

    a: tyro.conf.Positional[str]
    """One run."""
    b: tyro.conf.Positional[str]
    """The other."""


@dataclass(frozen=True, kw_only=True)
class SweepRuns(Output):
    """Run an experiment over a grid of settings, random ones, or both; one JSON line a run. The
    same command goes on where it was stopped."""

    experiment: tyro.conf.Positional[str]
    """Its module, such as experiments.avoidance.success."""
    out: Path
    """File of JSON lines."""
    grid: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """KEY=[VALUE, …]: all combinations with those of the others; may be given more than once."""
    draw: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """KEY=[LOW, HIGH]: uniform numbers between them; may be given more than once."""
    samples: int = 1
    """How often numbers are drawn, for each combination of the grid."""
    seed: int = 0
    """Draws them."""
    config: Path | None = None
    """TOML file of settings."""
    set: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """KEY=VALUE of all runs; may be given more than once."""
    smoke: bool = False
    """A tiny version of each."""
    executor: Literal["serial", "threads", "processes", "ray"] = "serial"
    """Where runs are made."""
    workers: int | None = None
    """How many; default: one a processor."""


@dataclass(frozen=True, kw_only=True)
class Runs:
    """List, show and compare recorded runs of experiments; run many over settings."""

    action: Annotated[
        Annotated[ListRuns, tyro.conf.subcommand("list")]
        | Annotated[ShowRun, tyro.conf.subcommand("show")]
        | Annotated[CompareRuns, tyro.conf.subcommand("compare")]
        | Annotated[SweepRuns, tyro.conf.subcommand("sweep")],
        tyro.conf.arg(name=""),
    ]
