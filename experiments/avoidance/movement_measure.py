"""All clear candidates of a ball, and how much those that are chosen of them move."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from experiments.avoidance.throws import Throws
from mgjax.avoidance.body.unmoved import walk_onward
from mgjax.avoidance.checks.written import walk_motion
from mgjax.avoidance.choice.choosing import query_decided
from mgjax.avoidance.choice.results import Choice, Status
from mgjax.avoidance.choice.selection import write
from mgjax.avoidance.choice.start import Query, ask
from mgjax.avoidance.choice.verify import bounded, bounds_of, verify
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig, for_body
from mgjax.avoidance.energy.evaluate import ranking
from mgjax.avoidance.many.lazy_checks import ScoredAttack, score_attack
from mgjax.avoidance.many.reweight import Certainty, reweight
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.timing.time_scale import OK
from mgjax.core.errors import AttackError
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion

POLICIES = ("energies", "the paper's three", "random", "largest clearance", "least movement")
"""Ways to choose among the clear candidates of a ball."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Clear:
    """A ball and the candidates that are clear of it.

    Attributes:
        ball: its number.
        scored: its candidates.
        numbers: of those that are clear.
        scale: of the body, which the settings of energies mean an adult's.
    """

    ball: int
    scored: ScoredAttack
    numbers: Int[np.ndarray, " N"]
    scale: float

    @property
    def displacement(self) -> Float[np.ndarray, " C"]:
        """Of the body's spheres, by the tables, m."""
        return np.asarray(self.scored.judged.measures.displacement)

    @property
    def time_scale(self) -> Float[np.ndarray, " C"]:
        """s_time of each candidate."""
        return np.asarray(self.scored.judged.measures.s_time)

    @property
    def clearance(self) -> Float[np.ndarray, " C"]:
        """Of each candidate, m."""
        return self.scored.clearance

    def first(self, energy: EnergyConfig) -> int:
        """The clear candidate that comes first by some energies."""
        own = for_body(replace(self.scored.query.config, energy=energy), self.scale).energy
        limited = self.scored.query.config.limit_scale
        order = np.asarray(ranking(reweight(self.scored.judged, own, limit_scale=limited)))
        return int(order[np.isin(order, self.numbers)][0])


def answers_of(prepared: Prepared, throws: Throws, config: AvoidanceConfig) -> list[Clear]:
    """The clear candidates of each ball that comes near, by the exact check of all that may be."""
    return list(_answers(prepared, throws, config))


def _answers(prepared: Prepared, throws: Throws, config: AvoidanceConfig) -> Iterator[Clear]:
    for ball in range(len(throws)):
        node, attack = throws.node_of(ball, prepared.graph), throws.attack(ball)
        try:
            query = ask(prepared, node, attack, config)
        except AttackError:
            continue
        if query is None:
            continue
        query = query_decided(query)
        if not len(query.in_time.length):
            continue
        scored = score_attack(query, config.energy.form, float(config.energy.E_time))
        again = reweight(scored.judged, query.config.energy, limit_scale=config.limit_scale)
        usable = np.asarray(again.timing.status) == OK
        scored.look_closer(np.flatnonzero(usable & scored.has_bounds))
        clear = np.flatnonzero(usable & (scored.certainty == Certainty.CLEAR))
        yield Clear(ball=ball, scored=scored, numbers=clear, scale=prepared.graph.body_scale)


def costs_of(
    prepared: Prepared, clear: Clear, config: AvoidanceConfig, rng: np.random.Generator
) -> dict[str, tuple[float, float]]:
    """Movement and extra travel of the root, m, of what each of :data:`POLICIES` chooses."""
    three = replace(config.energy, w_m=0.0, w_speed_up=1.0)
    numbers = clear.numbers
    chosen = {
        "energies": clear.first(config.energy),
        "the paper's three": clear.first(three),
        "random": int(rng.choice(numbers)),
        "largest clearance": int(numbers[np.argmax(clear.clearance[numbers])]),
        "least movement": int(numbers[np.argmin(clear.displacement[numbers])]),
    }
    query = clear.scored.query
    graph, until = prepared.graph, query.until
    still = walk_motion(graph, walk_onward(graph, prepared.tables.onward, query.node, until), until)
    known: dict[int, tuple[float, float]] = {}
    for number in set(chosen.values()):
        motion = _written(prepared, clear.scored, number, config)
        known[number] = (displaced(graph.skeleton, motion, still), travel(motion) - travel(still))
    return {name: known[number] for name, number in chosen.items()}


def displaced(skeleton, motion: Motion, still: Motion) -> float:
    """Mean distance of all joints from those of another motion over the frames of both, m."""
    count = min(motion.num_frames, still.num_frames)
    here, there = (
        np.asarray(forward(skeleton, m.root_translation[:count], m.local_rotations[:count])[0])
        for m in (motion, still)
    )
    return float(np.linalg.norm(here - there, axis=-1).mean())


def travel(motion: Motion) -> float:
    """How far the root travels over the floor, m."""
    steps = np.diff(np.asarray(motion.root_translation, np.float64)[:, [0, 2]], axis=0)
    return float(np.linalg.norm(steps, axis=1).sum())


def _written(
    prepared: Prepared, scored: ScoredAttack, number: int, config: AvoidanceConfig
) -> Motion:
    """The motion of a candidate as it is written."""
    query: Query = scored.query
    scales = np.asarray(scored.judged.timing.scales)
    ((numbers, bounds),) = bounds_of(query, np.array([number]), scored.padded, scales)
    (candidate,) = bounded(numbers, bounds, scored.padded)
    played = verify(query, candidate).played
    choice = Choice(
        status=Status.AVOIDED,
        node=query.node,
        walk=played.walk,
        path_length=candidate.length,
        part=int(scored.candidates.part[number]),
        time_scale=float(np.asarray(scored.judged.measures.s_time)[number]),
        clearance_m=played.clearance,
        crop=query.crop,
    )
    return write(prepared, query.attack, choice, config).motion
