"""Avoidance: the walk that gets a character out of the way with the least movement.

After Oshita and Masaoka, *Generating Avoidance Motion Using Motion Graph* (2011).
"""

from __future__ import annotations

import importlib
from typing import Any

_HOMES = {
    "Attack": "mgjax.avoidance.attacks.attack",
    "AvoidanceConfig": "mgjax.avoidance.config",
    "BatchSelection": "mgjax.avoidance.many.attacks",
    "Choice": "mgjax.avoidance.choice.results",
    "Coverage": "mgjax.avoidance.coverage.throws",
    "Energies": "mgjax.avoidance.energy.energies",
    "EnergyConfig": "mgjax.avoidance.energy.energies",
    "Planner": "mgjax.avoidance.play.planner",
    "Selection": "mgjax.avoidance.choice.selection",
    "SpeedConfig": "mgjax.avoidance.config",
    "ball_attack": "mgjax.avoidance.attacks.ball",
    "build_index": "mgjax.avoidance.index.build",
    "choose": "mgjax.avoidance.choice.choosing",
    "energies": "mgjax.avoidance.energy.energies",
    "energies_batch": "mgjax.avoidance.energy.energies",
    "limb_attack": "mgjax.avoidance.attacks.limb",
    "load_attack": "mgjax.avoidance.attacks.json_file",
    "load_index": "mgjax.avoidance.index.files",
    "merge_attacks": "mgjax.avoidance.attacks.merge",
    "Prepared": "mgjax.avoidance.prepared",
    "prepare": "mgjax.avoidance.prepared",
    "save_index": "mgjax.avoidance.index.files",
    "select": "mgjax.avoidance.choice.selection",
    "select_batch": "mgjax.avoidance.many.attacks",
    "sweep_energies": "mgjax.avoidance.many.settings",
    "warm_up": "mgjax.avoidance.choice.compile_ahead",
}
__all__ = list(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mgjax.avoidance' has no attribute {name!r}")
