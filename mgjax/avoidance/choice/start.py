"""Where a search starts: a node of the graph, and an attack that begins outside the body."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack, validate_attack
from mgjax.avoidance.attacks.batch import MOMENTS, AttackBatch, make_attack_batch
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.body.unmoved import spheres_onward
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates
from mgjax.avoidance.choice.results import Choice
from mgjax.avoidance.config import AvoidanceConfig, for_body
from mgjax.avoidance.prepared import Prepared
from mgjax.core.errors import AttackError, ConfigError
from mgjax.graph.feet.course import FeetState


@dataclass(frozen=True, kw_only=True, eq=False)
class Query:
    """What a search is asked: an attack that comes near a character at a node.

    Attributes:
        prepared: of the graph.
        config: settings, in metres of the graph's body (:func:`~mgjax.avoidance.config.for_body`).
        node: where the walks begin.
        attack: in the planar frame of the node, its times counted from there.
        crop: the part of it that counts for energies and timing.
        as_written: the clearance of a choice as it would be written, feet kept, m. A candidate that
            is clear as captured and not as written is not taken. None: captured motion decides.
        begin: what the feet are off now; None: nothing.
        wanted: whether the answer is still waited for; where it is not, refinement ends early.
    """

    prepared: Prepared
    config: AvoidanceConfig
    node: int
    attack: Attack
    crop: Crop
    as_written: Callable[[Choice], float] | None = None
    begin: FeetState | None = None
    wanted: Callable[[], bool] | None = None

    @property
    def until(self) -> float:
        """Until when a motion has to stay clear, s."""
        return self.attack.end + self.config.settle_s

    @cached_property
    def in_time(self) -> Candidates:
        """All walks to an avoidance part that comes at the right time (eq. 1)."""
        return enumerate_candidates(
            self.prepared.graph,
            self.prepared.tables,
            self.node,
            self.crop.middle,
            window=self.config.T_window,
            capacity=self.config.capacity,
        )

    @cached_property
    def attack_batch(self) -> AttackBatch:
        """The attack as compiled code reads it."""
        return make_attack_batch(
            self.attack, self.crop, self.config, self.prepared.posed.reach, self.unmoved
        )

    def widened(self, config: AvoidanceConfig) -> Query:
        """The same query with a wider window; what compiled code reads of the attack stays."""
        wide = replace(self, config=config)
        if "attack_batch" in self.__dict__:
            wide.__dict__["attack_batch"] = self.attack_batch
        return wide

    @property
    def unmoved(self) -> Float[np.ndarray, "K B"]:
        """The body that does not react, as the batch has it; zeros where nothing asks for it."""
        prepared, weight = self.prepared, self.config.energy.w_m
        unmoved = np.zeros((MOMENTS, 3, len(prepared.device.radii)), np.float32)
        if not isinstance(weight, float | int) or weight > 0:
            times = np.arange(1, MOMENTS + 1) * (self.crop.end / MOMENTS)
            tables = prepared.tables
            bodies = spheres_onward(prepared.graph, tables.onward, tables.spheres, self.node, times)
            unmoved[..., : bodies.shape[1]] = np.moveaxis(bodies, 2, 1)
        return unmoved.reshape(MOMENTS, -1)


def ask(
    prepared: Prepared,
    node: int,
    attack: Attack,
    config: AvoidanceConfig,
    as_written: Callable[[Choice], float] | None = None,
    begin: FeetState | None = None,
) -> Query | None:
    """The query of a character at a node; None if the attack never comes near.

    ``as_written`` and ``begin``: see :class:`Query`.

    Raises:
        ConfigError: no such node.
        AttackError: the attack is not finite, or begins inside the body.
    """
    validate_start(prepared, node, attack)
    config = for_body(config, prepared.graph.body_scale)
    crop = crop_attack(attack, radius=config.crop_radius_m, height=config.crop_height_m)
    if crop is None:
        return None
    return Query(
        prepared=prepared,
        config=config,
        node=node,
        attack=attack,
        crop=crop,
        as_written=as_written,
        begin=begin,
    )


def validate_start(prepared: Prepared, node: int, attack: Attack) -> None:
    """Raises unless there is such a node and the attack begins outside the body that stands there.

    Raises:
        ConfigError: no such node.
        AttackError: the attack is not finite, or begins inside the body.
    """
    graph, tables = prepared.graph, prepared.tables
    if not 0 <= node < graph.num_nodes:
        raise ConfigError(f"got node {node}, expected 0 … {graph.num_nodes - 1}")
    validate_attack(attack)
    begin, radii = _beginning(attack)
    gaps = [math.hypot(*c) - r for c, r in zip(begin.tolist(), radii.tolist(), strict=True)]
    if min(gaps, default=math.inf) > tables.farthest:
        return
    spheres = tables.spheres
    # Every edge out of a node begins with the body as it stands there, in the node's frame.
    body = tables.pool[tables.pool_first[graph.edges_from(node)[0]]].reshape(3, -1)
    displacement = body[:, None] - begin.T[..., None]
    gap = np.sqrt((displacement * displacement).sum(axis=0)) - (radii[:, None] + spheres.radii)
    least = gap.min()
    if least < 0:
        where = spheres.names[int(np.argmin(gap.min(axis=0)))]
        raise AttackError(
            f"got an attack that starts {-least:.3f} m inside the body ({where}),"
            " expected one that starts outside"
        )


def _beginning(
    attack: Attack,
) -> tuple[Float[np.ndarray, "I 3"], Float[np.ndarray, " I"]]:
    """Centres and radii of the spheres that are there at the first moment that matters."""
    if attack.start >= 0 and attack.starts is None and attack.stops is None:
        return attack.centres[0], attack.radii
    now = np.array([min(max(attack.start, 0.0), attack.end)])
    centres, active = attack.sampled(now)
    return centres[0, active[0]], attack.radii[active[0]]
