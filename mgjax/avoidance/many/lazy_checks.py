"""One attack whose candidates are judged once; what is certain of them is found as it is needed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import jax
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.choice.search import HOPELESS_M, SearchInput, search_input
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.choice.verify import Bounded, bounded, bounds_of, verify
from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy.evaluate import Judged, judge_all
from mgjax.avoidance.many.reweight import Certainty, Picked, pick_each
from mgjax.avoidance.rates import CLEAR_M
from mgjax.avoidance.timing.time_scale import OK

_judge = jax.jit(judge_all, static_argnames=("half_frame", "limit_scale"))


@dataclass(frozen=True, kw_only=True, eq=False)
class ScoredAttack:
    """One attack whose candidates are judged; what is certain of them is filled in as needed.

    Attributes:
        query: the attack; the energies of its settings do not matter.
        candidates: all that are in time.
        padded: both as compiled code reads them.
        judged: without a limit on the time scale.
        certainty: see :class:`~mgjax.avoidance.many.reweight.Certainty`. [C]
        clearance: by the exact check, m; −∞ where nothing is known. [C]
        has_bounds: candidates of which bounds were found. [C]
        doubts: candidates that their bounds leave in doubt, by number.
    """

    query: Query
    candidates: Candidates
    padded: SearchInput
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
            limit_scale=self.query.config.limit_scale,
            checks=self.query.config.checks,
        )
        return jax.tree.map(np.asarray, picked)

    def look_closer(self, numbers: Int[np.ndarray, " K"]) -> None:
        """Makes sure of some candidates: by bounds, and where these leave a doubt by looking at the
        written motion."""
        self.bound(numbers[~self.has_bounds[numbers]])
        for number in numbers[self.certainty[numbers] == Certainty.UNKNOWN].tolist():
            doubt = self.doubts.pop(number)
            verdict = verify(self.query, doubt)
            self.certainty[number] = Certainty.CLEAR if verdict.clear else Certainty.TOUCHED
            self.clearance[number] = verdict.played.clearance

    def bound(self, numbers: Int[np.ndarray, " K"]) -> None:
        """Finds bounds on the clearance of some candidates, and what they make certain."""
        scales = np.asarray(self.judged.timing.scales)
        for subset, bounds in bounds_of(self.query, numbers, self.padded, scales):
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


def score_attack(query: Query, form: Literal["paper", "overlap"], E_time: float) -> ScoredAttack:
    """Judges all candidates without a limit on their time scale, and bounds the hopeful ones.

    Args:
        query: the attack; the energies of its settings do not matter.
        form: of the energies.
        E_time: the largest of the settings that will be asked about.
    """
    prepared, candidates = query.prepared, query.in_time
    padded = search_input(query, candidates)
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
        query=query,
        candidates=candidates,
        padded=padded,
        judged=judged,
        certainty=np.full(count, Certainty.UNKNOWN, np.int32),
        clearance=np.full(count, -np.inf, np.float32),
        has_bounds=np.zeros(count, bool),
        doubts={},
    )
    usable = np.asarray(judged.timing.status) == OK
    if query.config.limit_scale:
        limit = 1.001 * E_time
        s = np.asarray(judged.timing.s_time)
        usable &= (s <= limit) & (s * limit >= 1)
    scored.bound(np.flatnonzero(usable & (np.asarray(judged.measures.d) >= -HOPELESS_M)))
    return scored
