"""From clips to a motion graph: distances, minima, transitions, pruning.

After Kovar, Gleicher and Pighin (2002), with labelled parts as in the avoidance paper (§3.1).
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mgjax.clips.labels import validate_labels
from mgjax.clips.prepare import PreparedClip, prepare_clips
from mgjax.clips.types import Clip, ClipLike, Label, Labels, as_clips
from mgjax.core.contacts import foot_joints, planted
from mgjax.core.errors import ConfigError, GraphError, SkeletonError
from mgjax.core.kinematics import planar_frames
from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, require_roles, validate_skeleton
from mgjax.graph.config import GraphConfig
from mgjax.graph.distance import normalised_weights
from mgjax.graph.feet import foot_chains
from mgjax.graph.minima import Minima, find_minima
from mgjax.graph.prune import (
    Candidates,
    choose_threshold,
    largest_component,
    smallest_useful_threshold,
)
from mgjax.graph.transition import build_transitions, frame_positions
from mgjax.graph.types import NO_CLIP, MotionGraph


@dataclass(kw_only=True)
class _Stopwatch:
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start


@dataclass(frozen=True, kw_only=True)
class _Axis:
    """All prepared clips on one axis of frames."""

    skeleton: Skeleton
    clips: list[PreparedClip]
    starts: np.ndarray
    stops: np.ndarray
    root: np.ndarray
    rotations: np.ndarray
    positions: np.ndarray
    plants: np.ndarray
    label_starts: np.ndarray
    label_stops: np.ndarray
    labels: list[Label]


def build_graph(
    clips: Mapping[str, tuple[Skeleton, Motion]] | Iterable[ClipLike],
    *,
    labels: Mapping[str, Iterable[Label]] | None = None,
    config: GraphConfig | None = None,
    skeleton: Skeleton | None = None,
    progress: bool = False,
) -> MotionGraph:
    """Builds a motion graph.

    Args:
        clips: clips, or (skeleton, motion) pairs, or a mapping of names to pairs.
        labels: intervals by clip name that no transition may touch, such as avoidance parts.
        config: settings.
        skeleton: the skeleton of the graph; by default the first clip's.
        progress: shows bars on stderr.

    Returns:
        The largest strongly connected component; its ``report`` has the statistics.

    Raises:
        SkeletonError: hierarchies differ, or have no hips.
        LabelError: an interval outside its clip, or overlapping another.
        ConfigError: a setting out of range.
        GraphError: nothing is left, or the automatic threshold does not exist; says what would do.
    """
    config = config or GraphConfig()
    _validate(config)
    named = as_clips(clips)
    if not named:
        raise GraphError("got no clips, expected at least one")
    for clip in named:
        validate_skeleton(clip.skeleton)
        validate_motion(clip.skeleton, clip.motion)
    given: Labels = {name: tuple(items) for name, items in (labels or {}).items()}
    validate_labels(given, named)
    watch = _Stopwatch()
    with watch.step("prepare"):
        axis, notes = _lay_out(named, given, skeleton or named[0].skeleton, config)
    window = max(1, round(config.window_s * config.frame_rate))
    weights = joint_weights(axis.skeleton, config.weights)

    def search(limit: float) -> Minima:
        return find_minima(
            axis.positions,
            axis.starts,
            axis.stops,
            weights,
            window=window,
            neighbourhood=config.neighbourhood,
            threshold=limit,
            progress=progress,
        )

    with watch.step("distance"):
        minima = search(_search_limit(config))
    with watch.step("prune"):
        candidates, rows, columns = _candidates(axis, minima, window, config)
        threshold = _threshold(candidates, minima.largest, config)
        count = int(np.searchsorted(candidates.distances, threshold, side="left"))
        component = largest_component(candidates, count)
        if not component.frames:
            beyond = _candidates(axis, search(float("inf")), window, config)[0]
            raise _nothing_left(beyond, threshold, minima.largest, config)
    with watch.step("transitions"):
        chains = None
        if config.clean_feet:
            try:
                chains = foot_chains(axis.skeleton)
            except SkeletonError as error:
                notes.append(f"feet not cleaned: {error}")
        kept = np.flatnonzero(component.kept)
        blended = build_transitions(
            axis.skeleton,
            axis.root,
            axis.rotations,
            axis.positions,
            axis.plants,
            chains,
            rows[kept],
            columns[kept],
            weights,
            window,
        )
    report: dict[str, Any] = {
        "clips": len(axis.clips),
        "seconds_of_clips": float((axis.stops - axis.starts).sum() / config.frame_rate),
        "threshold_m": float(threshold),
        "minima": len(minima.rows),
        "candidates": len(candidates.leave),
        "labels_total": sum(len(items) for items in given.values()) * (2 if config.mirror else 1),
        "notes": notes,
    }
    with watch.step("assemble"):
        graph = _assemble(axis, candidates, kept, blended, window, config, report)
    report["seconds"] = {k: round(v, 4) for k, v in watch.seconds.items()}
    return graph


def _validate(config: GraphConfig) -> None:
    checks = {
        "frame_rate": 1 <= config.frame_rate <= 1000,
        "window_s": 0 < config.window_s <= 10,
        "neighbourhood": 1 <= config.neighbourhood <= 50,
        "self_gap_s": 0 <= config.self_gap_s < np.inf,
        "threshold_m": config.threshold_m is None or 0 < config.threshold_m < np.inf,
        "normalised": config.normalised is None or 0 < config.normalised <= 1,
        "keep": 0 <= config.keep <= 1,
        "max_threshold_m": 0 < config.max_threshold_m <= 10,
        "horizon_s": config.horizon_s > 0,
    }
    for name, ok in checks.items():
        if not ok:
            raise ConfigError(f"{name} = {getattr(config, name)!r} is out of range")
    if config.threshold_m is not None and config.normalised is not None:
        raise ConfigError("got both threshold_m and normalised, expected at most one")


def joint_weights(skeleton: Skeleton, weights: str | dict[str, float]) -> np.ndarray:
    """[J] weights with the sum 1, from a preset or a table of joint names.

    Presets: ``uniform`` gives every joint that turns the same weight; ``limbs`` counts hips, knees,
    shoulders and elbows only, the joints whose place decides most of the look of a pose.
    """
    values = np.zeros(skeleton.num_joints)
    if isinstance(weights, dict):
        for name, value in weights.items():
            values[skeleton.index(name)] = value
    elif weights == "uniform":
        values[:] = 1
        values[list(skeleton.end_joints)] = 0
    elif weights == "limbs":
        parts = [
            f"{s}_{p}" for s in ("left", "right") for p in ("hip", "knee", "shoulder", "elbow")
        ]
        values[list(require_roles(skeleton, parts))] = 1
    else:
        raise ConfigError(f"weights {weights!r}, expected uniform, limbs or a table of joints")
    return normalised_weights(values, skeleton.num_joints)


def _lay_out(
    clips: list[Clip], labels: Labels, skeleton: Skeleton, config: GraphConfig
) -> tuple[_Axis, list[str]]:
    prepared, notes = prepare_clips(
        clips, labels, skeleton=skeleton, frame_rate=config.frame_rate, mirrored=config.mirror
    )
    lengths = np.array([c.motion.num_frames for c in prepared])
    stops = np.cumsum(lengths)
    starts = stops - lengths
    root = np.concatenate([_centred(np.asarray(c.motion.root_translation)) for c in prepared])
    rotations = np.concatenate([np.asarray(c.motion.local_rotations) for c in prepared])
    positions = frame_positions(skeleton, root, rotations)
    feet = list(foot_joints(skeleton))
    plants = np.concatenate(
        [
            planted(positions[a:b, feet], config.frame_rate)
            for a, b in zip(starts, stops, strict=True)
        ]
    )
    frames = np.concatenate(
        [c.label_frames + a for c, a in zip(prepared, starts, strict=True)]
    ).astype(np.int64)
    axis = _Axis(
        skeleton=skeleton,
        clips=prepared,
        starts=starts,
        stops=stops,
        root=root,
        rotations=rotations,
        positions=positions,
        plants=plants,
        label_starts=frames[:, 0],
        label_stops=frames[:, 1],
        labels=[label for c in prepared for label in c.labels],
    )
    return axis, notes


def _centred(root: np.ndarray) -> np.ndarray:
    """Moves a clip to the middle of the floor: nothing depends on where it was captured."""
    middle = root.astype(np.float64).mean(axis=0) * [1, 0, 1]
    return (root - middle).astype(np.float32)


def _search_limit(config: GraphConfig) -> float:
    if config.normalised is not None:
        return float("inf")
    return config.threshold_m if config.threshold_m is not None else config.max_threshold_m


def _nothing_left(
    candidates: Candidates, threshold: float, largest: float, config: GraphConfig
) -> GraphError:
    """Says which threshold would leave something; ``candidates`` are those at any distance."""

    def rounded_up(value: float) -> str:  # what is named as enough must be enough
        return f"{np.ceil(value * 1e5 + 1e-3) / 1e5:.5f}"

    useful = smallest_useful_threshold(candidates)
    if useful is None:
        expected = "other clips: at no threshold do these lead back to where they begin"
    else:
        expected = f"at least {rounded_up(useful)} m"
        if config.normalised is not None:
            expected += f" (normalised {rounded_up(useful / largest)})"
    return GraphError(f"got an empty graph at threshold {threshold:.6g} m, expected {expected}")


def _candidates(
    axis: _Axis, minima: Minima, window: int, config: GraphConfig
) -> tuple[Candidates, np.ndarray, np.ndarray]:
    """Minima that may become transitions, and the first frames of their windows."""
    rows, columns = minima.rows, minima.columns
    clip_of = np.searchsorted(axis.starts, np.arange(len(axis.root)), side="right") - 1
    gap = round(config.self_gap_s * config.frame_rate)
    near = (clip_of[rows] == clip_of[columns]) & (np.abs(rows - columns) < gap)
    # The frame before the blend and the one after it must be there.
    before = rows > axis.starts[clip_of[rows]]
    after = columns + window < axis.stops[clip_of[columns]]
    marked = np.zeros(len(axis.root) + 1, dtype=np.int64)
    for start, stop in zip(axis.label_starts, axis.label_stops, strict=True):
        marked[start + 1 : stop + 1] = 1
    total = np.cumsum(marked)
    free = [total[np.minimum(x + window, len(axis.root))] == total[x] for x in (rows, columns)]
    ok = ~near & before & after & free[0] & free[1]
    candidates = Candidates(
        leave=rows[ok],
        arrive=columns[ok] + window,
        distances=minima.distances[ok],
        starts=axis.starts,
        stops=axis.stops,
        label_starts=axis.label_starts,
        label_stops=axis.label_stops,
    )
    return candidates, rows[ok], columns[ok]


def _threshold(candidates: Candidates, largest: float, config: GraphConfig) -> float:
    if config.threshold_m is not None:
        return config.threshold_m
    if config.normalised is not None:
        return config.normalised * largest
    return choose_threshold(candidates, config.keep, config.max_threshold_m)


def _assemble(
    axis: _Axis,
    candidates: Candidates,
    kept: np.ndarray,
    blended: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    window: int,
    config: GraphConfig,
    report: dict[str, Any],
) -> MotionGraph:
    roots, rotations, transforms, slides = blended
    leave, arrive = candidates.leave[kept], candidates.arrive[kept]
    frames = np.unique(np.concatenate([leave, arrive]))
    clip = np.searchsorted(axis.starts, frames, side="right") - 1
    along = np.flatnonzero(clip[1:] == clip[:-1])
    first = len(axis.root) + np.arange(len(kept)) * (window + 1)
    source = np.concatenate([along, np.searchsorted(frames, leave)])
    target = np.concatenate([along + 1, np.searchsorted(frames, arrive)])
    edge_starts = np.concatenate([frames[along], first])
    edge_stops = np.concatenate([frames[along + 1], first + window])
    edge_clip = np.concatenate([clip[along], np.full(len(kept), NO_CLIP)])
    distances = np.concatenate([np.zeros(len(along)), candidates.distances[kept]])
    exits = np.concatenate([np.zeros((len(along), 3)), transforms]).astype(np.float32)
    order = np.argsort(source, kind="stable")
    out_first = np.concatenate([[0], np.cumsum(np.bincount(source, minlength=len(frames)))])
    # A label belongs to the one piece of a clip that holds it whole.
    at = np.searchsorted(edge_starts[: len(along)], axis.label_starts, side="right") - 1
    holds = (at >= 0) & (axis.label_stops <= edge_stops[np.maximum(at, 0)])
    inside = np.flatnonzero(holds)
    genuine = np.array([label.genuine for label in axis.labels], dtype=bool)
    middle = (axis.label_starts + axis.label_stops) / 2 - edge_starts[np.maximum(at, 0)]
    enterable = holds & (middle <= config.horizon_s * config.frame_rate)
    report.update(
        frames=int((axis.stops - axis.starts).sum()),
        transitions=len(kept),
        nodes=len(frames),
        edges=len(source),
        labels_kept=int(holds.sum()),
        labels_enterable=int(enterable.sum()),
        genuine_total=int(genuine.sum()),
        genuine_kept=int((holds & genuine).sum()),
        genuine_enterable=int((enterable & genuine).sum()),
        foot_slide_before=float(slides[:, 0].mean()),
        foot_slide_after=float(slides[:, 1].mean()),
    )
    node_plane = planar_frames(axis.skeleton, axis.positions[frames])
    return MotionGraph(
        skeleton=axis.skeleton,
        frame_rate=config.frame_rate,
        window=window,
        root_translation=np.concatenate([axis.root, roots.reshape(-1, 3)]).astype(np.float32),
        local_rotations=np.concatenate(
            [axis.rotations, rotations.reshape(-1, *rotations.shape[2:])]
        ).astype(np.float32),
        clip_names=tuple(c.name for c in axis.clips),
        clip_starts=axis.starts,
        clip_stops=axis.stops,
        node_frame=frames,
        node_clip=clip,
        node_plane=np.asarray(node_plane, dtype=np.float32),
        edge_source=source,
        edge_target=target,
        edge_starts=edge_starts,
        edge_stops=edge_stops,
        edge_clip=edge_clip,
        edge_exit=exits,
        edge_distance=distances.astype(np.float32),
        out_first=out_first,
        out_edges=order,
        label_edge=at[inside],
        label_starts=axis.label_starts[inside],
        label_stops=axis.label_stops[inside],
        label_kind=tuple(axis.labels[i].kind for i in inside),
        label_direction=tuple(axis.labels[i].direction for i in inside),
        label_genuine=genuine[inside],
        report=report,
    )
