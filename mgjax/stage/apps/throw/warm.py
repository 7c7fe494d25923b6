"""One throw before the first: what else has to be compiled is compiled by it."""

from __future__ import annotations

import numpy as np

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.choice.explain import explain
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.play.clocks import SimulatedClock, SimulatedSearches
from mgjax.avoidance.play.planner import Planner
from mgjax.avoidance.prepared import Prepared
from mgjax.stage.apps.throw.contact import track


def warm_session(prepared: Prepared) -> None:
    """Plays a second, throws a ball and explains it, all at once."""
    clock = SimulatedClock()
    planner = Planner(prepared, clock=clock, searches=SimulatedSearches())
    clock.advance(0.5)
    planner.advance()
    root = planner.timeline.sample(np.array([0.5, 0.6])).root_translation[0]
    ball = ball_from(0.0, 1.3, at=(float(root[0]), float(root[2])), arrives=1.7)
    planner.attack(ball)
    planner.finish()
    track(ball, None, 0.12)
    explain(prepared, 0, ball_from(0.0, 1.3), config=AvoidanceConfig())
