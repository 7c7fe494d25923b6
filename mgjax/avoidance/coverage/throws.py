"""Which attacks a graph can answer: balls from all around, at many nodes, answered in batches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from jaxtyping import Float, Int
from tqdm import tqdm

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.config import (
    ARRIVALS_S,
    BALL_SPEED_M_S,
    DIRECTIONS,
    HEIGHTS_M,
    NODES,
    AvoidanceConfig,
    for_body,
    validate_config,
)
from mgjax.avoidance.many.attacks import BatchSelection, select_batch
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.core.errors import ConfigError, GraphError
from mgjax.core.shown import Shown, made_of
from mgjax.graph.types import MotionGraph

DISTANCE_M = 5.0
"""From where a ball is thrown to the body's axis."""
NO_KIND = -1
MOST_ATTACKS = 1_000_000

_CHUNK = 1024
"""Attacks between two steps of the progress bar; fewer leave groups of equal shapes unfilled."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Coverage(Shown):
    """Balls thrown at a character at many nodes, and the answers to them.

    Attributes:
        directions: where balls come from, rad from ahead towards the left. [D]
        heights: at the body's axis, m, ascending. [H]
        arrivals: seconds from now until a ball is at the axis, ascending. [A]
        speed: of the balls, m/s.
        window: the widest T of eq. 1 that is tried, s.
        node: where the character stands. [B]
        direction, height, arrival: indices into the above. [B]
        answers: what became of each ball. [B]
        kinds: of the graph's avoidance parts, sorted.
        kind: index of the kind that avoids, or ``NO_KIND``. [B]
        nearest_part: of every node of the graph, s; see
            :class:`mgjax.avoidance.body.edge_tables.EdgeTables`. [N]
    """

    directions: Float[np.ndarray, " D"]
    heights: Float[np.ndarray, " H"]
    arrivals: Float[np.ndarray, " A"]
    speed: float
    window: float
    node: Int[np.ndarray, " B"]
    direction: Int[np.ndarray, " B"]
    height: Int[np.ndarray, " B"]
    arrival: Int[np.ndarray, " B"]
    answers: BatchSelection
    kinds: tuple[str, ...]
    kind: Int[np.ndarray, " B"]
    nearest_part: Float[np.ndarray, " N"]

    def __len__(self) -> int:
        return len(self.node)


def measure_coverage(
    graph: MotionGraph | Prepared,
    *,
    directions: int = DIRECTIONS,
    heights: Sequence[float] | None = None,
    arrivals: Sequence[float] = ARRIVALS_S,
    nodes: int = NODES,
    speed: float = BALL_SPEED_M_S,
    config: AvoidanceConfig | None = None,
    seed: int = 0,
    progress: bool = False,
) -> Coverage:
    """Throws straight balls at the body's axis from all around, and answers them.

    At each node one ball comes from every direction: ``directions * nodes`` in all. Heights and
    times of arrival are dealt out, so that each pair of them comes from each direction equally
    often (to within one); that says more about a graph than all of them at fewer nodes would.
    Captured motion decides, as in :func:`mgjax.avoidance.select_batch`.

    Args:
        graph: a motion graph with labelled avoidance parts, or what
            :func:`~mgjax.avoidance.prepared.prepare` made of one.
        directions: how many, evenly spaced; the first is straight ahead.
        heights: at the body's axis, m; None: :data:`~mgjax.avoidance.config.HEIGHTS_M`, scaled to
            the body.
        arrivals: seconds from now until a ball is at the axis.
        nodes: how many, drawn without repetition; all of them again where the graph has fewer.
        seed: draws the nodes and deals.
        speed: of the balls, m/s.
        config: settings of the search; near misses are not refined, as what counts is what the
            graph holds.
        progress: shows a bar on stderr.

    Raises:
        ConfigError: a count below 1, or a number out of range.
        GraphError: no part of the graph is labelled as an avoidance.
        AttackError: a ball would already be inside the body.
    """
    config = replace(config or AvoidanceConfig(), refine="off")
    validate_config(config)
    prepared = prepared_for(graph, config)
    graph = prepared.graph
    scale = graph.body_scale
    heights = [scale * height for height in HEIGHTS_M] if heights is None else heights
    _validate(directions, heights, arrivals, nodes, seed, speed, for_body(config, scale))
    if not len(graph.label_edge):
        raise GraphError(
            "got a graph without avoidance parts, expected one that was built with labels"
        )
    angles = 2 * np.pi * np.arange(directions) / directions
    high, late = np.unique(np.asarray(heights, float)), np.unique(np.asarray(arrivals, float))
    nearest = prepared.tables.nearest_part
    node, direction, dealt = _deal(nearest, directions, nodes, len(high) * len(late), seed)
    height, arrival = dealt % len(high), dealt // len(high)
    chunk = max(_CHUNK // directions, 1) * directions
    answers: list[BatchSelection] = []
    bar = tqdm(total=len(node), desc="attacks", unit="ball", disable=not progress, leave=False)
    with bar:
        for first in range(0, len(node), chunk):
            part = slice(first, first + chunk)
            balls = [
                ball_from(
                    float(angles[d]),
                    float(high[h]),
                    distance=DISTANCE_M,
                    speed=speed,
                    arrives=float(late[a]),
                )
                for d, h, a in zip(direction[part], height[part], arrival[part], strict=True)
            ]
            answers.append(select_batch(prepared, node[part], balls, config=config))
            bar.update(len(balls))
    joined = _join(answers)
    kinds, kind_of_part = np.unique(np.array(graph.label_kind), return_inverse=True)
    result = Coverage(
        directions=angles,
        heights=high,
        arrivals=late,
        speed=float(speed),
        window=float(max(config.T_window, config.T_wide)),
        node=node,
        direction=direction,
        height=height,
        arrival=arrival,
        answers=joined,
        kinds=tuple(kinds.tolist()),
        kind=np.where(joined.status == Status.AVOIDED.code, kind_of_part[joined.part], NO_KIND),
        nearest_part=nearest,
    )
    return made_of(result, graph)


def _deal(
    nearest_part: Float[np.ndarray, " N"], directions: int, nodes: int, hand: int, seed: int
) -> tuple[Int[np.ndarray, " B"], Int[np.ndarray, " B"], Int[np.ndarray, " B"]]:
    """Node, direction and one of ``hand`` pairs of height and arrival, for each ball.

    Of nodes with about the same way to a part each pair gets one, from every direction. So cells
    differ by what their balls are, not by where the character happened to stand.
    """
    rng = np.random.default_rng(seed)
    total = len(nearest_part)
    rounds = [rng.permutation(total) for _ in range(-(-nodes // total))]
    chosen = np.concatenate(rounds)[:nodes]
    chosen = chosen[np.argsort(nearest_part[chosen], kind="stable")]
    hands = rng.random((directions, -(-nodes // hand), hand)).argsort(axis=-1)
    dealt = hands.reshape(directions, -1)[:, :nodes].T
    return np.repeat(chosen, directions), np.tile(np.arange(directions), nodes), dealt.ravel()


def _join(answers: list[BatchSelection]) -> BatchSelection:
    names = [field.name for field in fields(BatchSelection)]
    return BatchSelection(
        **{name: np.concatenate([getattr(answer, name) for answer in answers]) for name in names}
    )


def _validate(
    directions: int,
    heights: Sequence[float],
    arrivals: Sequence[float],
    nodes: int,
    seed: int,
    speed: float,
    config: AvoidanceConfig,
) -> None:
    """Raises :class:`ConfigError` naming the first argument that is out of range."""
    for name, count in (("directions", directions), ("nodes", nodes)):
        if count < 1:
            raise ConfigError(f"got {count} {name}, expected at least 1")
    if directions * nodes > MOST_ATTACKS:
        raise ConfigError(
            f"got {directions} directions at {nodes} nodes, expected at most {MOST_ATTACKS} balls"
        )
    if seed < 0:
        raise ConfigError(f"got seed {seed}, expected 0 or more")
    if not 0 < speed <= 1000:
        raise ConfigError(f"got speed {speed:g} m/s, expected more than 0 and at most 1000")
    for name, values, low, high in (
        ("height", heights, 0.0, config.crop_height_m),
        ("arrival", arrivals, 1e-3, 50.0),
    ):
        if not len(values):
            raise ConfigError(f"got no {name}, expected at least one")
        for value in values:
            if not low <= value <= high:
                raise ConfigError(f"got {name} {value:g}, expected {low:g} … {high:g}")
