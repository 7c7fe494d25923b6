"""How transitions are blended: seams of all transitions under each blend, beside uncut capture.

    python -m experiments.quality.blends --set clips=FOLDER --out out/quality/blends

Without clips it uses the embedded ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from experiments.avoidance.graphs import EMBEDDED_M, clips_of
from experiments.quality.blends_plot import measures_figure, strips_figure
from experiments.quality.pieces import (
    Pieces,
    clip_motions,
    room,
    seam_edges,
    seam_pieces,
    uncut_pieces,
)
from experiments.quality.verdicts import auc
from mgjax.core.kinematics import global_positions
from mgjax.graph.build import build_graph
from mgjax.graph.config import BLENDS, GraphConfig
from mgjax.graph.types import MotionGraph
from mgjax.quality.known import Captured, captured
from mgjax.quality.measuring import measure_many
from mgjax.runs.experiment import Results, experiment

MEASURES = (
    *("jerk_ratio", "velocity_jump", "contact_speed", "skate_cm", "sink", "self_penetration"),
)
DEPTH_M, SINK_M = 0.01, 0.005
"""A seam fails by a limb deeper in the body, or a foot deeper in the floor, than this beyond the
capture."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is blended, and how."""

    clips: str = ""
    """Folder of clips with labels.json; empty: the embedded clips."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Patterns of clips that are left out."""
    blends: tuple[str, ...] = BLENDS
    """Blends to compare, at the automatic threshold; the paper's and support are among them."""
    clean_feet: tuple[bool, ...] = (False, True)
    """Whether feet are cleaned."""
    thresholds_m: tuple[float, ...] = (0.10, 0.13, 0.16, 0.20)
    """Thresholds beside the automatic one for the table of shares, m."""
    contacts: tuple[float, ...] = (0.0, 0.5, 0.7, 0.9)
    """Shares of frames in which the same feet must stand in both windows, for that table."""
    most: int = 1500
    """Seams that are measured for one row of that table, drawn at random."""
    seams: int = 0
    """Seams that are measured for one blend, drawn at random; 0: all."""
    strips: int = 10
    """Seams that are drawn: those that skate most under the paper's blend."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "clips": "",
            "blends": ("paper", "support"),
            "clean_feet": (False,),
            "thresholds_m": (),
            "contacts": (0.7,),
            "most": 40,
            "seams": 40,
            "strips": 2,
        }


def run(config: Config) -> Results:
    """Measures each blend, then each threshold and condition."""
    clips, labels = clips_of(config.clips, config.exclude)
    base = GraphConfig(threshold_m=None if config.clips else EMBEDDED_M)

    def built(**changes: Any) -> MotionGraph:
        return build_graph(clips, labels=labels, config=replace(base, **changes))

    rows: list[dict[str, Any]] = []
    known: Captured | None = None
    uncut: dict[str, np.ndarray] | None = None
    kept: dict[str, tuple[MotionGraph, dict[str, np.ndarray]]] = {}
    for clean in reversed(config.clean_feet):
        for name in config.blends:
            graph = built(blend=name, clean_feet=clean)
            known = known or captured_of(graph)
            row, values, uncut = _row(graph, known, uncut, config.seams or None)
            rows.append({"name": f"{name}, feet cleaned" if clean else name} | row)
            kept.setdefault(name, (graph, values))
    table = []
    for threshold in (base.threshold_m, *config.thresholds_m):
        for contacts in config.contacts:
            uncut = None
            for name in ("support", "paper") if contacts == config.contacts[0] else ("support",):
                graph = built(threshold_m=threshold, contacts=contacts, blend=name)
                row, _, uncut = _row(graph, known or captured_of(graph), uncut, config.most)
                table.append({"name": name, "contacts": contacts} | row)
    strips = _worst(kept["paper"], kept["support"], config.strips)
    skeleton = kept["paper"][0].skeleton
    shown = ("jerk_ratio", "velocity_jump", "contact_speed", "skate_cm")
    return Results(
        metrics={"blends": rows, "thresholds": table},
        figures={
            "measures": lambda: measures_figure(rows, shown),
            "strips": lambda: strips_figure(skeleton.parents, strips),
        },
        lines=tuple(_line(row) for row in (*rows, *table)),
    )


def captured_of(graph: MotionGraph) -> Captured:
    """What the clips of a graph do."""
    return captured([(graph.skeleton, motion) for motion in clip_motions(graph)])


def _measured(graph: MotionGraph, known: Captured, pieces: Pieces) -> dict[str, np.ndarray]:
    return measure_many(
        graph.skeleton,
        pieces.motions,
        against=known,
        spans_s=pieces.spans_s,
        rests=pieces.rests,
    )[0]


def _row(
    graph: MotionGraph,
    known: Captured,
    uncut: dict[str, np.ndarray] | None,
    most: int | None = None,
) -> tuple[dict[str, Any], dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Figures of one graph, each measure of its seams (at most so many), and of uncut motion there.

    ``uncut``: known already, of a graph with the same transitions.
    """
    around = room(graph)
    edges = seam_edges(graph, around)
    if most is not None and len(edges) > most:
        edges = np.sort(np.random.default_rng(0).permutation(edges)[:most])
    seams = _measured(graph, known, seam_pieces(graph, edges, around))
    uncut = uncut or _measured(graph, known, uncut_pieces(graph, edges, around))
    # A seam may be as jerky as the capture is here: no more of its windows above the quantile
    # than 0.5 %, or than the two clips have.
    own = uncut["jerky"].reshape(2, -1).max(axis=0)
    smooth = seams["jerky"] <= np.maximum(own, 0.005)
    solid = (seams["self_penetration"] <= DEPTH_M) & (seams["sink"] <= SINK_M + uncut["sink"].max())
    report = graph.report
    row: dict[str, Any] = {
        "threshold_m": report["threshold_m"],
        "transitions": report["transitions"],
        "seams": len(edges),
        "labels_kept": report["labels_kept"],
        "labels_enterable": report["labels_enterable"],
        "frames": int((graph.edge_frames * (graph.edge_clip >= 0)).sum()),
        "jerky": seams["jerky"].mean(),
        "jerky_uncut": uncut["jerky"].mean(),
        "contact_speed_mean": np.nanmean(seams["contact_speed"]),
        "contact_speed_mean_uncut": np.nanmean(uncut["contact_speed"]),
        "too_deep": int((seams["self_penetration"] > DEPTH_M).sum()),
        "deepest_m": seams["self_penetration"].max(),
        "smooth": smooth.mean(),
        "solid": solid.mean(),
        "good": (smooth & solid).mean(),
        "auc": {key: auc(uncut[key], seams[key]) for key in MEASURES},
    }
    for key in MEASURES:
        row[f"{key}_p50_p95"] = np.nanpercentile(seams[key], [50, 95])
        row[f"{key}_uncut_p50_p95"] = np.nanpercentile(uncut[key], [50, 95])
    row["best_auc"] = max(row["auc"].values())
    return row, seams | {"edges": edges}, uncut


def _worst(
    before: tuple[MotionGraph, dict[str, np.ndarray]],
    after: tuple[MotionGraph, dict[str, np.ndarray]],
    count: int,
) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """The seams that skate most before, as they are before and after."""
    values = before[1]
    chosen = np.argsort(-values["skate_cm"], kind="stable")[:count]
    tracks = [
        [
            np.asarray(global_positions(graph.skeleton, motion))
            for motion in seam_pieces(graph, measures["edges"][chosen], 4).motions
        ]
        for graph, measures in (before, after)
    ]
    return [
        (
            f"edge {values['edges'][i]}: skates {values['skate_cm'][i]:.2f},"
            f" then {after[1]['skate_cm'][i]:.2f} cm a frame",
            *pair,
        )
        for i, *pair in zip(chosen, *tracks, strict=True)
    ]


def _line(row: dict[str, Any]) -> str:
    best = max(row["auc"], key=row["auc"].get)
    condition = f", contacts {row['contacts']:g}" if "contacts" in row else ""
    skate, own = row["skate_cm_p50_p95"], row["skate_cm_uncut_p50_p95"]
    jump = row["velocity_jump_p50_p95"]
    return (
        f"{row['name']}{condition} at {row['threshold_m']:.3f} m: {row['transitions']} transitions,"
        f" {row['labels_kept']} labels ({row['labels_enterable']} enterable);"
        f" jerky {row['jerky']:.3%} (uncut {row['jerky_uncut']:.3%}),"
        f" velocity jump {jump[0]:.2f}/{jump[1]:.2f} m/s,"
        f" contact {row['contact_speed_mean']:.3f} (uncut {row['contact_speed_mean_uncut']:.3f})"
        f" m/s, skate {skate[0]:.2f}/{skate[1]:.2f} (uncut {own[0]:.2f}/{own[1]:.2f}) cm,"
        f" too deep {row['too_deep']} (up to {100 * row['deepest_m']:.1f} cm),"
        f" good {row['good']:.1%}, best AUC {row['best_auc']:.2f} ({best})"
    )


if __name__ == "__main__":
    experiment(run, Config)
