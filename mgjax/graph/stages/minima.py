"""The search for minima block by block, each block kept as soon as it is done."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from mgjax.core.body.height import ADULT_M, body_scale
from mgjax.core.parallel.run import run_all
from mgjax.graph.distances.axis import make_axis
from mgjax.graph.distances.bounds import principal
from mgjax.graph.distances.minima import Minima
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
    leave: np.ndarray | None,
    arrive: np.ndarray | None,
    progress: bool = False,
    watch: Callable[[float], None] | None = None,
) -> Minima:
    """What :func:`mgjax.graph.distances.minima.find_minima` finds below a finite threshold.

    Distances are those of float64, so that they do not depend on how the work is cut.

    Args:
        timeline, groups: all clips; see :func:`corpus_groups`.
        weights: of the joints, with the sum 1. [J]
        stages: where blocks are computed and kept.
        window, neighbourhood, threshold, leave, arrive: as there.
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
    # A finer grain than this would tell windows apart that are alike, a coarser one would not.
    grain = 2.0 ** (2 * np.floor(np.log2(body_scale(timeline.skeleton) * ADULT_M)) - 40)

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
            grain=float(grain),
            components=components,
            part=block.part,
        )

    found: list[np.ndarray] = []

    def add(block: _Block, arrays: dict[str, np.ndarray]) -> None:
        frames = np.concatenate([group.frames for group in block.groups])
        places = [frames[arrays[name]] for name in ("rows", "columns")]
        found.append(np.stack([*places, arrays["squared"]]))

    missing = []
    for block in blocks:
        kept = stages.load(STAGE, block.key)
        if kept is None:
            missing.append(block)
        else:
            add(block, kept[0])
    with tqdm(
        total=len(blocks),
        initial=len(blocks) - len(missing),
        desc="distances",
        unit="block",
        disable=not progress,
        leave=False,
    ) as bar:
        for number, arrays in run_all(stages.executor, search_block, map(task, missing)):
            stages.save(STAGE, missing[number].key, arrays)
            add(missing[number], arrays)
            bar.update()
            if watch is not None:
                watch(bar.n / len(blocks))
    return _sorted(found)


def _sorted(found: list[np.ndarray]) -> Minima:
    rows, columns, squared = np.concatenate([np.zeros((3, 0)), *found], axis=1)
    rows, columns = rows.astype(np.int64), columns.astype(np.int64)
    order = np.lexsort((columns, rows, squared))
    return Minima(
        rows=rows[order],
        columns=columns[order],
        distances=np.sqrt(squared[order]),
        largest=0.0,
    )


def _blocks(groups: list[Group], settings: str, neighbourhood: int) -> Iterator[_Block]:
    """Groups with themselves and with one another, in parts of so many pairs of tiles."""
    for i, first in enumerate(groups):
        for second in groups[i:]:
            pair = (first,) if second is first else (first, second)
            count = len(tile_pairs(tile_counts([g.lengths for g in pair], neighbourhood)))
            for part in range(-(-count // PART)):
                yield _Block(content_key(settings, [g.key for g in pair], part), pair, part)
