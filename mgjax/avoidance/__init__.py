"""Avoidance: the walk that gets a character out of the way with the least movement.

After Oshita and Masaoka, *Generating Avoidance Motion Using Motion Graph* (2011).
"""

from __future__ import annotations

import importlib
from typing import Any

_HOMES = {
    "Attack": "mgjax.avoidance.attack",
    "AvoidanceConfig": "mgjax.avoidance.config",
    "BatchSelection": "mgjax.avoidance.batch",
    "Choice": "mgjax.avoidance.answer",
    "Coverage": "mgjax.avoidance.coverage",
    "Energies": "mgjax.avoidance.energy",
    "EnergyConfig": "mgjax.avoidance.energy",
    "Planner": "mgjax.avoidance.planner",
    "Selection": "mgjax.avoidance.selection",
    "SpeedConfig": "mgjax.avoidance.config",
    "ball_attack": "mgjax.avoidance.attack",
    "build_index": "mgjax.avoidance.grid_build",
    "choose": "mgjax.avoidance.choice",
    "energies": "mgjax.avoidance.energy",
    "energies_batch": "mgjax.avoidance.energy",
    "limb_attack": "mgjax.avoidance.attack_limb",
    "load_attack": "mgjax.avoidance.attack_file",
    "load_index": "mgjax.avoidance.grid_index",
    "merge_attacks": "mgjax.avoidance.attack_merge",
    "save_index": "mgjax.avoidance.grid_index",
    "select": "mgjax.avoidance.selection",
    "select_batch": "mgjax.avoidance.batch",
    "sweep_energies": "mgjax.avoidance.sweep",
    "warm_up": "mgjax.avoidance.warm",
}
__all__ = list(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mgjax.avoidance' has no attribute {name!r}")
