"""A toy experiment whose runs are made together where they differ in width only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from mgjax.runs.experiment import Results
from tests.runs.swept import Inner

TRACED = ("inner.width",)
CALLS: list[int] = []


@dataclass(frozen=True, kw_only=True)
class Config:
    balls: int = 1
    names: tuple[str, ...] = ()
    inner: Inner = field(default_factory=Inner)


def run(config: Config) -> Results:
    return run_together([config])[0]


def run_together(configs: Sequence[Config]) -> list[Results]:
    assert len({(config.balls, config.names) for config in configs}) == 1
    CALLS.append(len(configs))
    return [Results(metrics={"area": config.balls * config.inner.width}) for config in configs]
