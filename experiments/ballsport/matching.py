"""Live hits against stored ones, each left out in turn; transitions between all link motions.

    python -m experiments.ballsport.matching --set clips=FOLDER

Every hit of the clip set (with its mirror image) is taken out and looked for among the others, as
captured and as a worse sensor or another body would show it. Captured kicks carry no kind; they
count as toss, pass or attack by the largest speed of the toe, like any unlabelled hit of a set.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from experiments.ballsport.disturbed import Found, disturbances, find_again
from experiments.ballsport.kicks import captured
from experiments.ballsport.matching_plot import confusion_figure, transition_figure
from experiments.ballsport.seams import seams
from mgjax.ballsport.clipset.build import ClipSet, build_clip_set
from mgjax.ballsport.clipset.match import StoredHits, distances, match_weights, nearest, store
from mgjax.ballsport.clipset.transition import find_transitions
from mgjax.ballsport.config import FEET, KINDS, AnalysisConfig, ClipSetConfig, MatchConfig
from mgjax.ballsport.hits.motion_vectors import MotionVectors, scaled
from mgjax.bench.timing import interleaved
from mgjax.runs.experiment import Results, experiment

_all_distances = jax.jit(jax.vmap(distances, (0, None, None)))


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is matched and how.

    Attributes:
        clips: folder of capture; "" for the embedded kicks alone.
        exclude: glob patterns of clips to leave out, such as second copies of a take.
        takes: embedded kicks of each kind and foot.
        seed: of the embedded kicks and of the disturbances.
        clip_set: frame rate, thresholds, transition sections.
        match: weights of D_m.
        noise_m: standard deviations of the places of all joints.
        dropped: shares of frames that never arrive; the gaps are filled linearly.
        bodies: sizes of other bodies, as a factor on all lengths.
        noisy_smoothing_s: smoothing with which noisy motion is analysed a second time, and the
            stored hits with it.
        seams: most joined pairs of link motions that are checked.
        stored: hits that a live motion is compared with where the time is measured.
        repeats: of the measured calls.
    """

    clips: str = ""
    exclude: tuple[str, ...] = ("bvh_converted/*", "cmu135_bvh/*")
    takes: int = 10
    seed: int = 0
    clip_set: ClipSetConfig = field(default_factory=ClipSetConfig)
    match: MatchConfig = field(default_factory=MatchConfig)
    noise_m: tuple[float, ...] = (0.005, 0.01, 0.02)
    dropped: tuple[float, ...] = (0.1, 0.3)
    bodies: tuple[float, ...] = (0.75, 1.25)
    noisy_smoothing_s: float = 0.04
    seams: int = 600
    stored: int = 10_000
    repeats: int = 200

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "clips": "",
            "takes": 2,
            "noise_m": (0.01,),
            "dropped": (0.1,),
            "bodies": (1.25,),
            "clip_set.frame_rate": 30.0,
            "seams": 4,
            "stored": 100,
            "repeats": 2,
        }


def distance_matrix(live: MotionVectors, stored: StoredHits, weights: np.ndarray) -> np.ndarray:
    """D_m of every live hit to every stored one."""
    return np.asarray(_all_distances(live, stored, weights))


def twins(clips: ClipSet) -> np.ndarray:
    """[H,H] which hits are the same or mirror images."""
    names = [clips.clip_names[c].removesuffix("~mirrored") for c in clips.hit_clip]
    place = clips.fastest - clips.clip_starts[clips.hit_clip]
    key = np.array([f"{name}:{f}" for name, f in zip(names, place, strict=True)])
    return key[:, None] == key


def judge(clips: ClipSet, found: Found, config: Config, size: float) -> dict[str, Any]:
    """Left-out matching: foot known or not, with and without the terms of speed and time."""
    kinds, bones = np.array(clips.hit_kind), np.array(clips.hit_bone)
    made = np.array([clips.clip_names[c].startswith("kick_") for c in clips.hit_clip])
    classes = np.array(
        [2 * KINDS.index(k) + FEET.index(b) for k, b in zip(kinds, bones, strict=True)]
    )
    stored = store(clips.vectors)
    live = scaled(found.vectors, 1 / size)
    own = twins(clips)[found.hit]
    other_foot = bones[found.hit][:, None] != bones[None]
    row: dict[str, Any] = {
        "hits": clips.num_hits,
        "found": len(found.hit),
        "missed": len(found.missed),
        "spurious": found.spurious,
        "foot_right_by_analysis": len(found.hit) / max(clips.num_hits + found.spurious, 1),
    }
    for name, match in (
        ("with_speed", config.match),
        ("without_speed", replace(config.match, w_v=0.0)),
        ("way_and_speed", replace(config.match, w_t=0.0)),
        ("way_only", replace(config.match, w_v=0.0, w_t=0.0)),
    ):
        far = distance_matrix(live, stored, match_weights(match))[:, : clips.num_hits]
        far = np.where(own, np.inf, far)
        for comparison, excluded in (("any_foot", own), ("same_foot", own | other_foot)):
            picked = np.argmin(np.where(excluded, np.inf, far), axis=1)
            right = kinds[picked] == kinds[found.hit]
            close = np.isin(kinds[found.hit], KINDS[:2])
            swapped = close & ~right & np.isin(kinds[picked], KINDS[:2])
            matrix = np.zeros((6, 6), int)
            np.add.at(matrix, (classes[found.hit], classes[picked]), 1)
            row[f"{name}_{comparison}"] = {
                "kind_right": float(right.mean()),
                "kind_right_made": float(right[made[found.hit]].mean()),
                "toss_pass_confused": float(swapped.sum() / max(close.sum(), 1)),
                "foot_right": float((bones[picked] == bones[found.hit]).mean()),
                "confusion": matrix,
            }
    return row


def clip_set(config: Config, analysis: AnalysisConfig) -> ClipSet:
    """The clip set, analysed with these thresholds."""
    return build_clip_set(
        captured(config.clips, config.exclude),
        config=replace(config.clip_set, analysis=analysis),
        seed=config.seed,
        takes=config.takes,
    )


def judge_all(clips: ClipSet, config: Config) -> dict[str, Any]:
    """All disturbances; noise also with more smoothing, of the stored hits too."""
    usual = config.clip_set.analysis
    more = replace(usual, smoothing_s=config.noisy_smoothing_s)
    smoother = clip_set(config, more)
    conditions: dict[str, Any] = {}
    for name, (disturb, size, known) in disturbances(
        config.noise_m, config.dropped, config.bodies, config.seed
    ).items():
        found = find_again(clips, usual, disturb, size)
        conditions[name] = judge(clips, found, config, size if known else 1.0)
        if name.startswith("noise"):
            found = find_again(smoother, more, disturb)
            label = f"{name}, smoothed {1000 * more.smoothing_s:g} ms"
            conditions[label] = judge(smoother, found, config, 1.0)
    return conditions


def timings(clips: ClipSet, config: Config) -> dict[str, Any]:
    """One live motion against many stored hits, and all transitions of the set."""
    rng = np.random.default_rng(config.seed)
    drawn = rng.integers(clips.num_hits, size=config.stored)
    many = jax.tree.map(lambda x: np.asarray(x)[drawn], clips.vectors)
    stored = store(many)
    one = jax.tree.map(lambda x: jnp.asarray(x[0]), clips.vectors)
    weights = jnp.asarray(match_weights(config.match))
    bare = jax.jit(lambda s: jax.tree.reduce(lambda a, b: a + b.sum(), (s.displacements,), 0.0))
    usual = clip_set(replace(config, takes=2), config.clip_set.analysis)
    sections, few = config.clip_set.transition, max(config.repeats // 20, 1)
    return {
        "match_one": interleaved(
            lambda: nearest(one, stored, weights), lambda: bare(stored), config.repeats
        ),
        "transitions": interleaved(partial(find_transitions, usual, sections), None, few),
        "transitions_of_all_takes": interleaved(
            partial(find_transitions, clips, sections), None, few
        ),
    }


def run(config: Config) -> Results:
    clips = clip_set(config, config.clip_set.analysis)
    conditions = judge_all(clips, config)
    table = find_transitions(clips, config.clip_set.transition)
    usual = table.distance[np.isfinite(table.distance)] / table.window
    metrics = {
        "hits": clips.num_hits,
        "kinds": {
            f"{kind} {bone}": sum(
                k == kind and b == bone for k, b in zip(clips.hit_kind, clips.hit_bone, strict=True)
            )
            for kind in KINDS
            for bone in FEET
        },
        "hits_labelled": int(clips.labelled.sum()),
        "links": clips.num_links,
        "link_frames": int((clips.link_stops - clips.link_starts).sum()),
        "conditions": conditions,
        "transitions": {
            "pairs": len(usual),
            "too_short": int(clips.num_links**2 - len(usual)),
            "distance_per_frame_p5_p50_p95": np.percentile(usual, [5, 50, 95]),
            **seams(clips, table, config.seams, config.seed),
        },
    }
    plain = conditions["as captured"]
    best, loose = plain["with_speed_same_foot"], plain["with_speed_any_foot"]
    return Results(
        metrics=metrics,
        timings=timings(clips, config),
        figures={
            "confusion": partial(confusion_figure, conditions),
            "transitions": partial(transition_figure, table.distance / table.window),
        },
        lines=(
            f"{plain['found']} of {plain['hits']} hits found on the right foot,"
            f" kind right {100 * best['kind_right']:.1f} %"
            f" (foot from D_m alone: {100 * loose['foot_right']:.1f} %)",
            "toss and pass confused with / without the speed term: "
            f"{100 * best['toss_pass_confused']:.1f} / "
            f"{100 * plain['without_speed_same_foot']['toss_pass_confused']:.1f} %;"
            " by the way of the foot with speed / alone: "
            f"{100 * plain['way_and_speed_same_foot']['toss_pass_confused']:.1f} / "
            f"{100 * plain['way_only_same_foot']['toss_pass_confused']:.1f} %",
        ),
    )


if __name__ == "__main__":
    experiment(run, Config)
