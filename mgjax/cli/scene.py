"""``mgjax scene``."""

from __future__ import annotations

import math
import sys
from dataclasses import asdict
from typing import Any

from mgjax.ballsport.live.choice import SensorChoice
from mgjax.ballsport.scene.ball_track import csv_text
from mgjax.ballsport.scene.build import Scene as BallScene
from mgjax.ballsport.scene.build import build_scene, prepare_scene
from mgjax.ballsport.scene.config import SceneConfig
from mgjax.ballsport.scene.file import load_scene
from mgjax.ballsport.scene.report import scene_json
from mgjax.cli.arguments import Scene
from mgjax.cli.report import emit, to_json
from mgjax.core.errors import ConfigError
from mgjax.io.bvh.write import save_bvh
from mgjax.io.output import output_folder
from mgjax.pictures.scene import scene_picture
from mgjax.sensor.receiver import SensorReceiver
from mgjax.stage.html import save_html


def run(command: Scene) -> None:
    """Makes the scene and writes what came of it."""
    config = load_scene(command.config)
    with output_folder(command.out) as folder:
        scene, decided = _live(command, config) if command.live else (build_scene(config), [])
        result = scene_json(scene)
        if command.live:
            result["decided_live"] = decided
        for name, motion in scene.motions.items():
            save_bvh(folder / f"{name}.bvh", scene.skeleton, motion)
        (folder / "ball.csv").write_text(csv_text(scene.ball, scene.frame_rate))
        (folder / "timeline.json").write_text(to_json(result) + "\n")
        scene_picture(folder / "scene.png", scene)
        if command.html:
            save_html(folder / "index.html", scene)
    emit(result, [describe(result), f"written to {command.out}"], as_json=command.json)


def _live(command: Scene, config: SceneConfig) -> tuple[BallScene, list[dict[str, Any]]]:
    """The scene with passes decided by kicks that a sensor sees, and those kicks."""
    assert command.live is not None
    if not 0 < command.live < math.inf:
        raise ConfigError(f"got --live {command.live:g}, expected more than 0 s")
    with SensorReceiver(command.host, command.port) as receiver:
        moves = prepare_scene(config)
        choice = SensorChoice(
            moves, receiver, command.live, analysis=config.analysis, match=config.match
        )
        print(f"listening on {command.host}:{receiver.port}", file=sys.stderr, flush=True)
        scene = build_scene(config, moves=moves, choose=choice)
    return scene, [{"touch": touch, **asdict(kick)} for touch, kick in choice.taken]


def describe(result: dict[str, Any]) -> str:
    """A few lines for people."""
    worst = result["worst"]
    lines = [
        f"{result['passes_made']} passes in {result['seconds']:.1f} s,"
        f" {result['passes_missed']} missed; the ball arrives within"
        f" {1000 * worst['arrival_miss_m']:.2f} mm, its surface within"
        f" {1000 * worst['surface_gap_m']:.2f} mm of the foot's",
        f"kicks changed by {100 * result['mean_kick_change']:.0f} % of the bone's speed,"
        f" {100 * worst['kick_change']:.0f} % at most; pace of the links"
        f" {worst['time_warp']:.2f} at most, seams up to {worst['seam_speed_m_s']:.1f} m/s",
    ]
    lines += [
        f"pass {row['pass']} from {row['by']} to {row['to']}: {row['status']},"
        f" {row['miss_m']:.2f} m off"
        for row in result["passes"]
        if "arrival_miss_m" not in row
    ]
    return "\n".join(lines)
