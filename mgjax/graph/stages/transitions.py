"""Blending of transitions piece by piece; what was blended in an earlier build is not anew."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from mgjax.core.parallel.run import run_all
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.padding import bucket_size
from mgjax.graph.feet.legs import FootChains
from mgjax.graph.stages.groups import Group
from mgjax.graph.stages.stages import Stages
from mgjax.graph.timeline import ClipTimeline
from mgjax.graph.transition import CHUNK, FRAMES, build_transitions
from mgjax.io.content_key import content_key

STAGE = "transitions"
_CALLS = 4
"""Chunks of transitions in one piece of work."""
_ROOM = 8 * FRAMES
"""Enough for most pieces: those between two or three groups of clips."""
_NAMES = ("roots", "rotations", "transforms", "slides")


@dataclass(frozen=True, kw_only=True)
class BlendSettings:
    """What all transitions have in common; see :func:`build_transitions`."""

    skeleton: Skeleton
    chains: FootChains | None
    weights: np.ndarray
    window: int
    form: str
    clean: bool


@dataclass(frozen=True, kw_only=True)
class BlendTask:
    """Transitions, and of the axis of frames what they need.

    Attributes:
        settings: of all.
        axis: root, rotations, positions and plants of some frames.
        rows, columns: first frames of windows, counted through those.
        room: frames that they are padded to, so that pieces share a program.
    """

    settings: BlendSettings
    axis: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
    rows: np.ndarray
    columns: np.ndarray
    room: int


def blend_piece(task: BlendTask) -> tuple[np.ndarray, ...]:
    """The four results of :func:`build_transitions`."""
    s = task.settings
    return build_transitions(
        s.skeleton,
        *task.axis,
        chains=s.chains,
        rows=task.rows,
        columns=task.columns,
        weights=s.weights,
        window=s.window,
        form=s.form,
        clean=s.clean,
        room=task.room,
    )


class _Pairs:
    """Transitions by the two groups of clips that they connect.

    Attributes:
        members: which transitions belong to each pair of groups.
        rows, columns: their first frames, counted through both groups. [M]
    """

    def __init__(self, groups: list[Group], rows: np.ndarray, columns: np.ndarray) -> None:
        total = sum(len(group.frames) for group in groups)
        number, place = np.zeros((2, total), np.int64)
        for k, group in enumerate(groups):
            number[group.frames] = k
            place[group.frames] = np.arange(len(group.frames))
        ends = np.stack([number[rows], number[columns]])
        first, second = ends.min(axis=0), ends.max(axis=0)
        sizes = np.array([len(group.frames) for group in groups])
        behind = np.where(ends > first, sizes[first], 0)
        self.rows, self.columns = np.stack([place[rows], place[columns]]) + behind
        order = np.lexsort((self.columns, self.rows, second, first))
        changes = np.flatnonzero(np.diff(first[order]) | np.diff(second[order])) + 1
        self.members = [each for each in np.split(order, changes) if len(each)]
        self._groups = groups
        self._ends = first, second

    def key(self, pair: int, settings: str) -> str:
        first, second = (int(end[self.members[pair][0]]) for end in self._ends)
        return content_key(settings, self._groups[first].key, self._groups[second].key)


def staged_transitions(
    timeline: ClipTimeline,
    groups: list[Group],
    settings: BlendSettings,
    rows: np.ndarray,
    columns: np.ndarray,
    stages: Stages,
    *,
    progress: bool = False,
    watch: Callable[[float], None] | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """What :func:`build_transitions` returns, from pieces of work.

    Args:
        timeline, groups: all clips.
        settings: of all transitions.
        rows, columns: first frames of the two windows of each. [M]
        stages: where pieces are computed, and where the transitions between two groups are kept.
        progress: shows a bar on stderr, with the time left.
        watch: told the share of the work that is done.

    Raises:
        WorkerError: a worker ended; what was done before is kept.
        OutputError: transitions cannot be kept.
    """
    axis = timeline.root, timeline.rotations, timeline.positions, timeline.plants
    length, count = settings.window + 1, len(rows)
    joints = settings.skeleton.num_joints
    shapes = ((count, length, 3), (count, length, joints, 4), (count, 3), (count, 2))
    roots, rotations, transforms, slides = (np.zeros(shape, np.float32) for shape in shapes)
    out = roots, rotations, transforms, slides
    name = content_key(settings)
    pairs = _Pairs(groups, rows, columns)
    kept = [stages.load(STAGE, pairs.key(pair, name)) for pair in range(len(pairs.members))]
    missing, pair_of, left = [], np.zeros(count, np.int64), []
    for pair, (members, file) in enumerate(zip(pairs.members, kept, strict=True)):
        known = (
            np.zeros(len(members), bool) if file is None else _fill(out, pairs, members, file[0])
        )
        missing.append(members[~known])
        pair_of[members] = pair
        left.append(int((~known).sum()))
    del kept
    order = np.concatenate([np.zeros(0, np.int64), *missing])
    size = CHUNK * _CALLS
    pieces = [order[first : first + size] for first in range(0, len(order), size)]

    def task(piece: np.ndarray) -> BlendTask:
        return _task(settings, axis, rows[piece], columns[piece])

    with tqdm(
        total=count,
        initial=count - len(order),
        desc="transitions",
        unit="transition",
        disable=not progress,
        leave=False,
    ) as bar:
        for number, results in run_all(stages.executor, blend_piece, map(task, pieces)):
            piece = pieces[number]
            for whole, part in zip(out, results, strict=True):
                whole[piece] = part
            for pair, done in zip(*np.unique(pair_of[piece], return_counts=True), strict=True):
                left[pair] -= int(done)
                if not left[pair]:
                    _keep(stages, pairs.key(int(pair), name), out, pairs, pairs.members[pair])
            bar.update(len(piece))
            if watch is not None:
                watch(bar.n / count)
    return out


def _task(
    settings: BlendSettings, axis: tuple[np.ndarray, ...], rows: np.ndarray, columns: np.ndarray
) -> BlendTask:
    """The transitions with the frames that they are made of, and those beside them."""
    total = len(axis[0])
    starts = np.concatenate([rows, columns])
    needed = np.zeros(total, bool)
    for step in range(-1, settings.window + 2):
        needed[np.clip(starts + step, 0, total - 1)] = True
    place = np.cumsum(needed) - 1
    root, rotations, positions, plants = (each[needed] for each in axis)
    return BlendTask(
        settings=settings,
        axis=(root, rotations, positions, plants),
        rows=place[rows],
        columns=place[columns],
        room=min(bucket_size(total + 1, FRAMES), _ROOM),
    )


def _fill(
    out: tuple[np.ndarray, ...], pairs: _Pairs, members: np.ndarray, file: dict[str, np.ndarray]
) -> np.ndarray:
    """Copies what a file has of the transitions of a pair of groups; which those are."""
    have = {at: k for k, at in enumerate(zip(*_ends(file["rows"], file["columns"]), strict=True))}
    wanted = zip(*_ends(pairs.rows[members], pairs.columns[members]), strict=True)
    source = np.array([have.get(at, -1) for at in wanted])
    known = source >= 0
    for whole, name in zip(out, _NAMES, strict=True):
        whole[members[known]] = file[name][source[known]]
    return known


def _ends(rows: np.ndarray, columns: np.ndarray) -> tuple[list[int], list[int]]:
    return rows.tolist(), columns.tolist()


def _keep(
    stages: Stages, key: str, out: tuple[np.ndarray, ...], pairs: _Pairs, members: np.ndarray
) -> None:
    arrays = {name: whole[members] for name, whole in zip(_NAMES, out, strict=True)}
    ends = {"rows": pairs.rows[members], "columns": pairs.columns[members]}
    stages.save(STAGE, key, arrays | {name: each.astype(np.int32) for name, each in ends.items()})
