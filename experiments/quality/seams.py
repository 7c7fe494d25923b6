"""How good seams and answers are: all transitions and chosen walks beside uncut motion.

    python -m experiments.quality.seams --set clips=FOLDER --out out/quality/seams

Without clips it uses the embedded ones. Walks are answers to standard balls, as they are written.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from experiments.avoidance.graphs import EMBEDDED_M, clips_of
from experiments.avoidance.throws import standard_throws
from experiments.quality.pieces import (
    Pieces,
    clip_motions,
    random_pieces,
    room,
    seam_edges,
    seam_pieces,
    uncut_pieces,
)
from experiments.quality.strips import Strip, strips_figure
from experiments.quality.verdicts import line_of, row_of
from mgjax.avoidance.choice.selection import Selection, select
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared, prepare
from mgjax.avoidance.timing.walk_warps import natural_starts
from mgjax.core.errors import AttackError
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.quality.known import Captured, captured
from mgjax.quality.measuring import measure_many
from mgjax.runs.experiment import Results, experiment

WORST = ("skate_cm", "jerk_ratio", "velocity_jump", "sink", "self_penetration", "limits")
"""Measures by which the worst seams are found: by how much they exceed what uncut motion does."""
LEAST = {"sink": 0.005, "self_penetration": 0.01, "limits": 5.0}


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is measured."""

    clips: str = ""
    """Folder of clips with labels.json; empty: the embedded clips."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Patterns of clips that are left out."""
    graph: GraphConfig = field(default_factory=GraphConfig)
    """How the graph is built; the embedded clips at their own threshold."""
    avoidance: AvoidanceConfig = field(default_factory=AvoidanceConfig)
    """How walks are chosen."""
    transitions: int = 0
    """Transitions that are measured, drawn at random; 0: all."""
    walks: int = 1000
    """Standard balls that are answered."""
    strips: int = 10
    """Worst transitions that are drawn."""
    seed: int = 0
    """Draws balls and uncut motion."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "clips": "",
            "transitions": 40,
            "walks": 3,
            "strips": 1,
            "avoidance.checks": 4,
            "avoidance.capacity": 64,
        }


def run(config: Config) -> Results:
    """Measures transitions, walks, and the seams in the walks."""
    clips, labels = clips_of(config.clips, config.exclude)
    settings = config.graph
    if not config.clips and settings.threshold_m is None:
        settings = GraphConfig(**{**vars(settings), "threshold_m": EMBEDDED_M})
    graph = build_graph(clips, labels=labels, config=settings)
    known = captured([(graph.skeleton, motion) for motion in clip_motions(graph)])
    edges, rows, strips = _transitions(config, graph, known)
    chosen = answers(prepare(graph, config.avoidance), graph, config)
    rows += _walks(config, graph, known, chosen)
    metrics = {
        "threshold_m": graph.report["threshold_m"],
        "transitions": graph.report["transitions"],
        "measured": len(edges),
        "walks": len(chosen),
        "avoided": sum(selection.status == "avoided" for selection in chosen),
        "rows": rows,
        "worst": [strip.title for strip in strips],
    }
    return Results(
        metrics=metrics,
        figures={"worst": lambda: strips_figure(graph.skeleton, strips)},
        lines=tuple(line for row in rows for line in line_of(row)),
    )


def answers(prepared: Prepared, graph: MotionGraph, config: Config) -> list[Selection]:
    """What is chosen for each ball that begins outside of the body and has a candidate."""
    throws = standard_throws(config.walks, config.seed)
    found: list[Selection] = []
    for number in range(len(throws)):
        node = throws.node_of(number, graph)
        try:
            answer = select(prepared, node, throws.attack(number), config=config.avoidance)
        except AttackError:
            continue
        if answer.part is not None:
            found.append(answer)
    return found


def seams_in(graph: MotionGraph, selection: Selection) -> list[tuple[float, float]]:
    """First and last second of the transitions that lie in the written motion."""
    starts = selection.timing.when(natural_starts(graph, selection.walk))
    blended = graph.edge_clip[selection.walk.edges] == NO_CLIP
    end = (selection.motion.num_frames - 1) / selection.motion.frame_rate
    spans = zip(starts[:-1], starts[1:], strict=True)
    return [
        (float(a), float(b))
        for blend, (a, b) in zip(blended, spans, strict=True)
        if blend and b <= end
    ]


def _transitions(
    config: Config, graph: MotionGraph, known: Captured
) -> tuple[np.ndarray, list[dict[str, Any]], list[Strip]]:
    around = room(graph)
    edges = seam_edges(graph, around)
    if config.transitions:
        rng = np.random.default_rng(config.seed)
        edges = np.sort(rng.permutation(edges)[: config.transitions])
    pieces = seam_pieces(graph, edges, around)
    made = _measured(graph, known, pieces)
    uncut = _measured(graph, known, uncut_pieces(graph, edges, around))
    strips = _worst(config, graph, edges, pieces, made[0], uncut[0])
    return edges, [row_of("transitions", made, uncut)], strips


def _walks(
    config: Config, graph: MotionGraph, known: Captured, chosen: list[Selection]
) -> list[dict[str, Any]]:
    """Whole answers, and the seams in them, beside uncut motion of the same lengths."""
    seconds = [selection.motion.seconds for selection in chosen]
    uncut = random_pieces(graph, seconds, config.seed)
    walks = [selection.motion for selection in chosen]
    rows = [
        row_of(
            "walks",
            _measured(graph, known, Pieces(motions=walks)),
            _measured(graph, known, Pieces(motions=uncut)),
        )
    ]
    seams = [(i, span) for i, answer in enumerate(chosen) for span in seams_in(graph, answer)]
    if seams:
        spans = [span for _, span in seams]
        both = (
            Pieces(motions=[motions[i] for i, _ in seams], spans_s=spans)
            for motions in (walks, uncut)
        )
        rows.append(row_of("seams in walks", *(_measured(graph, known, p) for p in both)))
    return rows


def _measured(
    graph: MotionGraph, known: Captured, pieces: Pieces
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    return measure_many(
        graph.skeleton,
        pieces.motions,
        against=known,
        spans_s=pieces.spans_s,
        rests=pieces.rests,
    )


def _worst(
    config: Config,
    graph: MotionGraph,
    edges: np.ndarray,
    pieces: Pieces,
    made: dict[str, np.ndarray],
    uncut: dict[str, np.ndarray],
) -> list[Strip]:
    """The seams that exceed most what 99 % of uncut pieces do, in whatever measure."""
    usual = {
        key: max(float(np.nanquantile(uncut[key], 0.99)), LEAST.get(key, 1e-6)) for key in WORST
    }
    times = np.stack([np.nan_to_num(made[key]) / usual[key] for key in WORST])
    order = np.argsort(-times.max(axis=0), kind="stable")[: config.strips]
    strips: list[Strip] = []
    for row in order.tolist():
        key = WORST[int(np.argmax(times[:, row]))]
        ends = (graph.edge_source[edges[row]], graph.edge_target[edges[row]])
        names = " > ".join(graph.clip_names[int(graph.node_clip[node])] for node in ends)
        title = (
            f"edge {edges[row]}, {names}: {key} {made[key][row]:.3g},"
            f" {times[:, row].max():.1f} × the 99 % of uncut"
        )
        span = (0.0, 0.0) if pieces.spans_s is None else pieces.spans_s[row]
        strips.append(Strip(title=title, motion=pieces.motions[row], seam_s=span))
    return strips


if __name__ == "__main__":
    experiment(run, Config)
