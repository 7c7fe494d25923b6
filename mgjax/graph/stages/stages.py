"""Where stages are computed, and where they are kept."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import jax
import numpy as np

from mgjax.core.parallel.executors import SerialExecutor
from mgjax.graph.distances.pruned import TILE
from mgjax.io.content_key import content_key
from mgjax.io.stages import StageStore

PROGRAMS = ("core", "io", "clips", "graph", "avoidance")
"""Folders of this package whose programs make stage files."""


@dataclass(frozen=True, kw_only=True)
class Stages:
    """An executor and a folder of stage files.

    Attributes:
        executor: computes blocks.
        store: keeps them; None: nothing outlives the build.
        entries: frames of clips that are compared together, with the gaps between them.
    """

    executor: Executor = field(default_factory=SerialExecutor)
    store: StageStore | None = None
    entries: int = TILE

    def load(self, stage: str, key: str) -> tuple[dict[str, np.ndarray], dict[str, Any]] | None:
        """See :meth:`mgjax.io.stages.StageStore.load`."""
        return None if self.store is None else self.store.load(stage, key)

    def save(
        self,
        stage: str,
        key: str,
        arrays: dict[str, np.ndarray],
        plain: dict[str, Any] | None = None,
    ) -> None:
        """See :meth:`mgjax.io.stages.StageStore.save`."""
        if self.store is not None:
            self.store.save(stage, key, arrays, plain)

    def notes(self) -> Iterable[str]:
        """What there is to say of the files."""
        return [] if self.store is None else self.store.notes()


def stage_store(folder: str | Path) -> StageStore:
    """The folder of stage files of a graph's build.

    They are of this version: of the text of the programs, of jax and of its backend. So no file
    outlives a change of what would be computed.

    Raises:
        OutputError: nothing can be written there.
    """
    return StageStore(folder, made_by())


def made_by() -> str:
    """The text of the programs, jax, and its backend: what the files of two runs may differ by."""
    return f"{_programs()}, jax {jax.__version__}, {jax.default_backend()}"


@cache
def _programs() -> str:
    package = Path(__file__).parents[2]
    files = sorted(file for name in PROGRAMS for file in (package / name).rglob("*.py"))
    return content_key([(f.relative_to(package).as_posix(), f.read_bytes()) for f in files])
