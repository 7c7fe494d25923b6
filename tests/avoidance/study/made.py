"""Trials whose measures are drawn, and observers who pick by known weights."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.study.format import FORMAT
from mgjax.avoidance.study.reading import MEASURES, Known, Pick, Study
from mgjax.avoidance.study.trials import LETTERS
from tests.reference.study import energy

TRUTH = {"w_a": 3.0, "w_b": 4.0, "w_m": 3.0, "w_t": 5.0, "E_avoidance": 0.008, "D_body": 0.25}
Measured = list[list[list[float]]]


def drawn_measures(trials: int, seed: int, *, most: int = 4) -> Measured:
    """Measures of two candidates and more a trial."""
    rng = np.random.default_rng(seed)
    sizes = rng.integers(2, most + 1, trials)
    sizes[0] = most
    return [
        [
            [
                float(rng.exponential(0.006) * (rng.random() < 0.8)),
                float(rng.uniform(0.0, 0.5)),
                float(rng.uniform(-0.2, 0.15)),
                float(rng.uniform(0.05, 0.6)),
                float(np.exp(rng.uniform(-0.6, 0.6))),
            ]
            for _ in range(size)
        ]
        for size in sizes
    ]


def energies(measured: Measured) -> list[np.ndarray]:
    """Under the known weights."""
    weights = [TRUTH[name] for name in ("w_a", "w_b", "w_m", "w_t")]
    return [
        np.array([energy(c, weights, TRUTH["E_avoidance"], TRUTH["D_body"]) for c in candidates])
        for candidates in measured
    ]


def picks_of(measured: Measured, seed: int, *, random: bool = False) -> list[int]:
    """What an observer picks by the known weights, or at random."""
    rng = np.random.default_rng(seed)
    picks: list[int] = []
    for e in energies(measured):
        share = np.exp(-(0 * e if random else e))
        picks.append(int(rng.choice(len(e), p=share / share.sum())))
    return picks


def study_of(measured: Measured, picks: dict[str, Sequence[int]]) -> Study:
    """A study whose search takes the first candidate of each trial."""
    trials = {
        str(number): Known(
            number=number,
            measures=tuple(map(tuple, candidates)),
            taken=0,
            settings=EnergyConfig(),
        )
        for number, candidates in enumerate(measured, 1)
    }
    every = [
        Pick(trial=str(number), observer=name, place=place)
        for name, places in picks.items()
        for number, place in enumerate(places, 1)
    ]
    return Study(trials=trials, picks=every)


def record_of(candidates: list[list[float]], number: int, *, scale: float = 1.0) -> dict[str, Any]:
    """A trial as an export has it, of a body of that scale."""
    rows: list[dict[str, Any]] = []
    for letter, values in zip(LETTERS, candidates, strict=False):
        found = dict(zip(MEASURES, values, strict=True))
        seconds = found.pop("s_time")
        sized = {name: scale * value for name, value in found.items()}
        rows.append({"letter": letter, "energy": sized, "time_scale": seconds})
    settings = asdict(EnergyConfig()) | {"T_window": 1.0}
    return {
        "trial": number,
        "body_scale": scale,
        "settings": settings,
        "candidates": rows,
        "library": "A",
    }


def key_text(measured: Measured, study: str = "one") -> str:
    """A key as an export writes it."""
    trials = [record_of(candidates, number) for number, candidates in enumerate(measured, 1)]
    return json.dumps({"format": FORMAT, "study": study, "trials": trials}) + "\n"


def picks_text(picks: Sequence[int], observer: str, study: str = "one") -> str:
    """A file of picks as the page saves it."""
    return "".join(
        json.dumps(
            {
                "format": FORMAT,
                "study": study,
                "trial": number,
                "observer": observer,
                "when": "2026-01-01T00:00:00Z",
                "pick": LETTERS[place],
            }
        )
        + "\n"
        for number, place in enumerate(picks, 1)
    )
