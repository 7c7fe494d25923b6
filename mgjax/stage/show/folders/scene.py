"""A folder of ``scene``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mgjax.ballsport.ball.physics import Net
from mgjax.core.errors import FileFormatError
from mgjax.io.load import load_motion
from mgjax.io.text import read_text
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.scene import COLOURS, net_things, pass_spans, scene_notes, scene_words
from mgjax.stage.show.standing import standing
from mgjax.stage.show.types import Actor, Ball, Show


def scene_folder(path: Path, report: dict[str, Any]) -> Show:
    """``timeline.json``, ``ball.csv`` and one BVH file for each player, of ``mgjax scene``."""
    actors: list[Actor] = []
    body = None
    seconds = 0.0
    for number, player in enumerate(report["players"]):
        name = str(player["name"])
        file = Path(str(player["file"])).name  # never a path out of the folder
        skeleton, motion = standing(*load_motion(path / file))
        body = body or body_of(skeleton)
        seconds = max(seconds, (motion.num_frames - 1) / motion.frame_rate)
        colour = COLOURS[number % len(COLOURS)]
        actors.append(Actor(id=name, body=0, frames=frames_of(motion), colour=colour, note=name))
    if body is None:
        raise FileFormatError(path / "timeline.json", None, "no players", "at least one")
    net = report["net"]
    return Show(
        title="Passing a ball",
        words=scene_words(report),
        seconds=seconds,
        bodies=[body],
        actors=actors,
        balls=[_ball(path / "ball.csv", float(report["ball_radius_m"]))],
        things=net_things(None if net is None else Net(**net)),
        spans=pass_spans(report),
        notes=scene_notes(report),
        moments=[
            (f"{event['player']} misses", float(event["t"]))
            for event in report["events"]
            if event["event"] == "miss"
        ],
    )


def _ball(path: Path, radius: float) -> Ball:
    lines = read_text(path, "CSV").splitlines()
    try:
        rows = np.array([[float(x) for x in line.split(",")[:4]] for line in lines[1:]])
        rows = rows.reshape(-1, 4)
    except ValueError:
        raise FileFormatError(path, None, "rows that are no numbers", "t,x,y,z,event") from None
    if not len(rows):
        raise FileFormatError(path, None, "no rows", "t,x,y,z,event")
    return Ball(id="ball", radius=radius, times=rows[:, 0], places=rows[:, 1:], colour="yellow")
