"""Where stages are computed, and where they are kept."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jax
import numpy as np

from mgjax.core.parallel.executors import SerialExecutor
from mgjax.graph.distances.pruned import TILE
from mgjax.io.stages import StageStore

FORMAT = 1
"""Raised when a stage computes something else of the same input."""


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
    """The folder of stage files of a graph's build: for this version of the programs.

    Raises:
        OutputError: nothing can be written there.
    """
    return StageStore(folder, f"{FORMAT}, jax {jax.__version__}, {jax.default_backend()}")
