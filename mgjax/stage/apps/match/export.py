"""The match so far as files: what ``mgjax scene`` writes, in one archive, or a page to play it."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from mgjax.ballsport.scene.ball_track import csv_text
from mgjax.ballsport.scene.report import scene_json
from mgjax.io.bvh.write import save_bvh
from mgjax.stage.apps.match.game import Game
from mgjax.stage.apps.match.passes import PassMade
from mgjax.stage.html import page_html
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Show

FILES = ("zip", "html")
"""What can be saved."""


def exported(game: Game, kind: str) -> tuple[str, str, bytes]:
    """Name, type and bytes of a file.

    Raises:
        ConfigError: nothing has been played yet.
    """
    if kind == "html":
        return "match.html", "text/html", page_html(match_show(game)).encode()
    return "match.zip", "application/zip", _archive(game)


def match_show(game: Game) -> Show:
    """All that has been played.

    Raises:
        ConfigError: nothing has been played yet.
    """
    scene, opening = game.scene.scene(), game.opening(game.scene.part(0, 1))
    actors = [replace(actor, frames=frames_of(scene.motions[actor.id])) for actor in opening.actors]
    return replace(
        opening,
        seconds=(len(scene.ball.places) - 1) / scene.frame_rate,
        words=words_of(game.passes),
        actors=actors,
        balls=game.balls(whole=True),
        spans=game.rows(whole=True),
        notes=game.table(),
    )


def words_of(passes: Sequence[PassMade]) -> str:
    """A sentence on all passes."""
    real = [p for p in passes if p.by and p.to]
    missed = sum(bool(p.status) for p in real)
    return f"{len(real)} passes, {missed} of them missed"


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
