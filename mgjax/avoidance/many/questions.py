"""The questions of many attacks, put at once: where and when each comes near, and against whom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import MOMENTS, AttackBatch, make_attack_batch
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.attacks.straight import (
    Balls,
    batch_rows,
    begins_far,
    crops_of,
    straight_balls,
)
from mgjax.avoidance.body.unmoved import bodies_onward
from mgjax.avoidance.choice.start import Query, validate_start
from mgjax.avoidance.config import AvoidanceConfig, for_body
from mgjax.avoidance.prepared import Prepared


@dataclass(frozen=True, kw_only=True, eq=False)
class Questions:
    """Many attacks, each on a character that stands at a node.

    Attributes:
        prepared: of the graph.
        config: settings, in metres of the graph's body.
        nodes: where the characters stand. [B]
        attacks: each in the planar frame of its node.
        balls: those of the attacks that are straight balls, by how many knots they have.
        start, stop: of the part of each attack that counts, s; NaN where it never comes near. [B]
    """

    prepared: Prepared
    config: AvoidanceConfig
    nodes: Int[np.ndarray, " B"]
    attacks: Sequence[Attack]
    balls: list[Balls]
    start: Float[np.ndarray, " B"]
    stop: Float[np.ndarray, " B"]
    _place: dict[int, tuple[int, int]] = field(default_factory=dict)

    @property
    def middle(self) -> Float[np.ndarray, " B"]:
        """The time of each attack, s."""
        return 0.5 * (self.start + self.stop)

    def query(self, number: int, attack_batch: AttackBatch | None = None) -> Query:
        """The question of one attack that comes near, alone."""
        query = Query(
            prepared=self.prepared,
            config=self.config,
            node=self.nodes.item(number),
            attack=self.attacks[number],
            crop=self._crop(number),
        )
        if attack_batch is not None:
            query.__dict__["attack_batch"] = attack_batch
        return query

    def _crop(self, number: int) -> Crop:
        return Crop(start=self.start.item(number), end=self.stop.item(number))

    def batches(self, numbers: Int[np.ndarray, " A"]) -> list[AttackBatch]:
        """Some of the attacks as compiled code reads them, those that come near."""
        unmoved = self._unmoved(numbers)
        found: list[AttackBatch | None] = [None] * len(numbers)
        reach = self.prepared.posed.reach
        place = {number: row for row, number in enumerate(numbers.tolist())}
        for balls in self.balls:
            own = np.flatnonzero(np.isin(balls.number, numbers))
            if not len(own):
                continue
            chosen = balls.some(own)
            crops = self.start[chosen.number], self.stop[chosen.number]
            frames, known, fits = batch_rows(chosen, crops, self.config, reach)
            for i in np.flatnonzero(fits).tolist():
                row = place[chosen.number.item(i)]
                found[row] = AttackBatch(
                    frames=frames[i : i + 1],
                    numbers=known[i : i + 1],
                    unmoved=unmoved[row : row + 1],
                )
        return [
            make_attack_batch(
                self.attacks[number], self._crop(number), self.config, reach, unmoved[row]
            )
            if batch is None
            else batch
            for row, (number, batch) in enumerate(zip(numbers.tolist(), found, strict=True))
        ]

    def _unmoved(self, numbers: Int[np.ndarray, " A"]) -> Float[np.ndarray, "A K B"]:
        """The bodies that do not react, as :attr:`Query.unmoved` has one."""
        prepared, weight = self.prepared, self.config.energy.w_m
        unmoved = np.zeros((len(numbers), MOMENTS, 3, len(prepared.device.radii)), np.float32)
        if not isinstance(weight, float | int) or weight > 0:
            times = np.arange(1, MOMENTS + 1) * (self.stop[numbers] / MOMENTS)[:, None]
            tables = prepared.tables
            bodies = bodies_onward(
                prepared.graph, tables.onward, tables.spheres, self.nodes[numbers], times
            )
            unmoved[..., : bodies.shape[3]] = np.swapaxes(bodies, 1, 2)
        return unmoved.reshape(len(numbers), MOMENTS, 3 * unmoved.shape[3])


def ask_all(
    prepared: Prepared,
    nodes: Int[np.ndarray, " B"],
    attacks: Sequence[Attack],
    config: AvoidanceConfig,
) -> Questions:
    """The questions of :func:`~mgjax.avoidance.choice.start.ask` of many attacks.

    Raises:
        ConfigError: no such node.
        AttackError: an attack is not finite, or begins inside the body.
    """
    own = for_body(config, prepared.graph.body_scale)
    balls = straight_balls(attacks)
    doubtful = np.ones(len(attacks), bool)
    for some in balls:
        doubtful[some.number] = ~(some.sound & begins_far(some, prepared.tables.farthest))
    doubtful |= (nodes < 0) | (nodes >= prepared.graph.num_nodes)
    for number in np.flatnonzero(doubtful).tolist():
        validate_start(prepared, nodes.item(number), attacks[number])
    span = np.full((2, len(attacks)), np.nan)
    size = {"radius": own.crop_radius_m, "height": own.crop_height_m}
    alone = np.ones(len(attacks), bool)
    for some in balls:
        span[:, some.number] = crops_of(some, **size)
        alone[some.number] = False
    for number in np.flatnonzero(alone).tolist():
        crop = crop_attack(attacks[number], **size)
        if crop is not None:
            span[:, number] = crop.start, crop.end
    return Questions(
        prepared=prepared,
        config=own,
        nodes=nodes,
        attacks=attacks,
        balls=balls,
        start=span[0],
        stop=span[1],
    )
