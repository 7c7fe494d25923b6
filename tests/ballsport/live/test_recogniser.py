"""From a sender to a decision, in simulated time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mgjax.ballsport.aiming.hit_frame import choose_frame
from mgjax.ballsport.clipset.build import ClipSet
from mgjax.ballsport.hits.bones import analyse
from mgjax.ballsport.live.recogniser import BRIDGE_S, LiveDriver, PassDecision
from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.clips.types import Clip
from mgjax.core.errors import ConfigError
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, cut
from mgjax.core.skeleton import Skeleton
from mgjax.io.load import load_motion
from mgjax.sensor.bone_table import JOINT_NAMES
from mgjax.sensor.bones import find_bones
from mgjax.sensor.config import ReplayConfig
from mgjax.sensor.frames import WAIT_S, SensorFrame
from tests.sensor.transport import Loopback


@pytest.fixture(scope="module")
def kicks() -> dict[str, Clip]:
    clips, _ = synthetic_kicks(seed=5, frame_rate=60.0, takes=1)
    return {clip.name: clip for clip in clips}


def live(
    clips: ClipSet, skeleton: Skeleton, motion: Motion, config: ReplayConfig
) -> tuple[list[PassDecision], list[SensorFrame], Loopback]:
    """What a replayed clip decides."""
    sent = Loopback(skeleton, motion, config)
    driver = LiveDriver(clips, clock=sent.clock)
    decided: list[PassDecision] = []
    frames: list[SensorFrame] = []
    for frame in sent.frames(1000.0):
        frames.append(frame)
        decided += driver.push(frame)
    return decided + driver.finish(), frames, sent


def offline(skeleton: Skeleton, motion: Motion) -> list[tuple[str, float, float]]:
    places = np.asarray(global_positions(skeleton, motion))
    rate = motion.frame_rate
    hits = analyse(skeleton, places, rate)
    return [(h.bone, h.hit.fastest / rate, (h.hit.stop - 1) / rate) for h in hits]


def check(
    decision: PassDecision, expected: tuple[str, float, float], late_s: float, speed: float
) -> None:
    """The kick that the clip has, and times that fit each other."""
    bone, fastest, end = expected
    assert decision.bone == bone
    assert abs(decision.fastest_s - fastest) < 0.05
    assert abs(decision.end_s - end) < 0.1
    assert decision.start_s < decision.fastest_s <= decision.end_s <= decision.decided_s
    assert decision.decided_s - decision.fastest_s < 2.0
    waited = (decision.decided_s - decision.end_s) / speed
    assert 0 < decision.compute_s < decision.latency_s < decision.latency_from_fastest_s
    # Nothing takes time here but the frames' coming, each late by so much at most.
    assert waited - late_s - 0.02 < decision.latency_s < waited + late_s + 0.05


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_made_kick_decides_a_pass(made_set: ClipSet, kicks: dict[str, Clip], side: str) -> None:
    clip = kicks[f"kick_attack_{side}"]
    config = ReplayConfig(speed=2.0)
    decided, frames, sent = live(made_set, clip.skeleton, clip.motion, config)
    (expected,) = offline(clip.skeleton, clip.motion)
    (decision,) = decided
    assert expected[0] == f"{side}_foot"
    check(decision, expected, 0.0, 2.0)
    assert decision.kind == made_set.hit_kind[decision.hit] == "attack"
    assert made_set.hit_bone[decision.hit] == decision.bone
    # The pass: the stored hit sends a ball to a receiver 6 m ahead, with one bounce.
    path, velocity = made_set.bone_path(decision.hit)
    way = velocity[np.argmax(np.linalg.norm(velocity, axis=1))] * [1, 0, 1]
    target = path[0] * [1, 0, 1] + 6 * way / np.linalg.norm(way) + [0, 0.3, 0]
    chosen = choose_frame(
        path.astype(np.float32), velocity.astype(np.float32), target.astype(np.float32), bounces=1
    )
    assert int(chosen.aim.status) == 0
    # Without loss all joints stand where they stood in the clip.
    places = np.asarray(global_positions(clip.skeleton, clip.motion))
    joints = [clip.skeleton.index(name) for name in frames[0].body.names]
    assert (sent.recording.frames, sent.recording.lost) == (clip.motion.num_frames, 0)
    assert sent.counts.malformed == sent.counts.unknown == 0
    for frame in frames:
        number = round(frame.time_s * 60)
        np.testing.assert_allclose(frame.positions, places[number, joints], atol=1e-4)


def test_loss_reorder_and_jitter(made_set: ClipSet, kicks: dict[str, Clip]) -> None:
    clip = kicks["kick_attack_right"]
    config = ReplayConfig(speed=2.0, loss=0.15, reorder=0.1, jitter_s=0.005, seed=1)
    decided, frames, sent = live(made_set, clip.skeleton, clip.motion, config)
    (expected,) = offline(clip.skeleton, clip.motion)
    (decision,) = decided
    # Half a period after the next frame, jittered; and bones that are lost are waited for.
    check(decision, expected, 1.5 / 120 + config.jitter_s + WAIT_S / 2, 2.0)
    assert sent.recording.lost > 0
    assert sent.counts.datagrams == sent.recording.packets
    assert any(frame.held for frame in frames)
    times = [frame.time_s for frame in frames]
    assert times == sorted(set(times))


def test_real_kick(made_set: ClipSet, capture: Path) -> None:
    """A captured kick at real time: the right foot, and where and when it was."""
    skeleton, motion = load_motion(capture / "ball/cmu10/10_02.amc")
    motion = cut(motion, 216, 480)  # 1.8 … 4 s
    decided, frames, _ = live(made_set, skeleton, motion, ReplayConfig())
    (expected,) = offline(skeleton, motion)
    (decision,) = decided
    assert decision.bone == expected[0] == "right_foot"
    assert abs(decision.fastest_s + 1.8 - 2.92) < 0.1  # as labelled
    check(decision, expected, 0.0, 1.0)
    places = np.asarray(global_positions(skeleton, motion))
    joint = {JOINT_NAMES[bone]: joint for bone, joint in find_bones(skeleton).items()}
    joints = [joint[name] for name in frames[0].body.names]
    worst = max(
        float(np.abs(f.positions - places[round(f.time_s * 120), joints]).max()) for f in frames
    )
    assert worst < 1e-4


def frames_of(clip: Clip, *, first_stream: int = 1) -> list[SensorFrame]:
    """A clip as frames without a sender."""
    places = np.asarray(global_positions(clip.skeleton, clip.motion))
    turns = np.asarray(clip.motion.local_rotations)
    return [
        SensorFrame(
            time_s=k / 60, arrival_s=k / 60, stream=first_stream, body=clip.skeleton,
            positions=place, rotations=turns[k], held=0,
        )
        for k, place in enumerate(places)
    ]  # fmt: skip


def test_a_new_stream_finishes_the_old(made_set: ClipSet, kicks: dict[str, Clip]) -> None:
    clip = kicks["kick_pass_left"]
    driver = LiveDriver(made_set)
    assert driver.finish() == []
    end = offline(clip.skeleton, clip.motion)[0][2]
    short = frames_of(clip)[: round(end * 60) + 5]
    assert [d for frame in short for d in driver.push(frame)] == []
    (decision,) = driver.push(frames_of(clip, first_stream=2)[0])
    assert (decision.bone, decision.kind) == ("left_foot", "pass")
    rest = frames_of(clip, first_stream=2)[1:]
    assert len([d for frame in rest for d in driver.push(frame)] + driver.finish()) == 1


def test_held_and_missing_frames_are_bridged(made_set: ClipSet, kicks: dict[str, Clip]) -> None:
    clip = kicks["kick_attack_right"]
    clean = frames_of(clip)
    (expected,) = decide(made_set, clean)
    spoiled: list[SensorFrame] = []
    for k, frame in enumerate(clean):
        if k % 3 == 1:
            continue
        if k % 6 == 3:  # a foot that has stayed behind
            positions = np.asarray(frame.positions + 0.5)
            values = {**vars(frame), "positions": positions, "held": 2}
            frame = SensorFrame(**values)
        spoiled.append(frame)
    (decision,) = decide(made_set, spoiled)
    assert (decision.bone, decision.kind) == (expected.bone, expected.kind)
    assert abs(decision.speed_m_s - expected.speed_m_s) < 0.1 * expected.speed_m_s
    assert abs(decision.fastest_s - expected.fastest_s) < 0.04
    # A bone that is gone for good is not waited for.
    gone = [SensorFrame(**{**vars(frame), "held": 1}) for frame in clean]
    decisions = decide(made_set, gone)
    assert decisions
    assert all(abs(d.fastest_s - expected.fastest_s) < BRIDGE_S for d in decisions)


def decide(clips: ClipSet, frames: list[SensorFrame]) -> list[PassDecision]:
    driver = LiveDriver(clips)
    return [d for frame in frames for d in driver.push(frame)] + driver.finish()


def test_a_driver_needs_hits_of_its_bones(made_set: ClipSet) -> None:
    with pytest.raises(ConfigError, match="no stored hit of head"):
        LiveDriver(made_set, bones=("head",))
