"""Ball sport: hit motions found in capture, matched to a live motion, and the ball between players.

After Choi, Kim, Kim and Kang, *Generating a Ball Sport Scene in a Virtual Environment* (2019).
"""

from __future__ import annotations

import importlib
from typing import Any

_HOMES: dict[str, str] = {
    "Aim": "mgjax.ballsport.aiming.solve",
    "AnalysisConfig": "mgjax.ballsport.config",
    "BallPhysics": "mgjax.ballsport.ball.physics",
    "ClipSet": "mgjax.ballsport.clipset.build",
    "ClipSetConfig": "mgjax.ballsport.config",
    "HitChoice": "mgjax.ballsport.aiming.hit_frame",
    "HitStream": "mgjax.ballsport.hits.stream",
    "LiveAnalysis": "mgjax.ballsport.hits.bones",
    "LiveDriver": "mgjax.ballsport.live.recogniser",
    "MatchConfig": "mgjax.ballsport.config",
    "Matcher": "mgjax.ballsport.clipset.match",
    "Rally": "mgjax.ballsport.scene.rally",
    "SceneConfig": "mgjax.ballsport.scene.config",
    "build_scene": "mgjax.ballsport.scene.build",
    "prepare_scene": "mgjax.ballsport.scene.build",
    "Net": "mgjax.ballsport.ball.physics",
    "PassDecision": "mgjax.ballsport.live.recogniser",
    "ReplayConfig": "mgjax.sensor.config",
    "SensorChoice": "mgjax.ballsport.live.choice",
    "SensorReceiver": "mgjax.sensor.receiver",
    "TransitionConfig": "mgjax.ballsport.config",
    "aim": "mgjax.ballsport.aiming.passes",
    "aim_batch": "mgjax.ballsport.aiming.passes",
    "analyse": "mgjax.ballsport.hits.bones",
    "ball_states": "mgjax.ballsport.ball.trajectory",
    "build_clip_set": "mgjax.ballsport.clipset.build",
    "choose_frame": "mgjax.ballsport.aiming.hit_frame",
    "contact_times": "mgjax.ballsport.ball.trajectory",
    "find_hits": "mgjax.ballsport.hits.detect",
    "find_transitions": "mgjax.ballsport.clipset.transition",
    "fly": "mgjax.ballsport.ball.trajectory",
    "join": "mgjax.ballsport.clipset.joining",
    "motion_vector": "mgjax.ballsport.hits.motion_vectors",
    "replay": "mgjax.sensor.replay",
}
__all__ = list(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mgjax.ballsport' has no attribute {name!r}")
