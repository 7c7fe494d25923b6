"""What became of attacks: searches that ended, and the checks of what was played."""

from __future__ import annotations

from dataclasses import dataclass, field
from threading import Event
from typing import Literal

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.play.clocks import Ticket
from mgjax.avoidance.play.parried import Outcome
from mgjax.avoidance.play.several_attacks import JointPath
from mgjax.avoidance.rates import CLEAR_M
from mgjax.graph.feet.course import FeetState


@dataclass(frozen=True, kw_only=True, eq=False)
class Asked:
    """What a search was asked.

    Attributes:
        node: where the path is to begin.
        place: planar frame of the body there, in the world. [3]
        begins: when it begins, s on the planner's clock.
        attack: in that frame, its times counted from then.
        feet: what the feet are off then, in the world.
    """

    node: int
    place: Float[np.ndarray, "3"]
    begins: float
    attack: Attack
    feet: FeetState


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """A search that ended in time: of which attack, what was asked, and the path found."""

    number: int
    asked: Asked
    path: JointPath


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What became of one attack.

    Attributes:
        number: of the attack, counted from 0.
        known: when it became known, s on the planner's clock.
        status: ``superseded``: a later attack came before this one's search had ended. Else by the
            exact check of what was really played: ``hit``, ``avoided`` or ``parried``.
        search: how the search ended: as :class:`mgjax.avoidance.choice.choosing.Choice` says, or
            ``late``: not before the attack was over or a later one superseded it; ``committed``:
            there was none, as the attack is over before what is being played can be left.
        hit: the exact check of what was played, also for superseded attacks.
        clearance_m: signed distance of attack and body over what was played since it was known; of
            the rest of the body if it was parried.
        restarts: how often an edge ended before the search.
        waited: seconds from its becoming known until a frame noticed the search's end, or None.
        limb: that parried it, or None.
    """

    number: int
    known: float
    status: Literal["avoided", "hit", "superseded", "parried"]
    search: Status | Literal["late", "committed"]
    hit: bool
    clearance_m: float
    restarts: int
    waited: float | None
    limb: str | None = None


@dataclass(eq=False)
class Thrown:
    """An attack under way, in the world."""

    number: int
    known: float
    attack: Attack
    search: Status | Literal["late", "committed"] = "late"
    superseded: bool = False
    restarts: int = 0
    waited: float | None = None
    check: Ticket | None = field(default=None, repr=False)
    asked: Asked | None = field(default=None, repr=False)


@dataclass(frozen=True, kw_only=True, eq=False)
class Pending:
    """A search under way: for which attack, since when, and whether its answer is waited for."""

    thrown: Thrown
    ticket: Ticket
    begun: float
    dropped: Event

    def drop(self, now: float) -> None:
        """Its answer is not waited for any longer."""
        self.dropped.set()
        self.ticket.cancel(now)


def answer_of(thrown: Thrown, outcome: Outcome) -> Answer:
    """The answer to an attack, by the check of what was played."""
    hit = outcome.clearance < CLEAR_M
    passed = "avoided" if outcome.limb is None else "parried"
    return Answer(
        number=thrown.number,
        known=thrown.known,
        status="superseded" if thrown.superseded else "hit" if hit else passed,
        search=thrown.search,
        hit=hit,
        clearance_m=outcome.clearance,
        restarts=thrown.restarts,
        waited=thrown.waited,
        limb=outcome.limb,
    )
