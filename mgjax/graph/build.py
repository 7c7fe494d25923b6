"""From clips to a motion graph: distances, minima, transitions, pruning.

After Kovar, Gleicher and Pighin (2002), with labelled parts as in the avoidance paper (§3.1).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from mgjax.clips.labels import validate_labels
from mgjax.clips.types import ClipLike, Label, Labels, as_clips
from mgjax.core.body.height import body_scale
from mgjax.core.body.roles import require_roles
from mgjax.core.errors import ConfigError, GraphError, SkeletonError
from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, validate_skeleton
from mgjax.graph.assemble import assemble
from mgjax.graph.config import GraphConfig, validate_graph_config
from mgjax.graph.distances.distance import normalised_weights
from mgjax.graph.distances.minima import Minima
from mgjax.graph.feet.legs import foot_chains
from mgjax.graph.parts.connectivity import connectivity
from mgjax.graph.parts.margins import allowed_windows
from mgjax.graph.pruning.candidates import Conditions
from mgjax.graph.pruning.keep import keep
from mgjax.graph.pruning.prune import (
    Candidates,
    smallest_useful_threshold,
)
from mgjax.graph.stages.stages import Stages
from mgjax.graph.stages.steps import Steps
from mgjax.graph.timeline import make_timeline
from mgjax.graph.types import MotionGraph

_STEPS = {
    "prepare": (0.0, "putting the clips on one skeleton"),
    "distance": (0.1, "comparing poses"),
    "prune": (0.7, "cutting off dead ends"),
    "transitions": (0.75, "blending transitions"),
    "assemble": (0.95, "putting the graph together"),
    "connectivity": (0.98, "measuring how soon parts come"),
}
"""About how much is done when a step begins, and what it does."""


@dataclass(kw_only=True)
class _Stopwatch:
    watch: Callable[[float, str], None] | None
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        if self.watch is not None:
            self.watch(*_STEPS[name])
        start = time.perf_counter()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start

    def within(self, name: str) -> Callable[[float], None]:
        """To be told about how much of a step is done."""
        names = list(_STEPS)
        (begin, what), (end, _) = _STEPS[name], _STEPS[names[names.index(name) + 1]]

        def tell(share: float) -> None:
            if self.watch is not None:
                self.watch(begin + share * (end - begin), what)

        return tell


def build_graph(
    clips: Mapping[str, tuple[Skeleton, Motion]] | Iterable[ClipLike],
    *,
    labels: Mapping[str, Iterable[Label]] | None = None,
    config: GraphConfig | None = None,
    skeleton: Skeleton | tuple[Skeleton, Motion] | None = None,
    progress: bool = False,
    watch: Callable[[float, str], None] | None = None,
    stages: Stages | None = None,
) -> MotionGraph:
    """Builds a motion graph.

    Args:
        clips: clips, or (skeleton, motion) pairs, or a mapping of names to pairs.
        labels: intervals by clip name, such as avoidance parts, that no transition may touch except
            for the margins at their ends (``label_quiet``, ``label_overlap``).
        config: settings.
        skeleton: the skeleton of the graph; by default the first clip's. With a motion of it
            (which does not become part of the graph) it is known for retargeting how it moves.
        progress: shows bars on stderr.
        watch: told about how much is done, 0 … 1, and what is done next; what it raises ends the
            work.
        stages: where blocks of the work are computed and kept
            (:class:`mgjax.graph.stages.stages.Stages`); None: in one piece, here. The graph is
            the same.

    Returns:
        The largest strongly connected component; its ``report`` has the statistics.

    Raises:
        SkeletonError: hierarchies differ and ``config.retarget`` is off, or have no hips.
        LabelError: an interval outside its clip, or overlapping another.
        ConfigError: a setting out of range.
        GraphError: nothing is left, or the automatic threshold does not exist; says what would do.
        WorkerError: a worker ended; what was done before is kept in the stages' folder.
        OutputError: nothing can be written there.
    """
    config = config or GraphConfig()
    validate_graph_config(config)
    named = as_clips(clips)
    if not named:
        raise GraphError("got no clips, expected at least one")
    for clip in named:
        validate_skeleton(clip.skeleton)
        validate_motion(clip.skeleton, clip.motion)
    by_clip: Labels = {name: tuple(items) for name, items in (labels or {}).items()}
    validate_labels(by_clip, named)
    clock = _Stopwatch(watch=watch)
    with clock.step("prepare"):
        reference, example = skeleton if isinstance(skeleton, tuple) else (skeleton, None)
        timeline, notes = make_timeline(
            named, by_clip, reference or named[0].skeleton, config, example
        )
    window = max(1, round(config.window_s * config.frame_rate))
    weights = joint_weights(timeline.skeleton, config.weights)
    scale = body_scale(timeline.skeleton)
    allowed = allowed_windows(
        timeline.starts, timeline.stops, timeline.core_starts, timeline.core_stops, window
    )
    steps = Steps(
        timeline=timeline,
        weights=weights,
        window=window,
        allowed=allowed,
        config=config,
        stages=stages,
        progress=progress,
    )
    conditions = Conditions(timeline=timeline, allowed=allowed, window=window, config=config)

    def choose(minima: Minima) -> tuple[Candidates, np.ndarray, np.ndarray]:
        found, ok = conditions.candidates(minima.rows, minima.columns, minima.distances)
        return found, minima.rows[ok], minima.columns[ok]

    with clock.step("distance"):
        minima, counted = steps.minima(_search_limit(config), clock.within("distance"), conditions)
    with clock.step("prune"):
        candidates, rows, columns = choose(minima)
        largest = minima.largest / scale
        chosen = steps.kept(
            (candidates, largest), lambda: keep(candidates, largest, window, config)
        )
        threshold, kept = chosen.threshold, chosen.transitions
        if chosen.lost > 0:
            notes.append(
                f"keeping {config.best_per_s} transitions out of each second of motion lost"
                f" {chosen.lost} labels; a larger best_per_s keeps more"
            )
        if not len(kept):
            every, _ = steps.minima(float("inf"), clock.within("prune"), conditions)
            raise _nothing_left(choose(every)[0], threshold, largest, config)
    with clock.step("transitions"):
        chains = None
        try:
            chains = foot_chains(timeline.skeleton)
        except SkeletonError as error:
            if config.clean_feet:
                notes.append(f"feet not cleaned: {error}")
        blended = steps.transitions(rows[kept], columns[kept], chains, clock.within("transitions"))
    if stages is not None:
        notes += stages.notes()
    report: dict[str, Any] = {
        "clips": len(timeline.clips),
        "seconds_of_clips": float((timeline.stops - timeline.starts).sum() / config.frame_rate),
        "threshold_m": float(threshold),
        "blend": config.blend,
        "clean_feet": config.clean_feet and chains is not None,
        # Of many clips only what may stay is looked for.
        "minima": len(minima.rows) if counted else None,
        "candidates": len(candidates.leave) if counted else None,
        "dropped_by_best_per_s": chosen.dropped if counted else None,
        "labels_total": sum(len(items) for items in by_clip.values()) * (2 if config.mirror else 1)
        + timeline.between,
        "notes": notes,
        "retargeted": [asdict(c.retargeted) for c in timeline.clips if c.retargeted],
    }
    with clock.step("assemble"):
        graph = assemble(timeline, candidates, kept, blended, window, config, report)
    with clock.step("connectivity"):
        report["connectivity"] = connectivity(graph)
    report["seconds"] = {k: round(v, 4) for k, v in clock.seconds.items()}
    return graph


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
