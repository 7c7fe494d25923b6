"""Trials of the observer study (§6.1): attacks with several ways out, in random order."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.choice.explain import Explained, explain
from mgjax.avoidance.choice.results import Choice, Status
from mgjax.avoidance.choice.selection import Selection, write
from mgjax.avoidance.choice.start import ask
from mgjax.avoidance.config import ARRIVALS_S, HEIGHTS_M, AvoidanceConfig
from mgjax.avoidance.coverage.throws import DISTANCE_M
from mgjax.avoidance.prepared import Prepared
from mgjax.core.errors import GraphError
from mgjax.core.ranges import check_range

LETTERS = "ABCDEFGH"
"""Names of candidates in the order in which they stand."""
MOST_TRIALS = 1000
CHECKED = 48
"""Candidates of an attack that are checked exactly."""
PATIENCE = 30
"""Throws a trial, at most, until so many have several ways out."""

T = TypeVar("T")


@dataclass(frozen=True, kw_only=True, eq=False)
class Way:
    """A candidate that is clear as it is written: what it is worth, and its motion."""

    row: Explained
    selection: Selection


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """An attack, and its ways out in the order in which they stand.

    Attributes:
        number: from 1.
        node: where the character stands.
        attack: in the planar frame of the body there.
        ways: two or more, of different avoidance parts.
        taken: place of the one that the search takes.
    """

    number: int
    node: int
    attack: Attack
    ways: list[Way]
    taken: int


def different_parts(rows: Iterable[Explained]) -> list[Explained]:
    """Of the clear candidates the best of each avoidance part, in the order of their energy."""
    best: dict[int, Explained] = {}
    for row in rows:
        if row.outcome == "clear":
            best.setdefault(row.part, row)
    return list(best.values())


def shuffled(
    ways: list[T], rng: np.random.Generator, most: int, *, best: bool
) -> tuple[list[T], int]:
    """At most so many ways out in random order, and where the first of them stands now.

    Args:
        ways: in the order of their energy.
        rng: draws.
        most: the first stays in any case.
        best: the next in order stay, too; else which others do is drawn, so that picks tell of bad
            ways as well.
    """
    others = np.arange(1, len(ways))
    if not best and len(ways) > most:
        others = rng.permutation(others)
    kept = rng.permutation([0, *others[: most - 1].tolist()]).tolist()
    return [ways[i] for i in kept], kept.index(0)


def make_trials(
    prepared: Prepared,
    count: int,
    *,
    config: AvoidanceConfig,
    seed: int = 0,
    most: int = 4,
) -> list[Trial]:
    """Balls at random nodes, from random sides, each with several ways out.

    A ball comes straight, at 10 m/s, at one of the standard heights and times. Ways out are clear
    as written, each of another avoidance part; they are shown as the search would play them. One is
    what the search takes, the others are drawn where there are more.

    Args:
        prepared: of a graph with labelled avoidance parts.
        count: trials, 1 … 1000.
        config: settings of the search; near misses are not refined.
        seed: draws all.
        most: ways out of a trial, 2 … 8.

    Raises:
        ConfigError: a number out of range.
        GraphError: no avoidance parts, or hardly any ball has two ways out.
    """
    check_range("trials", count, 1, MOST_TRIALS, whole=True)
    check_range("candidates", most, 2, len(LETTERS), whole=True)
    check_range("seed", seed, 0, 2**63 - 1, whole=True)
    graph = prepared.graph
    if not len(graph.label_edge):
        raise GraphError(got="a graph without avoidance parts", expected="one built with labels")
    rng = np.random.default_rng(seed)
    trials: list[Trial] = []
    for _ in range(PATIENCE * count):
        node = int(rng.integers(graph.num_nodes))
        attack = ball_from(
            float(rng.uniform(0, 2 * np.pi)),
            graph.body_scale * float(rng.choice(HEIGHTS_M)),
            distance=DISTANCE_M,
            arrives=float(rng.choice(ARRIVALS_S)),
        )
        ways = ways_out(prepared, node, attack, config)
        if len(ways) < 2:
            continue
        shown, taken = shuffled(ways, rng, most, best=False)
        number = len(trials) + 1
        trials.append(Trial(number=number, node=node, attack=attack, ways=shown, taken=taken))
        if number == count:
            return trials
    raise GraphError(
        got=f"a graph in which {len(trials)} of {PATIENCE * count} balls have several ways out",
        expected=f"{count}: fewer trials, or more avoidance parts",
    )


def ways_out(prepared: Prepared, node: int, attack: Attack, config: AvoidanceConfig) -> list[Way]:
    """Candidates of different parts that are clear as written, the one that is taken first."""
    rows = explain(prepared, node, attack, config=config, checked=CHECKED)
    clear = different_parts(rows)
    if len(clear) < 2:
        return []
    query = ask(prepared, node, attack, config)
    assert query is not None, "there are candidates"
    ways = (_way(prepared, node, attack, row, query.crop, config) for row in clear)
    return [way for way in ways if way.selection.status == Status.AVOIDED]


def _way(
    prepared: Prepared,
    node: int,
    attack: Attack,
    row: Explained,
    crop: Crop,
    config: AvoidanceConfig,
) -> Way:
    choice = Choice(
        status=Status.AVOIDED,
        node=node,
        walk=row.walk,
        path_length=row.path_length,
        part=row.part,
        time_scale=row.time_scale,
        energy=row.energy,
        clearance_m=row.clearance_m,
        crop=crop,
    )
    return Way(row=row, selection=write(prepared, attack, choice, config))
