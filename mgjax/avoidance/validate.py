"""What a search is asked: settings in range, an attack that begins outside the body."""

from __future__ import annotations

import math
from functools import lru_cache
from weakref import WeakValueDictionary

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attack import Attack, validate_attack
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.tables import EdgeTables
from mgjax.core.errors import AttackError, ConfigError
from mgjax.graph.types import MotionGraph

_RANGES: dict[str, tuple[float, float]] = {
    "T_window": (1e-3, 10.0),
    "crop_radius_m": (1e-3, 100.0),
    "crop_height_m": (1e-3, 100.0),
    "body_rate": (1.0, 1000.0),
    "evaluation_step_s": (1e-3, 1.0),
    "settle_s": (0.0, 10.0),
    "capacity": (1, 1_000_000),
    "checks": (1, 1_000_000),
    "energy.E_avoidance": (1e-9, 1e9),
    "energy.D_body": (1e-9, 1e9),
    "energy.E_time": (1.0, 1e6),
    "energy.w_a": (0.0, 1e9),
    "energy.w_b": (0.0, 1e9),
    "energy.w_t": (0.0, 1e9),
    "speed.V_fast": (0.0, math.inf),
    "speed.V_slow": (0.0, math.inf),
    "speed.V_still": (0.0, math.inf),
}
"""Smallest and largest value of each setting that is a number."""

_IN_RANGE: WeakValueDictionary[int, AvoidanceConfig] = WeakValueDictionary()
"""Settings that were found in range, by identity: equal ones may differ in type (1 and True), and
traced ones cannot be compared."""


def validate_config(config: AvoidanceConfig) -> None:
    """Raises :class:`ConfigError` naming the first setting that is out of range."""
    if _IN_RANGE.get(id(config)) is config:
        return
    for key, (low, high) in _RANGES.items():
        part, _, name = key.rpartition(".")
        value = getattr(getattr(config, part) if part else config, name)
        try:
            ok = not isinstance(value, bool | str) and low <= float(value) <= high
        except (TypeError, ValueError):
            ok = False
        if not ok:
            top = f" … {high:g}" if high < math.inf else " or more"
            raise ConfigError(f"got {key} = {value!r}, expected {low:g}{top}")
    for key, value, known in (
        ("energy.form", config.energy.form, ("overlap", "paper")),
        ("energy.d0", config.energy.d0, ("clamped", "paper")),
        ("warp", config.warp, ("smooth", "linear")),
    ):
        if value not in known:
            raise ConfigError(f"got {key} = {value!r}, expected {' or '.join(known)}")
    if config.culling not in ("none", "paper", "binned"):
        raise ConfigError(f"got culling = {config.culling!r}, expected none, paper or binned")
    _IN_RANGE[id(config)] = config


def validate_start(graph: MotionGraph, tables: EdgeTables, node: int, attack: Attack) -> None:
    """Raises unless there is such a node and the attack begins outside the body that stands there.

    Raises:
        ConfigError: no such node.
        AttackError: the attack is not finite, or begins inside the body.
    """
    if not 0 <= node < graph.num_nodes:
        raise ConfigError(f"got node {node}, expected 0 … {graph.num_nodes - 1}")
    validate_attack(attack)
    begin = _beginning(attack)
    gaps = [math.hypot(*c) - r for c, r in zip(begin.tolist(), attack.radii.tolist(), strict=True)]
    if min(gaps) > _farthest(tables):
        return
    spheres = tables.spheres
    # Every edge out of a node begins with the body as it stands there, in the node's frame.
    body = tables.pool[tables.pool_first[graph.edges_from(node)[0]]].reshape(3, -1)
    way = body[:, None] - begin.T[..., None]
    gap = np.sqrt((way * way).sum(axis=0)) - (attack.radii[:, None] + spheres.radii)
    least = gap.min()
    if least < 0:
        where = spheres.names[int(np.argmin(gap.min(axis=0)))]
        raise AttackError(
            f"got an attack that starts {-least:.3f} m inside the body ({where}),"
            " expected one that starts outside"
        )


def _beginning(attack: Attack) -> Float[np.ndarray, "I 3"]:
    """Where the centres are at the first moment that matters."""
    if attack.start >= 0 and attack.starts is None and attack.stops is None:
        return attack.centres[0]
    return attack.at(np.array([max(attack.start, 0.0)]))[0]


@lru_cache(maxsize=8)
def _farthest(tables: EdgeTables) -> float:
    """How far from a node a body that stands there may be, m, and a millimetre more."""
    bodies = tables.pool[tables.pool_first].reshape(len(tables.pool_first), 3, -1)
    return float((np.linalg.norm(bodies, axis=1) + tables.spheres.radii).max(initial=0.0)) + 1e-3
