"""Whether walks are back in the graph soon after an attack, without a fault on the way."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from experiments.quality.blends import DEPTH_M, SINK_M
from experiments.quality.blends_measures import (
    SKATE_M,
    Tracks,
    capture_of,
    feet_of,
    floors_of,
    measured,
)
from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.selection import write
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.timing.walk_warps import natural_starts
from mgjax.core.kinematics import forward
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, extend, frames_at, sample_walk

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
        values = self._values(places, floors)
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
        edges = captured.edges[frames_at(graph, captured, times).edge_low]
        # A transition has the floors of both clips; the higher counts, as it does for seams.
        ends = [graph.node_clip[nodes[edges]] for nodes in (graph.edge_source, graph.edge_target)]
        floors = np.maximum(self._floors[ends[0]], self._floors[ends[1]])
        soonest = float(back[0]) - choice.crop.end if len(back) else math.inf
        return np.asarray(places), floors, soonest

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
        floors = np.repeat(self._floors[clip][:, None], count, axis=1)
        values = self._values(places, floors)
        limits = {
            key: 1.1 * float(np.percentile(values[key], 95))
            for key in ("skate_cm", "contact_speed")
        }
        limits["sink"] = SINK_M + float(values["sink"].max())
        return {"limits": limits, "ok": _judged(values, limits), "spread": _spread(values)}

    def _values(self, places: np.ndarray, floors: np.ndarray) -> dict[str, np.ndarray]:
        first, last = _MARGIN, places.shape[1] - 1 - _MARGIN
        tracks = Tracks(places=places, floors=floors.max(axis=1), first=first, last=last)
        values = measured(self._graph, tracks, self._capture)
        # These two by the floor of the clip that is played at each moment.
        feet = places[:, first : last + 1][:, :, feet_of(self._graph)]
        above = feet[..., 1] - floors[:, first : last + 1]
        slide = np.linalg.norm(np.diff(feet, axis=1)[..., [0, 2]], axis=-1)
        height = np.maximum(above[:, :-1], 0.0)
        slide *= np.where(height < SKATE_M, 2 - 2 ** (height / SKATE_M), 0.0)
        return values | {
            "skate_cm": 100 * slide.mean(axis=(1, 2)),
            "sink": np.maximum(-above, 0.0).max(axis=(1, 2)),
        }


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


def _spread(values: dict[str, np.ndarray]) -> dict[str, list[float]]:
    """Median and 95th percentile of each measure that sets a limit."""
    keys = ("skate_cm", "contact_speed", "jerky", "depth", "sink")
    return {key: np.percentile(values[key], [50, 95]).tolist() for key in keys}
