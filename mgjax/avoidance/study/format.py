"""The study's files: what is known of trials, and what observers picked.

A trial is one JSON object, which observers do not see:

    {"trial": 3, "node": 17,
     "attack": {"radii", "times", "centres"},       as an attack's JSON file has it
     "body_scale": 1.02, "settings": {"form", "d0", "E_avoidance", "D_body", …, "T_window"},
     "candidates": [{"letter": "A", "edges", "scales", "part", "kind", "clearance_m", "energy": {
                     "total", "avoidance", "body", "movement", "timescale", "penetration", "d",
                     "d0", "displacement"}, "time_scale"}],     in the order in which they stood
     "library": "B"}

A key has those of a whole study, ``{"format": "mgjax-study-2", "study": "9f…", "trials": […]}``. A
pick is one JSON object on a line:

    {"format": "mgjax-study-2", "study": "9f…", "trial": 3, "observer": "A", "when": "2026-…",
     "pick": "A"}

Those of the live page, which has no key, have the whole trial in place of ``study``.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.explain import Explained
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.study.trials import LETTERS, Trial
from mgjax.graph.types import MotionGraph

FORMAT = "mgjax-study-2"


def trial_json(
    graph: MotionGraph,
    config: AvoidanceConfig,
    *,
    number: int,
    node: int,
    attack: Attack,
    rows: Sequence[Explained],
    taken: int,
) -> dict[str, Any]:
    """A trial as JSON values.

    Args:
        graph, config: what was searched, and how.
        number: of the trial.
        node, attack: what was asked.
        rows: candidates in the order in which they stood.
        taken: place of the one that the search takes.
    """
    settings: dict[str, Any] = {
        f.name: v if isinstance(v := getattr(config.energy, f.name), str) else float(v)
        for f in dataclasses.fields(config.energy)
    }
    return {
        "trial": number,
        "node": node,
        "attack": attack_json(attack),
        "body_scale": float(graph.body_scale),
        "settings": settings | {"T_window": config.T_window},
        "candidates": [_candidate(graph, place, row) for place, row in enumerate(rows)],
        "library": LETTERS[taken],
    }


def attack_json(attack: Attack) -> dict[str, Any]:
    """An attack as :func:`mgjax.avoidance.load_attack` reads it."""
    return {
        "radii": attack.radii.tolist(),
        "times": attack.times.tolist(),
        "centres": attack.centres.tolist(),
    }


def _candidate(graph: MotionGraph, place: int, row: Explained) -> dict[str, Any]:
    assert row.energy is not None, "only candidates that can be timed are clear"
    kind = f"{graph.label_kind[row.part]} {graph.label_direction[row.part]}"
    return {
        "letter": LETTERS[place],
        "edges": row.walk.edges[: row.path_length].tolist(),
        "scales": row.walk.scales[: row.path_length].tolist(),
        "part": row.part,
        "kind": kind.strip().replace("_", " "),
        "clearance_m": row.clearance_m,
        "energy": dataclasses.asdict(row.energy),
        "time_scale": row.time_scale,
    }


def key_json(
    graph: MotionGraph, config: AvoidanceConfig, trials: Sequence[Trial]
) -> dict[str, Any]:
    """The key of a study; its name follows from what is in it."""
    every = [
        trial_json(
            graph,
            config,
            number=trial.number,
            node=trial.node,
            attack=trial.attack,
            rows=[way.row for way in trial.ways],
            taken=trial.taken,
        )
        for trial in trials
    ]
    return {"format": FORMAT, "study": digest(every), "trials": every}


def digest(value: Any) -> str:
    """A short name for a JSON value that no other value has."""
    text = json.dumps(value, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def pick_line(trial: dict[str, Any], pick: str, observer: str) -> str:
    """A pick with its whole trial as a line of a file."""
    record = {
        "format": FORMAT,
        "observer": observer,
        "when": datetime.now(UTC).isoformat(timespec="seconds"),
        **trial,
        "pick": pick,
    }
    return json.dumps(record, allow_nan=False)
