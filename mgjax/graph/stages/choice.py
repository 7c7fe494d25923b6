"""Whether a build is done in stages, where they are computed, and where they are kept."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from mgjax.core.parallel.executors import Name, executor
from mgjax.core.xla.compilation import cache_folder
from mgjax.graph.stages.stages import Stages, stage_store
from mgjax.io.stages import StageStore

LARGE = 20_000
"""Frames from which a build takes a quarter of a minute and is kept anyway. In stages the search
takes a third longer, since distances are measured once more."""

KEPT_BYTES = 4 * 2**30
"""Most that is kept in the cache folder; files used longest ago go first."""


@contextmanager
def build_stages(
    *,
    frames: int,
    store: StageStore | None = None,
    name: Name | None = None,
    workers: int | None = None,
    address: str | None = None,
) -> Iterator[Stages | None]:
    """The stages of a build, or None for one in one piece: of small input, if nothing is asked for.

    Args:
        frames: of all clips, as captured.
        store: where stages are kept; None: in the cache folder if there is much to lose.
        name, workers, address: of :func:`mgjax.core.parallel.executors.executor`; by default
            threads, or so many processes as ``workers`` says.

    Raises:
        ConfigError: an executor that cannot be.
        OutputError: the cache folder cannot be written.
    """
    asked = name is not None or workers is not None or address is not None
    if not asked and store is None and frames < LARGE:
        yield None
        return
    own = stage_store(cache_folder() / "stages") if store is None and frames >= LARGE else None
    default: Name = "threads" if workers is None and address is None else "processes"
    with executor(name or default, workers, address) as made:
        yield Stages(executor=made, store=store or own)
    if own is not None:
        own.trim(KEPT_BYTES)
