"""Commands on recorded runs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

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
class Runs:
    """List, show and compare recorded runs of experiments."""

    action: Annotated[
        Annotated[ListRuns, tyro.conf.subcommand("list")]
        | Annotated[ShowRun, tyro.conf.subcommand("show")]
        | Annotated[CompareRuns, tyro.conf.subcommand("compare")],
        tyro.conf.arg(name=""),
    ]
