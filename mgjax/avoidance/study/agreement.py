"""How often picks agree with the search and with one another, beside what chance would give."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from mgjax.avoidance.coverage.shares import interval
from mgjax.avoidance.study.reading import Pick, Study


def with_search(study: Study, picks: list[Pick]) -> dict[str, Any]:
    """Share of picks that are what the search took.

    ``chance`` is what random picks would agree. The 95 % interval (Wilson) is that of as many
    independent picks as there are trials: several observers of a trial see the same candidates.
    """
    known = [study.trials[pick.trial] for pick in picks]
    same = [pick.place == trial.taken for pick, trial in zip(picks, known, strict=True)]
    count = len({pick.trial for pick in picks})
    share = float(np.mean(same))
    return {
        "picks": len(picks),
        "trials": count,
        "agree": int(sum(same)),
        "share": round(share, 4),
        "interval": interval(share, count),
        "chance": round(float(np.mean([1 / len(trial.measures) for trial in known])), 4),
    }


def by_observer(study: Study) -> dict[str, dict[str, Any]]:
    """:func:`with_search` of each observer."""
    names = sorted({pick.observer for pick in study.picks})
    return {
        name: with_search(study, [pick for pick in study.picks if pick.observer == name])
        for name in names
    }


def between_observers(study: Study) -> dict[str, Any] | None:
    """How often observers of the same trials agree; None where no trial has two.

    A pair of observers: the share of the trials that both saw in which they picked the same.
    Altogether: the mean over trials of the share of pairs that agree. ``kappa`` is
    (share − chance)/(1 − chance), where chance is that of random picks (Brennan & Prediger 1981):
    letters are drawn anew for each trial, so how often each is picked says nothing.
    """
    seen: dict[str, dict[str, int]] = {}
    for pick in study.picks:
        seen.setdefault(pick.trial, {})[pick.observer] = pick.place
    shared = {name: places for name, places in seen.items() if len(places) > 1}
    if not shared:
        return None
    shares = [
        float(np.mean([a == b for a, b in combinations(places.values(), 2)]))
        for places in shared.values()
    ]
    chances = [1 / len(study.trials[name].measures) for name in shared]
    pairs: list[dict[str, Any]] = []
    for one, other in combinations(sorted({pick.observer for pick in study.picks}), 2):
        both = [name for name, places in shared.items() if one in places and other in places]
        if both:
            same = [shared[name][one] == shared[name][other] for name in both]
            chance = [1 / len(study.trials[name].measures) for name in both]
            pairs.append({"observers": [one, other]} | _corrected(same, chance))
    return _corrected(shares, chances) | {"pairs": pairs}


def _corrected(same: list[float] | list[bool], chances: list[float]) -> dict[str, Any]:
    share, chance = float(np.mean(same)), float(np.mean(chances))
    return {
        "trials": len(same),
        "share": round(share, 4),
        "interval": interval(share, len(same)),
        "kappa": round((share - chance) / (1 - chance), 4),
    }
