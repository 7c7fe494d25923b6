"""Ball sport: hit motions found in capture, matched to a live motion, and the ball between players.

After Choi, Kim, Kim and Kang, *Generating a Ball Sport Scene in a Virtual Environment* (2019).
"""

from __future__ import annotations

import importlib
from typing import Any

_HOMES: dict[str, str] = {
    "Aim": "mgjax.ballsport.aim_solve",
    "AnalysisConfig": "mgjax.ballsport.config",
    "BallPhysics": "mgjax.ballsport.ball",
    "ClipSet": "mgjax.ballsport.clip_set",
    "ClipSetConfig": "mgjax.ballsport.config",
    "HitChoice": "mgjax.ballsport.aim_frame",
    "HitStream": "mgjax.ballsport.hits_stream",
    "LiveAnalysis": "mgjax.ballsport.analysis",
    "LiveDriver": "mgjax.ballsport.live",
    "MatchConfig": "mgjax.ballsport.config",
    "Matcher": "mgjax.ballsport.match",
    "Rally": "mgjax.ballsport.schedule",
    "SceneConfig": "mgjax.ballsport.scene_config",
    "build_scene": "mgjax.ballsport.scene",
    "prepare_scene": "mgjax.ballsport.scene",
    "Net": "mgjax.ballsport.ball",
    "PassDecision": "mgjax.ballsport.live",
    "ReplayConfig": "mgjax.ballsport.sensor_config",
    "SensorChoice": "mgjax.ballsport.live_scene",
    "SensorReceiver": "mgjax.ballsport.sensor",
    "TransitionConfig": "mgjax.ballsport.config",
    "aim": "mgjax.ballsport.aiming",
    "aim_batch": "mgjax.ballsport.aiming",
    "analyse": "mgjax.ballsport.analysis",
    "ball_states": "mgjax.ballsport.trajectory",
    "build_clip_set": "mgjax.ballsport.clip_set",
    "choose_frame": "mgjax.ballsport.aim_frame",
    "contact_times": "mgjax.ballsport.trajectory",
    "find_hits": "mgjax.ballsport.hits",
    "find_transitions": "mgjax.ballsport.transition",
    "fly": "mgjax.ballsport.trajectory",
    "join": "mgjax.ballsport.joining",
    "motion_vector": "mgjax.ballsport.key_poses",
    "replay": "mgjax.ballsport.sensor_replay",
}
__all__ = list(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mgjax.ballsport' has no attribute {name!r}")
