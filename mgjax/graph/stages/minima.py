"""The search for minima block by block, each block kept as soon as it is done."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from mgjax.core.parallel.run import run_all
from mgjax.graph.distances.axis import make_axis
from mgjax.graph.distances.components import principal
from mgjax.graph.distances.minima import Minima, Shortlist
from mgjax.graph.stages.block import PART, BlockTask, search_block, tile_counts, tile_pairs
from mgjax.graph.stages.groups import Group
from mgjax.graph.stages.stages import Stages
from mgjax.graph.timeline import ClipTimeline
from mgjax.io.content_key import content_key

STAGE = "minima"


@dataclass(frozen=True)
class _Block:
    key: str
    groups: tuple[Group, ...]
    part: int


def staged_minima(
    timeline: ClipTimeline,
    groups: list[Group],
    weights: np.ndarray,
    stages: Stages,
    *,
    window: int,
    neighbourhood: int,
    threshold: float,
    grain: float,
    leave: np.ndarray | None,
    arrive: np.ndarray | None,
    shortlist: Shortlist | None = None,
    progress: bool = False,
    watch: Callable[[float], None] | None = None,
) -> Minima:
    """What :func:`mgjax.graph.distances.minima.find_minima` finds below a finite threshold.

    Args:
        timeline, groups: all clips; see :func:`corpus_groups`.
        weights: of the joints, with the sum 1. [J]
        stages: where blocks are computed and kept.
        window, neighbourhood, threshold, grain, leave, arrive, shortlist: as there.
        progress: shows a bar on stderr, with the time left.
        watch: told the share of the work that is done.

    Raises:
        WorkerError: a worker ended; what was done before is kept.
        OutputError: a block cannot be kept.
    """
    everywhere = np.ones(len(timeline.root), bool)
    masks = [everywhere if some is None else some for some in (leave, arrive)]
    limit = float(threshold) ** 2
    settings = content_key(
        timeline.skeleton.parents,
        timeline.skeleton.offsets,
        weights,
        window,
        neighbourhood,
        limit,
    )
    blocks = list(_blocks(groups, settings, neighbourhood))

    axis = make_axis(
        timeline.positions,
        timeline.starts,
        timeline.stops,
        weights,
        window=window,
        margin=neighbourhood,
        leave=leave,
        arrive=arrive,
    )
    components = principal(axis)

    found = _Found(timeline, limit, shortlist)

    def task(block: _Block) -> BlockTask:
        frames = [group.frames for group in block.groups]
        return BlockTask(
            positions=tuple(timeline.positions[each] for each in frames),
            lengths=tuple(group.lengths for group in block.groups),
            leave=tuple(masks[0][each] for each in frames),
            arrive=tuple(masks[1][each] for each in frames),
            weights=weights,
            window=window,
            neighbourhood=neighbourhood,
            limit=limit,
            limits=tuple(found.limits()[each] for each in frames),
            grain=grain,
            components=components,
            part=block.part,
        )

    # What is kept was looked for below the limits of its time. It serves unless they were lower
    # than those that all that is kept gives: more of it gives lower ones.
    kept = []
    for block in blocks:
        file = stages.load(STAGE, block.key)
        if file is not None and (shortlist is not None or found.serves(block, file[0])):
            found.add(block, file[0])
            kept.append((block, {name: file[0][name] for name in ("until", "below")}))
    found.settle()
    served = {block.key for block, limits in kept if found.serves(block, limits)}
    missing = [block for block in blocks if block.key not in served]
    with tqdm(
        total=len(blocks),
        initial=len(served),
        desc="distances",
        unit="block",
        disable=not progress,
        leave=False,
    ) as bar:
        for number, arrays in run_all(stages.executor, search_block, map(task, missing)):
            stages.save(STAGE, missing[number].key, arrays)
            found.add(missing[number], arrays)
            bar.update()
            if watch is not None:
                watch(bar.n / len(blocks))
    return found.minima()


class _Found:
    """Minima of the blocks that are done: all of them, or a shortlist."""

    def __init__(self, timeline: ClipTimeline, limit: float, shortlist: Shortlist | None) -> None:
        self._everywhere = np.full(len(timeline.root), limit)
        self._shortlist = shortlist
        self._every: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def limits(self) -> np.ndarray:
        return self._everywhere if self._shortlist is None else self._shortlist.limits()

    def serves(self, block: _Block, arrays: dict[str, np.ndarray]) -> bool:
        """Whether what was found below some limits has all that is wanted now."""
        frames = np.concatenate([group.frames for group in block.groups])
        below = np.repeat(arrays["below"], np.diff(arrays["until"], prepend=0))
        return bool((below >= self.limits()[frames]).all())

    def add(self, block: _Block, arrays: dict[str, np.ndarray]) -> None:
        frames = np.concatenate([group.frames for group in block.groups])
        rows, columns = (frames[arrays[name]] for name in ("rows", "columns"))
        if self._shortlist is None:
            self._every.append((rows, columns, arrays["squared"]))
        else:
            self._shortlist.add(rows, columns, arrays["squared"])

    def settle(self) -> None:
        """Brings the limits up to date."""
        if self._shortlist is not None:
            self._shortlist.kept()

    def minima(self) -> Minima:
        if self._shortlist is not None:
            self._every = [self._shortlist.kept()]
        none = np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
        every = zip(none, *self._every, strict=True)
        rows, columns, squared = (np.concatenate(each) for each in every)
        order = np.lexsort((columns, rows, squared))
        return Minima(
            rows=rows[order],
            columns=columns[order],
            distances=np.sqrt(squared[order]),
            largest=0.0,
        )


def _blocks(groups: list[Group], settings: str, neighbourhood: int) -> Iterator[_Block]:
    """Groups with themselves and with one another, in parts of so many pairs of tiles; all groups
    are met early, so that limits go down early."""
    for apart in range(len(groups)):
        for first, second in zip(groups, groups[apart:], strict=False):
            pair = (first,) if second is first else (first, second)
            count = len(tile_pairs(tile_counts([g.lengths for g in pair], neighbourhood)))
            for part in range(-(-count // PART)):
                yield _Block(content_key(settings, [g.key for g in pair], part), pair, part)
