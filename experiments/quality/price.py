"""What seams of a graph cost (C6): goals G1 to G3, beside the uncut clips at the same places."""

from __future__ import annotations

import numpy as np

from experiments.quality.blends import DEPTH_M, SINK_M, captured_of
from experiments.quality.pieces import room, seam_edges, seam_pieces, uncut_pieces
from experiments.quality.verdicts import auc
from mgjax.graph.types import MotionGraph
from mgjax.quality.measuring import measure_many


def price_of(graph: MotionGraph, most: int) -> dict[str, float]:
    """Figures of at most so many transitions, drawn at random.

    G1: ``skate_ratio``, means of ``skate_cm`` and ``contact_speed``, each also ``_uncut``, and
    ``skate_auc``, how well sliding tells seams from uncut motion; G2: ``jerky``; G3: shares of
    seams that are ``sunk`` and ``too_deep``.
    """
    around = room(graph)
    edges = seam_edges(graph, around)
    if len(edges) > most:
        edges = np.sort(np.random.default_rng(0).permutation(edges)[:most])
    known = captured_of(graph)
    made, uncut = (
        measure_many(
            graph.skeleton, some.motions, against=known, spans_s=some.spans_s, rests=some.rests
        )[0]
        for some in (seam_pieces(graph, edges, around), uncut_pieces(graph, edges, around))
    )
    row: dict[str, float] = {"seams": len(edges)}
    for key in ("skate_ratio", "skate_cm", "contact_speed", "jerky"):
        row[key] = float(np.nanmean(made[key]))
        row[f"{key}_uncut"] = float(np.nanmean(uncut[key]))
    row["skate_auc"] = auc(uncut["skate_cm"], made["skate_cm"])
    row["sunk"] = float((made["sink"] > SINK_M + uncut["sink"].max()).mean())
    row["too_deep"] = float((made["self_penetration"] > DEPTH_M).mean())
    return row
