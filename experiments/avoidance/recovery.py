"""Whether walks are back in the graph soon after an attack, without a fault on the way."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from experiments.quality.blends import DEPTH_M, SINK_M
from experiments.quality.blends_measures import Tracks, capture_of, floors_of, measured
from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.selection import write
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.timing.walk_warps import natural_starts
from mgjax.core.kinematics import forward
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, extend, sample_walk

WITHIN_S = 1.0
"""How soon after the attack a walk has to be at a node, and how long it is looked at."""
_NEAR_S = 0.15
"""A standard ball has gone so soon after it is at the body's axis."""
_MARGIN = 2
_UNCUT = 400
"""Windows of uncut capture that are measured beside."""


class Recovery:
    """Measures of what follows attacks on a graph, beside uncut capture.

    Args:
        graph: the graph.
    """

    def __init__(self, graph: MotionGraph) -> None:
        self._graph = graph
        self._capture = capture_of(graph)
        self._floors = floors_of(graph)
        self.uncut = lru_cache(self._uncut)

    def of(
        self,
        prepared: Prepared,
        asked: list[tuple[int, Attack]],
        arrives: float,
        search: AvoidanceConfig,
    ) -> dict[str, Any]:
        """How many of some avoided attacks recover, and the shares without each fault.

        Args:
            prepared: of the graph.
            asked: node and attack of each.
            arrives: when they are at the body's axis, s.
            search: settings.
        """
        count = math.ceil((arrives + _NEAR_S + WITHIN_S) * self._graph.frame_rate) + 1
        played = [self._played(prepared, node, attack, search, count) for node, attack in asked]
        uncut = self.uncut(count)
        found: dict[str, Any] = {f"uncut_{k}": float(v.mean()) for k, v in uncut["ok"].items()}
        if not played:
            nothing = dict.fromkeys(("at_a_node", *uncut["ok"]), math.nan)
            return {"recovered": 0, "back_s_p50_p95": None} | nothing | found
        back = np.array([one[2] for one in played])
        places, floors = (np.stack([one[k] for one in played]) for k in (0, 1))
        ok = self._without(places, floors, uncut["limits"])
        soon = back <= WITHIN_S
        return {
            "recovered": int((soon & ok["without_fault"]).sum()),
            "at_a_node": float(soon.mean()),
            "back_s_p50_p95": np.percentile(back, [50, 95]).tolist(),
            **{key: float(values.mean()) for key, values in ok.items()},
            **found,
        }

    def _played(
        self, prepared: Prepared, node: int, attack: Attack, search: AvoidanceConfig, count: int
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Joint positions at the graph's rate, floors, and when a node comes after the attack."""
        graph = self._graph
        choice = choose(prepared, node, attack, config=search)
        assert choice.status == Status.AVOIDED, "what is asked was avoided"
        assert choice.crop is not None
        written = write(prepared, attack, choice, search)
        seconds = (count - 1) / graph.frame_rate
        beyond = float(written.timing.at(np.array([seconds]))[0])
        captured = Walk(edges=written.walk.edges, scales=np.ones(len(written.walk.edges)))
        captured = extend(graph, captured, beyond)
        nodes = written.timing.when(natural_starts(graph, captured))
        back = nodes[nodes >= choice.crop.end - 1e-6]
        times = written.timing.at(np.arange(count) / graph.frame_rate)
        motion = sample_walk(graph, captured, times)
        places, _ = forward(graph.skeleton, motion.root_translation, motion.local_rotations)
        clips = np.unique(graph.node_clip[graph.edge_source[captured.edges]])
        soonest = float(back[0]) - choice.crop.end if len(back) else math.inf
        return np.asarray(places), self._floors[clips].max(axis=0), soonest

    def _uncut(self, count: int) -> dict[str, Any]:
        """Windows of the capture, drawn at random: what they pass, and the limits they set."""
        graph = self._graph
        starts = [
            np.arange(a, b - count)
            for a, b in zip(graph.clip_starts, graph.clip_stops, strict=True)
            if b - a > count
        ]
        assert starts, "no clip is long enough"
        every = np.concatenate(starts)
        chosen = np.random.default_rng(0).choice(every, min(_UNCUT, len(every)), replace=False)
        clip = np.searchsorted(graph.clip_starts, chosen, side="right") - 1
        places = graph.positions[chosen[:, None] + np.arange(count)]
        values = self._values(places, self._floors[clip])
        limits = {
            key: 1.1 * float(np.percentile(values[key], 95))
            for key in ("skate_cm", "contact_speed")
        }
        limits["sink"] = SINK_M + float(values["sink"].max())
        return {"limits": limits, "ok": _judged(values, limits)}

    def _without(
        self, places: np.ndarray, floors: np.ndarray, limits: dict[str, float]
    ) -> dict[str, np.ndarray]:
        return _judged(self._values(places, floors), limits)

    def _values(self, places: np.ndarray, floors: np.ndarray) -> dict[str, np.ndarray]:
        tracks = Tracks(
            places=places, floors=floors, first=_MARGIN, last=places.shape[1] - 1 - _MARGIN
        )
        return measured(self._graph, tracks, self._capture)


def _judged(values: dict[str, np.ndarray], limits: dict[str, float]) -> dict[str, np.ndarray]:
    """Which tracks have no fault of feet (G1), of smoothness (G2), of depth (G3), and none."""
    feet = values["skate_cm"] <= limits["skate_cm"]
    feet &= values["contact_speed"] <= limits["contact_speed"]
    smooth = values["jerky"] <= 0.005
    solid = (values["depth"] <= DEPTH_M) & (values["sink"] <= limits["sink"])
    return {
        "feet": feet,
        "smooth": smooth,
        "solid": solid,
        "without_fault": feet & smooth & solid,
    }
