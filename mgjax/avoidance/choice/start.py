"""Where a search starts: a node of the graph, and an attack that begins outside the body."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack, validate_attack
from mgjax.avoidance.prepared import Prepared
from mgjax.core.errors import AttackError, ConfigError


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
    active = attack.active(now)[0]
    return attack.at(now)[0, active], attack.radii[active]
