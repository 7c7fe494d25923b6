"""``mgjax sensor replay`` and ``mgjax sensor listen``."""

from __future__ import annotations

import math
import sys
from dataclasses import asdict
from typing import Any

from mgjax.ballsport.clipset.build import build_clip_set
from mgjax.ballsport.live.config import ListenConfig, validate_listen
from mgjax.ballsport.live.recogniser import LiveDriver, PassDecision
from mgjax.cli.arguments import Listen, Replay, Sensor
from mgjax.cli.reading import read_as_of
from mgjax.cli.report import emit, to_json
from mgjax.core.errors import ConfigError
from mgjax.io.load import load_motion
from mgjax.io.output import output_folder
from mgjax.io.toml_file import load_config
from mgjax.sensor.config import ReplayConfig
from mgjax.sensor.receiver import SensorReceiver
from mgjax.sensor.replay import replay as send


def run(command: Sensor) -> None:
    """Plays a file as a sensor, or listens to one."""
    action = command.action
    if isinstance(action, Replay):
        replay(action)
    else:
        listen(action)


def replay(command: Replay) -> None:
    """Sends a file."""
    skeleton, motion = load_motion(command.file, read_as=read_as_of(command, command.roles))
    config = ReplayConfig(
        rate=command.rate,
        speed=command.speed,
        loss=command.loss,
        reorder=command.reorder,
        jitter_s=command.jitter,
        seed=command.seed,
    )
    sent = send(skeleton, motion, host=command.host, port=command.port, config=config)
    result: dict[str, Any] = {
        "file": str(command.file),
        "host": command.host,
        "port": command.port,
        "frames": sent.frames,
        "packets": sent.packets,
        "lost": sent.lost,
        "seconds": sent.seconds,
        "late_s": sent.late_s,
    }
    if command.out is not None:
        with output_folder(command.out) as folder:
            (folder / "replay.json").write_text(to_json(result) + "\n")
    line = (
        f"{command.file}: {sent.frames} frames sent to {command.host}:{command.port} in"
        f" {sent.seconds:.2f} s, {sent.packets} packets and {sent.lost} lost, at most"
        f" {1000 * sent.late_s:.1f} ms late"
    )
    emit(result, [line], as_json=command.json)


def listen(command: Listen) -> None:
    """Prints one line for each kick as it is decided; with ``--json`` one object at the end."""
    if not 0 < command.seconds < math.inf:
        raise ConfigError(f"got --seconds {command.seconds:g}, expected more than 0")
    config = load_config(command.config, ListenConfig) if command.config else ListenConfig()
    validate_listen(config)
    kicks: list[dict[str, Any]] = []

    def take(decisions: list[PassDecision]) -> None:
        for decision in decisions:
            clip = clips.clip_names[int(clips.hit_clip[decision.hit])]
            kicks.append({**asdict(decision), "clip": clip})
            if not command.json:
                print(to_json(kicks[-1]), flush=True)

    with SensorReceiver(command.host, command.port) as receiver:
        clips = build_clip_set(config=config.clip_set, seed=config.seed, takes=config.takes)
        driver = LiveDriver(clips, bones=config.bones, analysis=config.analysis, match=config.match)
        print(f"listening on {command.host}:{receiver.port}", file=sys.stderr, flush=True)
        for frame in receiver.frames(command.seconds):
            take(driver.push(frame))
        take(driver.finish())
        counts = receiver.counts
    result = {"kicks": kicks, "received": asdict(counts)}
    if command.out is not None:
        with output_folder(command.out) as folder:
            (folder / "kicks.json").write_text(to_json(result) + "\n")
    if command.json:
        emit(result, [], as_json=True)
    else:
        print(f"{counts.frames} frames, {len(kicks)} kicks; {counts}", file=sys.stderr)
