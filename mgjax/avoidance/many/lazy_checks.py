"""One attack whose candidates are judged once; what is certain of them is found as it is needed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import jax
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.choice.search import HOPELESS_M, Query, SearchInput, search_input
from mgjax.avoidance.choice.verify import Bounded, bounded, bounds_of, verify
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.avoidance.energy.evaluate import Judged, judge_all
from mgjax.avoidance.many.reweight import Certainty, Picked, pick_each
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.rates import CLEAR_M
from mgjax.avoidance.timing.time_scale import OK

_judge = jax.jit(judge_all, static_argnames=("half_frame", "limit_scale"))


@dataclass(frozen=True, kw_only=True, eq=False)
class ScoredAttack:
    """One attack whose candidates are judged; what is certain of them is filled in as needed.

    Attributes:
        prepared: of the graph.
        query: the attack and its candidates.
        padded: both as compiled code reads them.
        config: its energies do not matter.
        judged: without a limit on the time scale.
        certainty: see :class:`~mgjax.avoidance.many.reweight.Certainty`. [C]
        clearance: by the exact check, m; −∞ where nothing is known. [C]
        has_bounds: candidates of which bounds were found. [C]
        doubts: candidates that their bounds leave in doubt, by number.
    """

    prepared: Prepared
    query: Query
    padded: SearchInput
    config: AvoidanceConfig
    judged: Judged
    certainty: Int[np.ndarray, " C"]
    clearance: Float[np.ndarray, " C"]
    has_bounds: Bool[np.ndarray, " C"]
    doubts: dict[int, Bounded]

    def pick(self, grid: EnergyConfig) -> Picked:
        """What each setting picks by what is known so far."""
        picked = pick_each(
            self.judged,
            self.certainty,
            self.clearance,
            grid,
            limit_scale=self.config.limit_scale,
            checks=self.config.checks,
        )
        return jax.tree.map(np.asarray, picked)

    def look_closer(self, numbers: Int[np.ndarray, " K"]) -> None:
        """Makes sure of some candidates: by bounds, and where these leave a doubt by looking at the
        written motion."""
        self.bound(numbers[~self.has_bounds[numbers]])
        for number in numbers[self.certainty[numbers] == Certainty.UNKNOWN].tolist():
            doubt = self.doubts.pop(number)
            verdict = verify(self.prepared, self.query.attack, doubt, self.config)
            self.certainty[number] = Certainty.CLEAR if verdict.clear else Certainty.TOUCHED
            self.clearance[number] = verdict.played.clearance

    def bound(self, numbers: Int[np.ndarray, " K"]) -> None:
        """Finds bounds on the clearance of some candidates, and what they make certain."""
        scales = np.asarray(self.judged.timing.scales)
        for subset, bounds in bounds_of(self.prepared, numbers, self.padded, scales):
            for candidate in bounded(subset, bounds, self.padded):
                number = candidate.number
                if candidate.lower_bound >= CLEAR_M:
                    self.certainty[number] = Certainty.CLEAR
                elif candidate.surely_touched:
                    self.certainty[number] = Certainty.TOUCHED
                else:
                    self.doubts[number] = candidate
                self.clearance[number] = candidate.clearance
                self.has_bounds[number] = True


def score_attack(
    prepared: Prepared,
    query: Query,
    config: AvoidanceConfig,
    form: Literal["paper", "overlap"],
    E_time: float,
) -> ScoredAttack:
    """Judges all candidates without a limit on their time scale, and bounds the hopeful ones.

    Args:
        prepared: of the graph.
        query: the attack and its candidates.
        config: its energies do not matter.
        form: of the energies.
        E_time: the largest of the settings that will be asked about.
    """
    padded = search_input(query, config, prepared.posed.reach)
    judged = _judge(
        prepared.device,
        padded.walks,
        padded.attack_batch,
        EnergyConfig(form=form),
        half_frame=0.5 / prepared.graph.frame_rate,
        limit_scale=False,
    )
    count = len(padded.walks.length)
    scored = ScoredAttack(
        prepared=prepared,
        query=query,
        padded=padded,
        config=config,
        judged=judged,
        certainty=np.full(count, Certainty.UNKNOWN, np.int32),
        clearance=np.full(count, -np.inf, np.float32),
        has_bounds=np.zeros(count, bool),
        doubts={},
    )
    usable = np.asarray(judged.timing.status) == OK
    if config.limit_scale:
        limit = 1.001 * E_time
        s = np.asarray(judged.timing.s_time)
        usable &= (s <= limit) & (s * limit >= 1)
    scored.bound(np.flatnonzero(usable & (np.asarray(judged.measures.d) >= -HOPELESS_M)))
    return scored
