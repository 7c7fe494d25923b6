"""Ball sport: hit motions found in capture, matched to a live motion, and the ball between players.

After Choi, Kim, Kim and Kang, *Generating a Ball Sport Scene in a Virtual Environment* (2019).
"""

from __future__ import annotations

import importlib
from typing import Any

_HOMES: dict[str, str] = {
    "Aim": "mgjax.ballsport.aim_solve",
    "BallPhysics": "mgjax.ballsport.ball",
    "HitChoice": "mgjax.ballsport.aim_frame",
    "Net": "mgjax.ballsport.ball",
    "aim": "mgjax.ballsport.aiming",
    "aim_batch": "mgjax.ballsport.aiming",
    "ball_states": "mgjax.ballsport.trajectory",
    "choose_frame": "mgjax.ballsport.aim_frame",
    "contact_times": "mgjax.ballsport.trajectory",
    "fly": "mgjax.ballsport.trajectory",
    "AnalysisConfig": "mgjax.ballsport.config",
    "ClipSetConfig": "mgjax.ballsport.config",
    "MatchConfig": "mgjax.ballsport.config",
    "TransitionConfig": "mgjax.ballsport.config",
    "find_hits": "mgjax.ballsport.hits",
    "HitStream": "mgjax.ballsport.hits_stream",
    "analyse": "mgjax.ballsport.analyse",
    "LiveAnalysis": "mgjax.ballsport.analyse",
    "motion_vector": "mgjax.ballsport.key_poses",
    "ClipSet": "mgjax.ballsport.clip_set",
    "build_clip_set": "mgjax.ballsport.clip_set",
    "find_transitions": "mgjax.ballsport.transition",
    "join": "mgjax.ballsport.join",
    "Matcher": "mgjax.ballsport.match",
}
__all__ = list(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mgjax.ballsport' has no attribute {name!r}")
