"""Hits found in captured kicks: against their labels, over thresholds, offline and streaming.

    python -m experiments.ballsport.analysis --set clips=FOLDER

``clips`` is a folder of capture with a ``labels.json`` that gives the foot and the moment of the
greatest toe speed (``peak_s``) of each kick, which is compared with F_S. Without it the embedded
kicks are analysed.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.ballsport.analysis_plot import curves_figure, poses_figure
from experiments.ballsport.kicks import (
    Kick,
    captured,
    captured_kicks,
    embedded_kicks,
    without_t_pose,
)
from mgjax.ballsport.config import FEET, AnalysisConfig
from mgjax.ballsport.hits.bones import BoneHit, LiveAnalysis, analyse
from mgjax.clips.types import Clip
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import resample
from mgjax.runs.experiment import Results, experiment

TOLERANCE_S = 0.1


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is analysed and how.

    Attributes:
        clips: folder of capture with ``labels.json``; "" for the embedded kicks.
        exclude: glob patterns of clips to leave out.
        seed: of the embedded kicks.
        analysis: thresholds.
        heights_m: thresholds of the sweep.
        smoothing_s: smoothings of the sweep.
        frame_rates: rates of the sweep; 0 is the captured one.
        shown: clips of the curves; the first kick of the first is drawn in poses.
    """

    clips: str = ""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    seed: int = 0
    analysis: AnalysisConfig = field(default_factory=AnalysisConfig)
    heights_m: tuple[float, ...] = (0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5)
    smoothing_s: tuple[float, ...] = (0.0, 0.01, 0.02)
    frame_rates: tuple[float, ...] = (0.0, 60.0, 30.0)
    shown: tuple[str, ...] = ("cmu10/10_02.amc", "cmu135/135_07.amc")

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "clips": "",
            "heights_m": (0.25, 0.3),
            "smoothing_s": (0.01,),
            "frame_rates": (0.0,),
            "shown": ("kick_attack_left", "kick_toss_right"),
        }


def compare(hits: list[BoneHit], kicks: list[Kick], frame_rate: float, first: int) -> dict:
    """Each kick with its hit, the hits that belong to none and the kicks that were missed."""
    open_kicks, rows, spurious = list(kicks), [], []
    for item in hits:
        at = (item.hit.fastest + first) / frame_rate
        near = [
            k
            for k in open_kicks
            if item.bone == f"{k.foot}_foot" and abs(at - k.peak_s) <= TOLERANCE_S
        ]
        if not near:
            spurious.append({"bone": item.bone, "fastest_s": at, "v_max": item.vector.v_max})
            continue
        kick = min(near, key=lambda k: abs(at - k.peak_s))
        open_kicks.remove(kick)
        keys = [(f + first) / frame_rate for f in item.hit.key_frames]
        hit = item.hit
        rows.append(
            {
                "foot": kick.foot,
                "kind": kick.kind,
                "peak_s": kick.peak_s,
                "fastest_s": at,
                "error_s": at - kick.peak_s,
                "v_max": item.vector.v_max,
                "ball_section_s": [(f + first) / frame_rate for f in (hit.hit_start, hit.hit_stop)],
                "hit_section_s": [(f + first) / frame_rate for f in (hit.start, hit.stop)],
                "key_poses_s": keys,
            }
        )
    missed = [{"foot": k.foot, "peak_s": k.peak_s} for k in open_kicks]
    return {"found": rows, "spurious": spurious, "missed": missed}


def streamed(clip: Clip, positions: np.ndarray, config: AnalysisConfig) -> dict[str, Any]:
    """Hits of a stream: whether they equal those of the whole, their delay, the time per frame."""
    rate = clip.motion.frame_rate
    live = LiveAnalysis(clip.skeleton, rate, config=config)
    hits: list[BoneHit] = []
    delays: list[float] = []
    seconds: list[float] = []
    for number, frame in enumerate(positions):
        start = time.perf_counter()
        new = live.push(frame)
        seconds.append(time.perf_counter() - start)
        hits += new
        delays += [(number + 1 - item.hit.stop) / rate for item in new]
    hits += live.finish()
    offline = analyse(clip.skeleton, positions, rate, config=config)
    order = sorted(hits, key=lambda x: (x.hit.start, x.bone))
    expected = sorted(offline, key=lambda x: (x.hit.start, x.bone))
    same = [x.hit for x in order] == [x.hit for x in expected]
    gap = max(
        (
            float(np.abs(a.vector.displacements - b.vector.displacements).max())
            for a, b in zip(order, expected, strict=False)
        ),
        default=0.0,
    )
    return {"same": same, "vector_gap_m": gap, "delays_s": delays, "seconds": seconds}


def totals(clips: list[Clip], kicks: dict[str, list[Kick]], config: AnalysisConfig) -> dict:
    """Kicks found, missed, and spurious hits over all clips."""
    rows = [
        compare(
            analyse(
                c.skeleton,
                np.asarray(global_positions(c.skeleton, c.motion)),
                c.motion.frame_rate,
                config=config,
            ),
            kicks.get(c.name, []),
            c.motion.frame_rate,
            0,
        )
        for c in clips
    ]
    return {name: sum(len(r[name]) for r in rows) for name in ("found", "missed", "spurious")}


def sweep(clips: list[Clip], kicks: dict[str, list[Kick]], config: Config) -> list[dict[str, Any]]:
    """The totals over threshold height, smoothing and frame rate."""
    rows: list[dict[str, Any]] = []
    for rate in config.frame_rates:
        resampled = [replace(c, motion=resample(c.motion, rate)) if rate else c for c in clips]
        for smoothing in config.smoothing_s:
            for height in config.heights_m:
                settings = replace(config.analysis, height_m=height, smoothing_s=smoothing)
                row = {"frame_rate": rate, "smoothing_s": smoothing, "height_m": height}
                rows.append(row | totals(resampled, kicks, settings))
    return rows


def run(config: Config) -> Results:
    if config.clips:
        clips, kicks = captured(config.clips, config.exclude), captured_kicks(config.clips)
    else:
        clips, kicks = embedded_kicks(config.seed, 60.0)
    cut: list[Clip] = []
    shifted: dict[str, list[Kick]] = {}
    for clip in clips:
        clean, first = without_t_pose(clip)
        cut.append(clean)
        offset = first / clip.motion.frame_rate
        shifted[clip.name] = [
            replace(k, peak_s=k.peak_s - offset) for k in kicks.get(clip.name, [])
        ]
    per_clip: dict[str, Any] = {}
    stream: list[dict[str, Any]] = []
    shown: dict[str, tuple[Clip, np.ndarray, list[BoneHit], list[Kick]]] = {}
    for clip in cut:
        positions = np.asarray(global_positions(clip.skeleton, clip.motion))
        hits = analyse(
            clip.skeleton, positions, clip.motion.frame_rate, config=config.analysis, bones=FEET
        )
        labelled = shifted[clip.name]
        per_clip[clip.name] = compare(hits, labelled, clip.motion.frame_rate, 0)
        stream.append(streamed(clip, positions, config.analysis))
        if clip.name in config.shown:
            shown[clip.name] = (clip, positions, hits, labelled)
    errors = [row["error_s"] for item in per_clip.values() for row in item["found"]]
    delays = [d for item in stream for d in item["delays_s"]]
    pushes = np.concatenate([item["seconds"] for item in stream])
    number = {
        name: sum(len(item[name]) for item in per_clip.values())
        for name in ("found", "missed", "spurious")
    }
    metrics = {
        **number,
        "labelled": sum(len(k) for k in shifted.values()),
        "largest_error_s": float(np.abs(errors).max()) if errors else None,
        "stream_is_offline": all(item["same"] for item in stream),
        "stream_vector_gap_m": max(item["vector_gap_m"] for item in stream),
        "delay_after_hit_s_p50_p95_max": np.percentile(delays, [50, 95, 100]) if delays else None,
        "clips": per_clip,
        "sweep": sweep(cut, shifted, config),
    }
    timings = {"push_s_p50_p99_max": np.percentile(pushes, [50, 99, 100])}
    pictures = [shown[name] for name in config.shown if name in shown]
    figures: dict[str, Figure | Callable[[], Figure]] = {}
    if pictures:
        figures["curves"] = partial(curves_figure, pictures, config.analysis)
        figures["key_poses"] = partial(poses_figure, *pictures[0][:3])
    worst = 1000 * (metrics["largest_error_s"] or 0.0)
    return Results(
        metrics=metrics,
        timings=timings,
        figures=figures,
        lines=(
            f"{number['found']} of {metrics['labelled']} kicks found with the right foot,"
            f" F_S at most {worst:.0f} ms from the label; {number['spurious']} spurious hits",
            f"streaming gives the same hits: {metrics['stream_is_offline']}",
        ),
    )


if __name__ == "__main__":
    experiment(run, Config)
