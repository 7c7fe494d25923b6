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
    device: str | None = None,
) -> Iterator[Stages | None]:
    """The stages of a build, or None for one in one piece: of small input, if nothing is asked for.

    Args:
        frames: of all clips, as captured.
        store: where stages are kept; None: in the cache folder if there is much to lose.
        name, workers, address, device: of :func:`mgjax.core.parallel.executors.executor`; by
            default threads, devices where a ``device`` is named, or so many processes as
            ``workers`` says.

    Raises:
        ConfigError: an executor that cannot be.
        OutputError: the cache folder cannot be written.
    """
    asked = any(each is not None for each in (name, workers, address, device))
    if not asked and store is None and frames < LARGE:
        yield None
        return
    own = stage_store(cache_folder() / "stages") if store is None and frames >= LARGE else None
    with executor(name or _default(workers, address, device), workers, address, device) as made:
        yield Stages(executor=made, store=store or own)
    if own is not None:
        own.trim(KEPT_BYTES)


def _default(workers: int | None, address: str | None, device: str | None) -> Name:
    if device is not None:
        return "devices"
    if address is not None:
        return "ray"
    return "threads" if workers is None else "processes"
