"""Shares of the attacks of a coverage, how sure they are, and the cells served worst."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.coverage.throws import Coverage


def shares(result: Coverage, mask: Bool[np.ndarray, " B"]) -> dict[str, Any]:
    """What became of some attacks.

    ``no_time_scale`` is the part of ``no_candidate`` in which walks satisfy eq. 1 but none can be
    scaled to meet the attack. The interval allows for attacks at one node having like outcomes.
    """
    count = int(mask.sum())
    status = result.answers.status[mask]
    avoided = int((status == Status.AVOIDED.code).sum())
    unscaled = (status == Status.NO_CANDIDATE.code) & (result.answers.candidates[mask] > 0)
    numbers = {
        "avoided": avoided,
        "hit": int((status == Status.HIT.code).sum()),
        "no_candidate": int((status == Status.NO_CANDIDATE.code).sum()),
        "parried": int((status == Status.PARRIED.code).sum()),
        "no_time_scale": int(unscaled.sum()),
    }
    kinds = np.bincount(result.kind[mask] + 1, minlength=len(result.kinds) + 1)[1:]
    return {
        "attacks": count,
        **{name: round(number / count, 4) for name, number in numbers.items()},
        "avoided_interval": interval(avoided / count, _independent(result, mask)),
        "kinds": {
            kind: round(int(n) / count, 4) for kind, n in zip(result.kinds, kinds, strict=True)
        },
    }


def interval(share: float, count: float) -> list[float]:
    """The 95 % interval of a share of ``count`` independent outcomes (Wilson's score interval)."""
    z = 1.959964
    middle = share + z * z / (2 * count)
    half = z * np.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    ends = np.array([middle - half, middle + half]) / (1 + z * z / count)
    return np.clip(ends, 0.0, 1.0).round(4).tolist()


def _independent(result: Coverage, mask: Bool[np.ndarray, " B"]) -> float:
    """How many independent attacks would say as much: their number by Kish's design effect.

    That is the variance of the share with whole nodes drawn, over that with attacks drawn. Where
    all have the same outcome it is unknown, and only the nodes count.
    """
    _, place = np.unique(result.node[mask], return_inverse=True)
    avoided = (result.answers.status[mask] == Status.AVOIDED.code).astype(np.float64)
    count, nodes, share = len(avoided), int(place.max()) + 1, float(avoided.mean())
    if nodes == 1 or share in (0.0, 1.0):
        return float(nodes)
    together = np.square(np.bincount(place, weights=avoided - share)).sum() * nodes / (nodes - 1)
    return count / max(together / (count * share * (1 - share)), 1.0)


def outcomes(result: Coverage) -> dict[str, Bool[np.ndarray, " B"]]:
    """Which attacks were avoided, hit, had no candidate or were parried, and by which kind."""
    status = result.answers.status
    named = {"avoided": status == Status.AVOIDED.code, "hit": status == Status.HIT.code}
    named["no_candidate"] = status == Status.NO_CANDIDATE.code
    named["parried"] = status == Status.PARRIED.code
    return named | {f"kind/{kind}": result.kind == i for i, kind in enumerate(result.kinds)}


def cells(result: Coverage, mask: Bool[np.ndarray, " B"]) -> Float[np.ndarray, "D H"]:
    """Share of the attacks of each direction and height that are of a kind; NaN of none."""
    thrown, counted = _count(result, np.ones_like(mask)), _count(result, mask)
    return np.divide(counted, thrown, out=np.full(thrown.shape, np.nan), where=thrown > 0)


def worst_cells(result: Coverage, most: int = 8) -> list[tuple[int, int]]:
    """Directions and heights served worst, worst first.

    Only those count whose whole 95 % interval lies below the share of all attacks, so that a cell
    is not named for having had bad luck with its nodes.
    """
    avoided = result.answers.status == Status.AVOIDED.code
    share = cells(result, avoided)
    thrown, counted = _count(result, np.ones_like(avoided)), _count(result, avoided)
    order = np.argsort(share, axis=None, kind="stable")  # NaN last
    worst: list[tuple[int, int]] = []
    for place in zip(*np.unravel_index(order, share.shape), strict=True):
        number = int(thrown[place])
        if number and interval(float(counted[place]) / number, number)[1] < avoided.mean():
            worst.append((int(place[0]), int(place[1])))
    return worst[:most]


def _count(result: Coverage, mask: Bool[np.ndarray, " B"]) -> Int[np.ndarray, "D H"]:
    counts = np.zeros((len(result.directions), len(result.heights)), dtype=np.int64)
    np.add.at(counts, (result.direction[mask], result.height[mask]), 1)
    return counts
