from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from mgjax.avoidance.attacks.merge import merge_attacks
from mgjax.avoidance.choice.compile_ahead import programs, warm_up
from mgjax.avoidance.choice.selection import select
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.graph.types import MotionGraph
from tests.avoidance.made import throw


@pytest.mark.long
def test_nothing_is_compiled_after_warming_up(made_graph: MotionGraph) -> None:
    config = AvoidanceConfig()
    programs = warm_up(made_graph, config=config, horizon=3.0, spheres=2)
    assert programs == warm_up(made_graph, config=config, horizon=3.0, spheres=2)
    compiled: list[str] = []

    def heard(event: str, *_: object, **_more: object) -> None:
        if event == "/jax/core/compile/backend_compile_duration":
            compiled.append(event)

    rng = np.random.default_rng(5)
    attacks = [throw(rng, arrives=arrives) for arrives in (0.6, 1.0, 1.2, 1.4, 2.0)]
    attacks += [throw(rng, speed=1.5, arrives=2.0), throw(rng, gravity=True, arrives=1.1)]
    attacks.append(merge_attacks(attacks[:2]))
    select(made_graph, 0, attacks[0], config=config)  # small helpers of jax itself
    jax.monitoring.register_event_duration_secs_listener(heard)
    statuses = set()
    for attack in attacks:
        for node in rng.integers(made_graph.num_nodes, size=6):
            weights = EnergyConfig(w_a=rng.uniform(0.5, 2), E_time=rng.uniform(2, 5))
            choice = select(made_graph, int(node), attack, config=replace(config, energy=weights))
            statuses.add(choice.status)
    assert not compiled
    assert statuses >= {"avoided"}


def test_how_many_programs_attacks_need(made_graph: MotionGraph) -> None:
    """Each takes seconds to compile: more of them are felt by everyone who begins."""
    plain = len(programs(made_graph, config=AvoidanceConfig(refine="off")))
    assert plain <= 10
    assert len(programs(made_graph)) == plain + 2  # refinement, in two sizes
