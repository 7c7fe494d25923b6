"""The match so far as files: what ``mgjax scene`` writes, in one archive."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from pathlib import Path

from mgjax.ballsport.scene.ball_track import csv_text
from mgjax.ballsport.scene.report import scene_json
from mgjax.io.bvh.write import save_bvh
from mgjax.stage.apps.match.game import Game

FILES = ("zip",)
"""What can be saved."""


def exported(game: Game, kind: str) -> tuple[str, str, bytes]:
    """Name, type and bytes of a file.

    Raises:
        ConfigError: nothing has been played yet.
    """
    return "match.zip", "application/zip", _archive(game)


def _archive(game: Game) -> bytes:
    """A BVH file for each player, the ball's path and the timeline."""
    scene = game.scene.scene()
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        with tempfile.TemporaryDirectory() as folder:
            for name, motion in scene.motions.items():
                path = Path(folder) / f"{name}.bvh"
                save_bvh(path, scene.skeleton, motion)
                archive.write(path, path.name)
        archive.writestr("ball.csv", csv_text(scene.ball, scene.frame_rate))
        archive.writestr("timeline.json", json.dumps(scene_json(scene), allow_nan=False) + "\n")
    return out.getvalue()
