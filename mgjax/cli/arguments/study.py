"""Commands of the observer study."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from mgjax.cli.arguments.shared import Output


@dataclass(frozen=True, kw_only=True)
class Export(Output):
    """Write trials for observers, each an attack and its ways out, and the key to them."""

    graph: Path
    """Folder of a graph with labelled avoidance parts."""
    out: Path
    """Folder for key.json and for_observers, which has index.html and trials."""
    trials: int = 40
    """How many; the paper's observer saw 40."""
    candidates: int = 4
    """Ways out of a trial, at most; one of them is what the search takes."""
    seed: int = 0
    """Draws attacks, candidates and their order."""
    config: Path | None = None
    """TOML file of avoidance settings."""


@dataclass(frozen=True, kw_only=True)
class Score(Output):
    """Say how far observers agree with the search, and fit its energies to what they picked."""

    files: tyro.conf.Positional[tuple[Path, ...]]
    """key.json and files of picks; picks that the live page saved need no key."""
    out: Path | None = None
    """Folder for score.json and, where there is something to fit, energy.toml."""


@dataclass(frozen=True, kw_only=True)
class Study:
    """Compare what the search chooses with what people pick."""

    action: Annotated[
        Annotated[Export, tyro.conf.subcommand("export")]
        | Annotated[Score, tyro.conf.subcommand("score")],
        tyro.conf.arg(name=""),
    ]
