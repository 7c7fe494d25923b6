"""Avoidance: the walk that gets a character out of the way with the least movement.

After Oshita and Masaoka, *Generating Avoidance Motion Using Motion Graph* (2011).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mgjax._lazy import attach

if TYPE_CHECKING:
    from mgjax.avoidance.attacks.attack import Attack as Attack
    from mgjax.avoidance.attacks.ball import ball_attack as ball_attack
    from mgjax.avoidance.attacks.crop import Crop as Crop
    from mgjax.avoidance.attacks.json_file import load_attack as load_attack
    from mgjax.avoidance.attacks.limb import limb_attack as limb_attack
    from mgjax.avoidance.attacks.merge import merge_attacks as merge_attacks
    from mgjax.avoidance.candidates.enumerate import Candidates as Candidates
    from mgjax.avoidance.checks.written import SphereTrajectory as SphereTrajectory
    from mgjax.avoidance.choice.choosing import choose as choose
    from mgjax.avoidance.choice.compile_ahead import warm_up as warm_up
    from mgjax.avoidance.choice.explain import Explained as Explained
    from mgjax.avoidance.choice.explain import Explanation as Explanation
    from mgjax.avoidance.choice.explain import explain as explain
    from mgjax.avoidance.choice.results import Choice as Choice
    from mgjax.avoidance.choice.results import Dropped as Dropped
    from mgjax.avoidance.choice.results import Status as Status
    from mgjax.avoidance.choice.selection import Selection as Selection
    from mgjax.avoidance.choice.selection import refine as refine
    from mgjax.avoidance.choice.selection import select as select
    from mgjax.avoidance.config import AvoidanceConfig as AvoidanceConfig
    from mgjax.avoidance.config import SpeedConfig as SpeedConfig
    from mgjax.avoidance.coverage.report import coverage_report as coverage_report
    from mgjax.avoidance.coverage.throws import Coverage as Coverage
    from mgjax.avoidance.coverage.throws import measure_coverage as measure_coverage
    from mgjax.avoidance.energy.clearance import Clearance as Clearance
    from mgjax.avoidance.energy.clearance import clearance as clearance
    from mgjax.avoidance.energy.energies import Energies as Energies
    from mgjax.avoidance.energy.energies import EnergyConfig as EnergyConfig
    from mgjax.avoidance.energy.energies import energies as energies
    from mgjax.avoidance.energy.energies import energies_batch as energies_batch
    from mgjax.avoidance.energy.score import Energy as Energy
    from mgjax.avoidance.energy.score import Measures as Measures
    from mgjax.avoidance.energy.score import Scores as Scores
    from mgjax.avoidance.energy.score import score as score
    from mgjax.avoidance.energy.soft import soft_energies as soft_energies
    from mgjax.avoidance.index.build import build_index as build_index
    from mgjax.avoidance.index.files import load_index as load_index
    from mgjax.avoidance.index.files import save_index as save_index
    from mgjax.avoidance.index.found_paths import FoundPaths as FoundPaths
    from mgjax.avoidance.index.index import GridIndex as GridIndex
    from mgjax.avoidance.index.protocol import CandidateIndex as CandidateIndex
    from mgjax.avoidance.many.attacks import BatchSelection as BatchSelection
    from mgjax.avoidance.many.attacks import select_batch as select_batch
    from mgjax.avoidance.many.settings import Swept as Swept
    from mgjax.avoidance.many.settings import sweep_energies as sweep_energies
    from mgjax.avoidance.parry.parry import Parry as Parry
    from mgjax.avoidance.play.answers import Answer as Answer
    from mgjax.avoidance.play.planner import Planner as Planner
    from mgjax.avoidance.prepared import Prepared as Prepared
    from mgjax.avoidance.prepared import prepare as prepare
    from mgjax.avoidance.refinement.refinement import Refinement as Refinement
    from mgjax.core.timing.time_warp import TimeWarp as TimeWarp
else:
    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "coverage_report": "mgjax.avoidance.coverage.report",
            "measure_coverage": "mgjax.avoidance.coverage.throws",
            "CandidateIndex": "mgjax.avoidance.index.protocol",
            "Status": "mgjax.avoidance.choice.results",
            "prepare": "mgjax.avoidance.prepared",
            "Prepared": "mgjax.avoidance.prepared",
            "Answer": "mgjax.avoidance.play.answers",
            "explain": "mgjax.avoidance.choice.explain",
            "Explanation": "mgjax.avoidance.choice.explain",
            "Explained": "mgjax.avoidance.choice.explain",
            "Attack": "mgjax.avoidance.attacks.attack",
            "AvoidanceConfig": "mgjax.avoidance.config",
            "ball_attack": "mgjax.avoidance.attacks.ball",
            "BatchSelection": "mgjax.avoidance.many.attacks",
            "build_index": "mgjax.avoidance.index.build",
            "Candidates": "mgjax.avoidance.candidates.enumerate",
            "Choice": "mgjax.avoidance.choice.results",
            "clearance": "mgjax.avoidance.energy.clearance",
            "Clearance": "mgjax.avoidance.energy.clearance",
            "choose": "mgjax.avoidance.choice.choosing",
            "Coverage": "mgjax.avoidance.coverage.throws",
            "Crop": "mgjax.avoidance.attacks.crop",
            "Dropped": "mgjax.avoidance.choice.results",
            "Energies": "mgjax.avoidance.energy.energies",
            "energies": "mgjax.avoidance.energy.energies",
            "energies_batch": "mgjax.avoidance.energy.energies",
            "soft_energies": "mgjax.avoidance.energy.soft",
            "Energy": "mgjax.avoidance.energy.score",
            "Measures": "mgjax.avoidance.energy.score",
            "Scores": "mgjax.avoidance.energy.score",
            "score": "mgjax.avoidance.energy.score",
            "EnergyConfig": "mgjax.avoidance.energy.energies",
            "FoundPaths": "mgjax.avoidance.index.found_paths",
            "GridIndex": "mgjax.avoidance.index.index",
            "limb_attack": "mgjax.avoidance.attacks.limb",
            "load_attack": "mgjax.avoidance.attacks.json_file",
            "load_index": "mgjax.avoidance.index.files",
            "merge_attacks": "mgjax.avoidance.attacks.merge",
            "Parry": "mgjax.avoidance.parry.parry",
            "Planner": "mgjax.avoidance.play.planner",
            "refine": "mgjax.avoidance.choice.selection",
            "Refinement": "mgjax.avoidance.refinement.refinement",
            "save_index": "mgjax.avoidance.index.files",
            "select": "mgjax.avoidance.choice.selection",
            "select_batch": "mgjax.avoidance.many.attacks",
            "Selection": "mgjax.avoidance.choice.selection",
            "SpeedConfig": "mgjax.avoidance.config",
            "sweep_energies": "mgjax.avoidance.many.settings",
            "Swept": "mgjax.avoidance.many.settings",
            "TimeWarp": "mgjax.core.timing.time_warp",
            "SphereTrajectory": "mgjax.avoidance.checks.written",
            "warm_up": "mgjax.avoidance.choice.compile_ahead",
        },
    )
