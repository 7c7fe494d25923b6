"""Whether answers are back in the graph soon after an attack, without a fault on the way."""

from __future__ import annotations

import math
from functools import lru_cache, partial
from typing import Any

import numpy as np

from experiments.quality.blends import DEPTH_M, SINK_M, captured_of
from experiments.quality.pieces import random_pieces
from mgjax.avoidance.checks.written import WrittenWalk, write_walk
from mgjax.avoidance.choice.selection import Selection
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.refinement.refine import change_written
from mgjax.avoidance.timing.walk_warps import natural_starts
from mgjax.core.motion import Motion
from mgjax.quality.measuring import measure_many

WITHIN_S = 1.0
"""How soon after the attack a walk has to be at a node, and how long it is looked at."""
_NEAR_S = 0.15
"""A standard ball has gone so soon after it is at the body's axis."""
_UNCUT = 400
"""Pieces of uncut capture that are measured beside."""
_LENIENCE = 1.1
_JERKY = 0.005


class Recovery:
    """Measures of what follows attacks on a graph, as it is written, beside uncut capture.

    Args:
        prepared: of the graph.
    """

    def __init__(self, prepared: Prepared) -> None:
        self._prepared = prepared
        self._captured = captured_of(prepared.graph)
        self.uncut = lru_cache(self._uncut)

    def of(self, answers: list[Selection], arrives: float) -> dict[str, Any]:
        """How many of some answers that avoid recover, and the shares without each fault.

        Args:
            answers: to attacks that are all at the body's axis at the same time.
            arrives: that time, s.
        """
        seconds = arrives + _NEAR_S + WITHIN_S
        uncut = self.uncut(seconds)
        found: dict[str, Any] = {f"uncut_{k}": float(v.mean()) for k, v in uncut["ok"].items()}
        if not answers:
            nothing = dict.fromkeys(("at_a_node", *uncut["ok"]), math.nan)
            return {"recovered": 0, "back_s_p50_p95": None} | nothing | found
        written = [self._played_on(answer, seconds) for answer in answers]
        back = np.array([self._back(*both) for both in zip(answers, written, strict=True)])
        values = self._measured([one.motion for one in written])
        ok = _judged(values, uncut["limits"])
        soon = back <= WITHIN_S
        return {
            "recovered": int((soon & ok["without_fault"]).sum()),
            "at_a_node": float(soon.mean()),
            "back_s_p50_p95": np.percentile(back, [50, 95]).tolist(),
            **{key: float(passed.mean()) for key, passed in ok.items()},
            "measured_p50_p95": _spread(values),
            "uncut_p50_p95": uncut["spread"],
            **found,
        }

    def _played_on(self, answer: Selection, seconds: float) -> WrittenWalk:
        """The motion of an answer, as it was written and then played on."""
        graph, change = self._prepared.graph, None
        if answer.refinement is not None:
            change = partial(change_written, graph, answer.refinement)
        spheres = self._prepared.tables.spheres
        return write_walk(graph, spheres, answer.walk, seconds, answer.timing, None, change=change)

    def _back(self, answer: Selection, written: WrittenWalk) -> float:
        """When the first node comes after the attack, s."""
        assert answer.crop is not None, "what avoids was near"
        nodes = answer.timing.when(natural_starts(self._prepared.graph, written.walk))
        later = nodes[nodes >= answer.crop.end - 1e-6]
        return float(later[0]) - answer.crop.end if len(later) else math.inf

    def _uncut(self, seconds: float) -> dict[str, Any]:
        """Pieces of the capture, drawn at random: what they pass, and the limits they set."""
        values = self._measured(random_pieces(self._prepared.graph, [seconds] * _UNCUT, 0))
        limits = {
            key: _LENIENCE * float(np.nanpercentile(values[key], 95))
            for key in ("skate_cm", "contact_speed")
        }
        limits["sink"] = SINK_M + float(values["sink"].max())
        return {"limits": limits, "ok": _judged(values, limits), "spread": _spread(values)}

    def _measured(self, motions: list[Motion]) -> dict[str, np.ndarray]:
        skeleton = self._prepared.graph.skeleton
        return measure_many(skeleton, motions, against=self._captured)[0]


def _judged(values: dict[str, np.ndarray], limits: dict[str, float]) -> dict[str, np.ndarray]:
    """Which motions have no fault of feet (G1), of smoothness (G2), of depth (G3), and none."""
    feet = values["skate_cm"] <= limits["skate_cm"]
    feet &= ~(values["contact_speed"] > limits["contact_speed"])  # NaN: no foot is down
    smooth = values["jerky"] <= _JERKY
    solid = (values["self_penetration"] <= DEPTH_M) & (values["sink"] <= limits["sink"])
    return {
        "feet": feet,
        "smooth": smooth,
        "solid": solid,
        "without_fault": feet & smooth & solid,
    }


def _spread(values: dict[str, np.ndarray]) -> dict[str, list[float]]:
    """Median and 95th percentile of each measure that sets a limit."""
    keys = ("skate_cm", "contact_speed", "jerky", "self_penetration", "sink")
    return {key: np.nanpercentile(values[key], [50, 95]).tolist() for key in keys}
