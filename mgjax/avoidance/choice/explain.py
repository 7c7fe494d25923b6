"""All candidates of an attack, with what each is worth and why it was taken or not."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from typing import Any, Literal

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.checks.written import walk_motion
from mgjax.avoidance.choice.choosing import query_decided
from mgjax.avoidance.choice.search import STATUS, search_candidates
from mgjax.avoidance.choice.start import ask
from mgjax.avoidance.choice.verify import bounded, bounds_of, verify
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.energy.score import ROWS, Energy
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.avoidance.timing.time_scale import NOT_ADJUSTABLE, OK
from mgjax.core.motion import Motion
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, extend, make_walk

Outcome = Literal["clear", "hit", "not adjustable", "time scale", "unchecked"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Explained:
    """A candidate and its fate.

    Attributes:
        number: among the candidates that satisfy eq. 1, from 0.
        rank: place in the order in which candidates are checked, from 0: by energy, then those
            whose sampled volumes are touched, the least first; None where it cannot be timed.
        part: the avoidance part it is meant for.
        outcome: ``clear`` or ``hit`` by the exact check; ``not adjustable``: no edge may change its
            speed as needed; ``time scale``: out of range; ``unchecked``: beyond those asked for.
        walk: the path, with what follows it where it was checked, at the scales of eq. 3.
        path_length: edges of the path itself.
        time_scale: s_time; None where it cannot be timed.
        energy: what it is worth; None where it cannot be timed.
        clearance_m: signed distance of attack and body; None where it was not checked.
    """

    number: int
    rank: int | None
    part: int
    outcome: Outcome
    walk: Walk
    path_length: int
    time_scale: float | None
    energy: Energy | None
    clearance_m: float | None


class Explanation(list[Explained]):
    """All candidates of an attack, in the order of their rank: a list, and a table.

    Attributes:
        graph: on which the walks lie.
        seconds: how long a motion has to stay clear, s.
    """

    def __init__(self, rows: Iterable[Explained], graph: MotionGraph, seconds: float) -> None:
        super().__init__(rows)
        self.graph = graph
        self.seconds = seconds

    def rows(self) -> list[dict[str, Any]]:
        """One plain record a candidate, as ``polars.DataFrame`` and ``pandas.DataFrame`` take them.

        The fields of :class:`Explained` without the walk, those of
        :class:`~mgjax.avoidance.Energy` as ``energy_…``, and ``edges``, the edges of the path. What
        is not known is None.
        """
        return [_record(row) for row in self]

    def motion(self, place: int) -> Motion:
        """The motion of the candidate at a place of the list, feet kept, in the planar frame of
        its first pose, for as long as it has to stay clear.

        As its scales of time say, at 120 frames per second. Where a candidate was not checked, the
        first out-edges follow its path.
        """
        walk = extend(self.graph, self[place].walk, self.seconds)
        return walk_motion(self.graph, walk, self.seconds)


def _record(row: Explained) -> dict[str, Any]:
    energy = {field.name: None for field in fields(Energy)}
    if row.energy is not None:
        energy = asdict(row.energy)
    return {
        "number": row.number,
        "rank": row.rank,
        "part": row.part,
        "outcome": row.outcome,
        "path_length": row.path_length,
        "time_scale": row.time_scale,
        "clearance_m": row.clearance_m,
        **{f"energy_{name}": value for name, value in energy.items()},
        "edges": [int(edge) for edge in row.walk.edges[: row.path_length]],
    }


def explain(
    graph: MotionGraph | Prepared,
    node: int,
    attack: Attack,
    *,
    config: AvoidanceConfig | None = None,
    checked: int = 16,
) -> Explanation:
    """Every candidate of an attack: what it is worth, and whether it stays clear.

    Without slices and index: they only leave candidates out. The first in the list that is
    ``clear`` is what :func:`mgjax.avoidance.choose` takes: they are those within ``T_window`` or,
    where it finds none of them clear, within ``T_wide``. Captured motion decides;
    :func:`mgjax.avoidance.select` leaves out those that are touched with their feet kept.

    Args:
        graph, node, attack, config: see :func:`mgjax.avoidance.select`.
        checked: how many are checked exactly, in their order.

    Returns:
        In the order of their rank, then those that cannot be timed; a list with ``.rows()``, plain
        records for tables, and ``.motion(place)``. Empty if the attack never comes near, or no
        avoidance part comes at the right time.

    Raises:
        AttackError, ConfigError: as :func:`mgjax.avoidance.select`.
    """
    config = config or AvoidanceConfig()
    prepared = prepared_for(graph, config)
    query = ask(prepared, node, attack, config)
    until = attack.end + config.settle_s
    if query is None:
        return Explanation([], prepared.graph, until)
    query = query_decided(query)
    if not len(query.in_time.length):
        return Explanation([], prepared.graph, until)
    candidates = query.in_time
    padded, result = search_candidates(query, candidates)
    table, scales = np.asarray(result.table), np.asarray(result.scales)
    count = len(candidates.length)
    order = [int(n) for n in np.asarray(result.order) if n < count]
    verdicts = {}
    timed = np.array([n for n in order if table[STATUS, n] == OK][:checked], np.int64)
    for numbers, bounds in bounds_of(query, timed, padded, scales):
        for lane in bounded(numbers, bounds, padded):
            verdicts[lane.number] = verify(query, lane)
    rows: list[Explained] = []
    for rank, number in enumerate(order):
        length = int(candidates.length[number])
        edges = candidates.edges[number, :length]
        fit = table[STATUS, number] == OK
        verdict = verdicts.get(number)
        if verdict is not None:
            outcome: Outcome = "clear" if verdict.clear else "hit"
        elif fit:
            outcome = "unchecked"
        else:
            out = table[STATUS, number] != NOT_ADJUSTABLE
            outcome = "time scale" if out else "not adjustable"
        values = dict(zip(ROWS, table[:STATUS, number].tolist(), strict=True))
        time_scale = values.pop("s_time")
        plain = make_walk(prepared.graph, edges, scales[:length, number] if fit else None)
        rows.append(
            Explained(
                number=number,
                rank=rank if fit else None,
                part=int(candidates.part[number]),
                outcome=outcome,
                walk=plain if verdict is None else verdict.played.walk,
                path_length=length,
                time_scale=time_scale if fit else None,
                energy=Energy(**values) if fit else None,
                clearance_m=None if verdict is None else float(verdict.played.clearance),
            )
        )
    return Explanation(rows, prepared.graph, until)
