from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import AttackColumn
from mgjax.avoidance.attacks.crop import crop_attack
from mgjax.avoidance.choice.start import ask, validate_start
from mgjax.avoidance.config import AvoidanceConfig, validate_config
from mgjax.avoidance.prepared import prepared_for
from mgjax.core.errors import AttackError, ConfigError
from mgjax.graph.types import MotionGraph
from tests.avoidance.made import natural_times, throw


def test_settings_are_known_by_identity() -> None:
    one = AvoidanceConfig(capacity=1, refine="off")
    for _ in range(2):
        validate_config(one)
        with pytest.raises(ConfigError, match="got capacity = True"):
            validate_config(replace(one, capacity=True))  # equal to 1
        with pytest.raises(ConfigError, match="got capacity = 0"):
            validate_config(replace(one, capacity=0))


def still(place: np.ndarray, radius: float) -> Attack:
    return Attack(
        times=np.array([0.0, 1.0]), centres=np.tile(place, (2, 1, 1)), radii=np.array([radius])
    )


def test_begins_inside_whatever_is_skipped(made_graph: MotionGraph) -> None:
    # A place is inside if it is in a sphere of the body at the node, near or far.
    prepared = prepared_for(made_graph, AvoidanceConfig())
    tables = prepared.tables
    radii = tables.spheres.radii
    reach = 0.0
    rng = np.random.default_rng(0)
    inside = 0
    for node in rng.choice(made_graph.num_nodes, 20, replace=False).tolist():
        edge = made_graph.edges_from(node)[0]
        body = tables.pool[tables.pool_first[edge]].reshape(3, -1).T.astype(np.float64)
        reach = max(reach, float((np.linalg.norm(body, axis=1) + radii).max()))
        for _ in range(10):
            place, radius = rng.uniform((-2, 0, -2), (2, 3, 2)), float(rng.choice([0.1, 1.0]))
            gap = (np.linalg.norm(body - place, axis=1) - radii).min() - radius
            if gap < 0:
                with pytest.raises(AttackError, match=f"starts {-gap:.3f} m inside the body"):
                    validate_start(prepared, node, still(place, radius))
            else:
                validate_start(prepared, node, still(place, radius))
            inside += gap < 0
    assert 10 < inside < 180
    assert reach < tables.farthest


def test_what_a_query_holds(made_graph: MotionGraph) -> None:
    config = AvoidanceConfig()
    prepared = prepared_for(made_graph, config)
    attack = throw(np.random.default_rng(2))
    asked = (ask(prepared, node, attack, config) for node in range(3, made_graph.num_nodes))
    query = next(found for found in asked if found is not None and len(found.in_time.length))
    assert query.crop == crop_attack(attack, radius=1.0, height=2.3)
    assert query.until == attack.end + config.settle_s
    middle = query.crop.middle
    natural = natural_times(prepared.tables, query.in_time)
    assert len(natural)
    assert (np.abs(natural - middle) < config.T_window / 2).all()
    assert query.attack_batch.number(AttackColumn.T_ATTACK)[0] == np.float32(middle)
    assert ask(prepared, 3, still(np.array([0.0, 1.0, 5.0]), 0.1), config) is None  # never near
    with pytest.raises(ConfigError, match="got node -1"):
        ask(prepared, -1, attack, config)
