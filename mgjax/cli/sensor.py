"""``mgjax sensor replay``, ``mgjax sensor send`` and ``mgjax sensor listen``."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from mgjax.ballsport.clipset.build import build_clip_set
from mgjax.ballsport.live.config import ListenConfig, validate_listen
from mgjax.ballsport.live.recogniser import LiveDriver, PassDecision
from mgjax.cli.arguments import Listen, Replay, Send, Sensor
from mgjax.cli.files.reading import read_as_of
from mgjax.cli.report import emit, to_json
from mgjax.core.errors import ConfigError
from mgjax.core.motion import Motion, cut
from mgjax.core.skeleton import Skeleton
from mgjax.graph.files import load_graph
from mgjax.graph.walk import random_walk, unroll
from mgjax.io.load import load_motion
from mgjax.io.output import output_folder
from mgjax.io.toml_file import load_config
from mgjax.sensor.config import ReplayConfig
from mgjax.sensor.counts import Counts, why_nothing
from mgjax.sensor.frames import FrameSource, SensorFrame
from mgjax.sensor.receiver import SensorReceiver
from mgjax.sensor.replay import Replayed
from mgjax.sensor.replay import replay as play

_WALK_S = 30.0
"""How long a walk is sent where nothing is said."""
_LONGEST_S = 3600.0
SILENCE_S = 3.0
"""After so long without a frame ``listen`` says why."""


def run(command: Sensor) -> None:
    """Plays a file as a sensor, sends a motion, or listens to a sensor."""
    action = command.action
    if isinstance(action, Replay):
        replay(action)
    elif isinstance(action, Send):
        send(action)
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
    sent = play(skeleton, motion, host=command.host, port=command.port, config=config)
    report(command, str(command.file), sent, "replay.json")


def send(command: Send) -> None:
    """Sends a random walk of a graph, or a clip."""
    if (command.file is None) == (command.graph is None):
        given = "both" if command.file else "neither"
        raise ConfigError(f"got {given} of a file and --graph, expected one of them")
    if command.seconds is not None and not 0 < command.seconds <= _LONGEST_S:
        raise ConfigError(f"got --seconds {command.seconds:g}, expected 0 … {_LONGEST_S:g}")
    if command.graph is not None:
        source = str(command.graph)
        skeleton, motion = wander(command.graph, command.seconds or _WALK_S, command.seed)
    else:
        assert command.file is not None
        source = str(command.file)
        skeleton, motion = load_motion(command.file)
    if command.seconds is not None:
        frames = math.ceil(command.seconds * motion.frame_rate) + 1
        motion = cut(motion, 0, min(frames, motion.num_frames))
    config = ReplayConfig(rate=command.fps)
    sent = play(skeleton, motion, host=command.host, port=command.port, config=config)
    report(command, source, sent, "send.json")


def wander(folder: Path, seconds: float, seed: int) -> tuple[Skeleton, Motion]:
    """A random walk of a graph that begins at the origin and lasts so long, or a little longer."""
    graph = load_graph(folder)
    if not 0 <= seed < 2**63:
        raise ConfigError(f"got --seed {seed}, expected 0 … {2**63 - 1}")
    node = int(np.random.default_rng(seed).integers(graph.num_nodes))
    return graph.skeleton, unroll(graph, random_walk(graph, node, seconds, seed).edges)


def report(command: Replay | Send, source: str, sent: Replayed, name: str) -> None:
    """Prints, and writes where that is asked for, what was sent."""
    result: dict[str, Any] = {
        "file": source,
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
            (folder / name).write_text(to_json(result) + "\n")
    line = (
        f"{source}: {sent.frames} frames sent to {command.host}:{command.port} in"
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
        place = f"{command.host}:{receiver.port}"
        for frame in hear(receiver, command.seconds, place):
            take(driver.push(frame))
        take(driver.finish())
        counts = receiver.counts
    why = why_nothing(counts, place)
    result = {"kicks": kicks, "received": asdict(counts), "why_nothing": why}
    if command.out is not None:
        with output_folder(command.out) as folder:
            (folder / "kicks.json").write_text(to_json(result) + "\n")
    if command.json:
        emit(result, [], as_json=True)
    else:
        print(f"{counts.frames} frames, {len(kicks)} kicks; {counts}", file=sys.stderr)
        for line in (why, clock_note(counts)):
            if line:
                print(line, file=sys.stderr)


def hear(receiver: FrameSource, seconds: float, place: str) -> Iterator[SensorFrame]:
    """The frames that come; says why where none has come after a few seconds."""
    first = min(SILENCE_S, seconds)
    yield from receiver.frames(first)
    if seconds > first:
        if why := why_nothing(receiver.counts, place):
            print(f"after {first:g} s: {why}", file=sys.stderr, flush=True)
        yield from receiver.frames(seconds - first)


def clock_note(counts: Counts) -> str:
    """What was done about a sender's clock that does not tell the time; "" where it does."""
    if not counts.clock_fault:
        return ""
    return f"the sender's clock {counts.clock_fault}: frames have the times of their arrival"
