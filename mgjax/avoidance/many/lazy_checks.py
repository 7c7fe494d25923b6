"""One attack whose candidates are judged once, with verdicts that are found as they are needed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import jax
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.body.device_tables import search_tables
from mgjax.avoidance.body.poses import body_of
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.checks.bounds import MORE_LANES, Bounds
from mgjax.avoidance.choice.search import HOPELESS_M, STATUS, Found, Task, bound, make_task
from mgjax.avoidance.choice.verify import settle
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.avoidance.energy.score import Judged, judge_all
from mgjax.avoidance.many.reweight import CLEAR, TOUCHED, UNKNOWN, Picked, pick_each
from mgjax.avoidance.rates import CLEAR_M
from mgjax.avoidance.timing.time_scale import OK, PADDING
from mgjax.graph.types import MotionGraph

_judge = jax.jit(judge_all, static_argnames=("half_frame", "limit_scale"))


@dataclass(frozen=True, kw_only=True, eq=False)
class Question:
    """One attack whose candidates are judged; verdicts are filled in as needed.

    Attributes:
        config: its energies do not matter.
        judged: without a limit on the time scale.
        verdict: ``CLEAR``, ``TOUCHED`` or ``UNKNOWN``. [C]
        clearance: by the exact check, m; −∞ where nothing is known. [C]
        bounded: candidates that have been bounded. [C]
        doubts: the bounds of those that they leave in doubt, by number.
    """

    graph: MotionGraph
    node: int
    attack: Attack
    crop: Crop
    candidates: Candidates
    config: AvoidanceConfig
    task: Task
    judged: Judged
    verdict: Int[np.ndarray, " C"]
    clearance: Float[np.ndarray, " C"]
    bounded: Bool[np.ndarray, " C"]
    doubts: dict[int, Bounds]

    def pick(self, grid: EnergyConfig) -> Picked:
        """What each setting picks by what is known so far."""
        picked = pick_each(
            self.judged,
            self.verdict,
            self.clearance,
            grid,
            limit_scale=self.config.limit_scale,
            checks=self.config.checks,
        )
        return jax.tree.map(np.asarray, picked)

    def look_closer(self, numbers: Int[np.ndarray, " K"]) -> None:
        """Finds the verdicts on some candidates: by bounds, and where these leave a doubt by
        looking at the written motion."""
        self.bound(numbers[~self.bounded[numbers]])
        for number in numbers[self.verdict[numbers] == UNKNOWN].tolist():
            self._settle(number)

    def bound(self, numbers: Int[np.ndarray, " K"]) -> None:
        """Finds bounds on the clearance of some candidates, and the verdicts they are sure of."""
        _, device = search_tables(self.graph, self.config.body_rate, self.config.speed)
        scales = np.asarray(self.judged.timing.scales)
        for first in range(0, len(numbers), MORE_LANES):
            some = numbers[first : first + MORE_LANES]
            rows = np.resize(some, MORE_LANES)  # repeats fill the lanes
            found = bound(
                device,
                self.task.walks.rows(rows),
                scales[:, rows],
                self.task.shots,
                frame_rate=self.graph.frame_rate,
            )
            found = jax.tree.map(lambda x, some=some: np.asarray(x)[: len(some)], found)
            clear = found.least >= CLEAR_M
            touched = ~clear & (found.touched_from < found.path_end)
            self.verdict[some] = np.where(clear, CLEAR, np.where(touched, TOUCHED, UNKNOWN))
            self.clearance[some] = found.clearance
            self.bounded[some] = True
            for lane in np.flatnonzero(self.verdict[some] == UNKNOWN):
                self.doubts[int(some[lane])] = jax.tree.map(lambda x, i=lane: x[i : i + 1], found)

    def _settle(self, number: int) -> None:
        """The verdict on one candidate, by a search that has no other."""
        scores = np.full((STATUS + 1, len(self.task.walks.length)), PADDING, np.float32)
        scores[STATUS, number] = OK
        alone = Found(
            scores=scores,
            scales=self.judged.timing.scales,
            order=np.array([number], np.int32),
            bounds=self.doubts.pop(number),
        )
        choice = settle(
            self.graph,
            self.node,
            self.attack,
            self.crop,
            self.candidates,
            self.task,
            alone,
            self.config,
        ).choice
        assert choice is not None
        self.verdict[number] = CLEAR if choice.status == "avoided" else TOUCHED
        self.clearance[number] = choice.clearance_m


def ask(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    crop: Crop,
    candidates: Candidates,
    config: AvoidanceConfig,
    form: Literal["paper", "overlap"],
    E_time: float,
) -> Question:
    """Judges all candidates without a limit on their time scale, and bounds the hopeful ones.

    Args:
        graph, node, attack, crop, candidates: the question.
        config: its energies do not matter.
        form: of the energies.
        E_time: the largest of the settings that will be asked about.
    """
    _, device = search_tables(graph, config.body_rate, config.speed)
    task = make_task(candidates, attack, crop, config, body_of(graph)[1])
    judged = _judge(
        device,
        task.walks,
        task.shots,
        EnergyConfig(form=form),
        half_frame=0.5 / graph.frame_rate,
        limit_scale=False,
    )
    count = len(task.walks.length)
    question = Question(
        graph=graph,
        node=node,
        attack=attack,
        crop=crop,
        candidates=candidates,
        config=config,
        task=task,
        judged=judged,
        verdict=np.full(count, UNKNOWN, np.int32),
        clearance=np.full(count, -np.inf, np.float32),
        bounded=np.zeros(count, bool),
        doubts={},
    )
    usable = np.asarray(judged.timing.status) == OK
    if config.limit_scale:
        limit = 1.001 * E_time
        s = np.asarray(judged.timing.s_time)
        usable &= (s <= limit) & (s * limit >= 1)
    question.bound(np.flatnonzero(usable & (np.asarray(judged.energies.d) >= -HOPELESS_M)))
    return question
