"""A toy experiment that is swept, and that kills its process once where it is asked to."""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass, field
from pathlib import Path

from mgjax.runs.experiment import Results


@dataclass(frozen=True, kw_only=True)
class Inner:
    width: float = 1.5


@dataclass(frozen=True, kw_only=True)
class Config:
    balls: int = 1
    kills: str = ""
    inner: Inner = field(default_factory=Inner)


def run(config: Config) -> Results:
    if config.kills:
        noted = Path(config.kills)
        before = noted.read_text() if noted.exists() else ""
        noted.write_text(f"{before}{config.balls}\n")
        if config.balls == 3 and "3" not in before:
            os.kill(os.getpid(), signal.SIGKILL)
    return Results(metrics={"area": config.balls * config.inner.width, "many": [1, 2]})
