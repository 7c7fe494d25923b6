"""An experiment for the tests of the runner."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.figure import Figure

from mgjax.runs.experiment import Results
from mgjax.runs.points import Points


@dataclass(frozen=True, kw_only=True)
class Inner:
    width: float = 1.5
    form: Literal["round", "square"] = "round"


@dataclass(frozen=True, kw_only=True)
class Config:
    """Settings of a toy."""

    balls: int = 4
    """How many."""
    seed: int = 0
    speeds: tuple[float, ...] = (1.0, 2.0)
    """Speeds,
    m/s."""
    name: str = "plain"
    limit: float = math.inf
    quick: bool = False
    pair: tuple[int, str] = (1, "a")
    words: tuple[str, ...] = ()
    maybe: float | None = None
    joints: dict[str, float] = field(default_factory=dict)
    either: str | dict[str, float] = "uniform"
    inner: Inner = field(default_factory=Inner)

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"balls": 1, "inner.width": 0.5}


@dataclass(frozen=True, kw_only=True)
class Reading:
    clips: str = ""
    seed: int = 0


def toy(config: Config, points: Points) -> Results:
    """A sweep whose points are random numbers of the seed."""
    values = {
        f"{speed:g}": points.measure(
            f"speed/{speed:g}",
            lambda s=speed: {
                "mean": float(
                    np.random.default_rng(config.seed).normal(s, size=config.balls).mean()
                )
            },
        )
        for speed in config.speeds
    }
    figure = Figure()
    figure.subplots().plot([0, 1])
    return Results(
        metrics={"means": values, "count": np.int64(config.balls), "open": np.nan},
        arrays={"speeds": np.array(config.speeds)},
        figures={"now": figure, "later": lambda: Figure()},
        timings={"quick_s": 0.1},
        lines=("a line",),
    )


def simple(config: Config) -> Results:
    return Results(metrics={"balls": config.balls})


def names(folder: Path) -> list[str]:
    return sorted(item.name for item in folder.iterdir())
