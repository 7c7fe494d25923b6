"""The procedural motion set that comes with the package: stance, steps, walks and avoidance."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BPoly
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from mgjax.clips import synthetic_skeleton as body
from mgjax.clips.procedural.gestures import LAG_S, ease
from mgjax.clips.procedural.life import Smooth, answer_steps, breathe, couple_gait, swing_arms
from mgjax.clips.procedural.score import Score, Step
from mgjax.clips.procedural.scripts import SCRIPTS
from mgjax.clips.procedural.verbs import VERBS
from mgjax.clips.synthetic_skeleton import CHANNELS, Foot, synthetic_skeleton
from mgjax.clips.types import Clip, Label
from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.core.errors import MotionError
from mgjax.core.motion import Motion

__all__ = ["synthetic_clips", "synthetic_skeleton"]

TOTAL_S = 208.0
_FINE_HZ = 120.0
"""Trajectories are made on a grid at least this fine, then every n-th point is a frame."""
_EDGE_S = 0.6
"""Idle sway fades over this time at both ends, so that all clips begin and end in one pose."""
_REACH_M = 0.846
"""Longest distance from hip to ankle that the pelvis leaves to a planted foot; 0.85 is straight."""
_SHIFT_EARLY = 0.45
"""The weight goes over to the standing foot so long before the other one leaves, in swings."""
_TOE_OUT = np.radians(8.0)
_LENGTHS = {"side", "up", "fore"}
_ARMS_DEG = {"flex": 4.0, "open": 9.0, "turn": 25.0, "elbow": 22.0}
_NEUTRAL_DEG = {"bend": 4.0, **{f"{n}_{side}": a for n, a in _ARMS_DEG.items() for side in "lr"}}
_IDLE_TORSO = {"bend": 0.9, "lean": 0.8, "twist": 1.2, "look": 3.5, "nod": 1.5}
_IDLE_ARMS = {"flex_l": 1.5, "flex_r": 1.5, "elbow_l": 2.0, "elbow_r": 2.0}
_IDLE = {"side": 0.010, "fore": 0.006, **_IDLE_TORSO, **_IDLE_ARMS}
"""Amplitude of idle sway by channel, m and degrees."""


def synthetic_clips(
    *, seed: int = 0, frame_rate: float = 30.0
) -> tuple[list[Clip], dict[str, tuple[Label, ...]]]:
    """A procedural motion set of 208 s with labelled avoidance, the same for the same seed.

    Every clip begins and ends at rest in the same neutral stance. Amplitudes, durations and idle
    sway depend on the seed; the order of events does not.

    Args:
        seed: of the generator.
        frame_rate: frames per second.

    Returns:
        The clips, and their labels by clip name.
    """
    if not 1 <= frame_rate <= 10000:
        raise MotionError(f"frame rate is {frame_rate}, expected 1 … 10000 per second")
    scores: dict[str, Score] = {}
    for number, (name, script) in enumerate(SCRIPTS.items()):
        score = scores[name] = Score(rng=np.random.default_rng([seed, number]))
        for line in script.split(";"):
            verb, *words = line.split()
            VERBS[verb](score, *words)
    spare = (TOTAL_S - sum(score.time for score in scores.values())) / len(scores)
    skeleton = synthetic_skeleton()
    clips: list[Clip] = []
    for name, score in scores.items():
        score.time += spare
        motion = perform(score, frame_rate)
        clips.append(Clip(name=name, skeleton=skeleton, motion=motion))
    return clips, {name: tuple(s.labels) for name, s in scores.items() if s.labels}


def perform(score: Score, frame_rate: float) -> Motion:
    """The motion of a score."""
    ratio = max(1, int(np.ceil(_FINE_HZ / frame_rate)))
    frames = round(score.time * frame_rate)
    rate = frame_rate * ratio
    t = np.arange(frames * ratio) / rate

    def smooth(x: Array, seconds: float) -> np.ndarray:
        return gaussian_filter1d(x, seconds * rate, axis=0, mode="nearest")

    c = make_channels(score, t)
    feet = (
        make_foot(score, 0, t, smooth, c["heel_l"]),
        make_foot(score, 1, t, smooth, c["heel_r"]),
    )
    base = make_base(score, t, smooth)
    couple_gait(c, base, feet, t, smooth)
    answer_steps(c, score.steps, t, smooth)
    swing_arms(c, base, t, smooth)
    root = make_root(c, base, feet, rate, smooth)
    lifted, tucked = _jumps(score, t)
    root[:, 1] += lifted
    for foot in feet:
        foot.ball[:, 1] += tucked
    return make_motion(c, base, feet, root, t, ratio, frame_rate)


def make_motion(
    channels: dict[str, np.ndarray],
    base: np.ndarray,
    feet: tuple[Foot, Foot],
    root: np.ndarray,
    t: np.ndarray,
    ratio: int,
    frame_rate: float,
) -> Motion:
    """The poses of every ``ratio``-th moment; the eyes are 0.2 s ahead of the body's heading."""
    gaze = np.interp(t + 0.2, t, base[:, 0])
    picked = slice(None, None, ratio)
    left, right = (Foot(**{n: x[picked] for n, x in vars(foot).items()}) for foot in feet)
    local = body.pose(
        synthetic_skeleton(),
        root[picked],
        base[picked, 0],
        gaze[picked],
        {name: channels[name][picked] for name in CHANNELS},
        (left, right),
    )
    return Motion(
        root_translation=root[picked].astype(np.float32),
        local_rotations=local.astype(np.float32),
        frame_rate=float(frame_rate),
    )


def make_channels(score: Score, t: np.ndarray) -> dict[str, np.ndarray]:
    """Neutral stance, idle sway and gestures; m and rad."""
    c = {name: np.full_like(t, _NEUTRAL_DEG.get(name, 0.0)) for name in CHANNELS}
    fade = ease(t / _EDGE_S) * ease((t[-1] - t) / _EDGE_S)
    for name, size in _IDLE.items():
        for hertz in score.rng.uniform([0.12, 0.25, 0.4], [0.22, 0.35, 0.6]):
            phase = score.rng.uniform(0, 2 * np.pi)
            c[name] += fade * size * (0.15 / hertz) ** 0.5 * np.sin(2 * np.pi * hertz * t + phase)
    breathe(c, t, fade, score.rng)
    for gesture in score.gestures:
        for name, value in gesture.moves.items():
            for channel in (name,) if name in c else (f"{name}_l", f"{name}_r"):
                c[channel] += value * gesture.envelope(t - LAG_S.get(channel.split("_")[0], 0.0))
    return {n: x if n in _LENGTHS else np.radians(x) for n, x in c.items()}


def make_foot(score: Score, foot: int, t: np.ndarray, smooth: Smooth, heel: np.ndarray) -> Foot:
    """Where a foot is: planted exactly in its places, carried on minimum-jerk arcs in between."""
    ball = np.tile(body.BALLS[foot], (len(t), 1))
    yaw = np.full_like(t, _TOE_OUT * (1 if foot == 0 else -1))
    keys = [(-1.0, 0.0)]
    for s in (s for s in score.steps if s.foot == foot):
        u = (t - s.lift_s) / (s.land_s - s.lift_s)
        carried = ease((u - 0.04) / 0.92)
        ball += s.travel * carried[:, None]
        yaw += (s.end[0] - s.start[0]) * carried
        ball[:, 1] += s.height * 64 * np.clip(u * (1 - u), 0, None) ** 3
        keys += _pitch_keys(s)
    times, pitches = np.array(keys).T
    pitch = smooth(np.interp(t, times, pitches), 0.035) + heel
    # On the heel the ball of the foot is off the floor by as much as the sole slopes.
    ball[:, 1] += 0.17 * np.sin(np.clip(-pitch, 0, None))
    free = ease((ball[:, 1] - body.BALL_HEIGHT_M) / 0.12)
    toe_pitch = np.minimum(pitch, 0.0) + 0.8 * free * np.maximum(pitch, 0.0)
    return Foot(ball=ball, yaw=yaw, pitch=pitch, toe_pitch=toe_pitch)


def _pitch_keys(s: Step) -> list[tuple[float, float]]:
    """Heel off before the lift, heel (or, backwards, toes) first at the landing."""
    ahead = s.travel[0] * np.sin(s.start[0]) + s.travel[2] * np.cos(s.start[0])
    share = float(np.clip(ahead / 1.2, -1, 1))
    off, on = np.radians(14 + 26 * abs(share)), np.radians(-18 * share)
    swing = s.land_s - s.lift_s
    return [
        (s.lift_s - 0.2 - 0.1 * abs(share), 0.0),
        (s.lift_s - 0.12, off * (0.4 + 0.3 * abs(share))),
        (s.lift_s, off),
        (s.lift_s + 0.15 * swing, 1.15 * off),
        (s.lift_s + 0.6 * swing, 0.0),
        (s.lift_s + 0.9 * swing, on),
        (s.land_s + 0.05, 0.0),
    ]


def make_base(score: Score, t: np.ndarray, smooth: Smooth) -> np.ndarray:
    """[F,3] planar place of the body over its feet: (θ, x, z)."""
    base = np.zeros((len(t), 3))
    over = np.zeros((len(t), 3))
    for s in score.steps:
        begin, end = s.lift_s - 0.06, s.land_s + 0.06
        base += 0.5 * (s.end - s.start) * np.clip((t - begin) / (end - begin), 0, 1)[:, None]
    for s in score.steps:
        early = s.lift_s - _SHIFT_EARLY * (s.land_s - s.lift_s)
        stands = ((t >= early) & (t <= s.land_s)) * s.shift
        x = body.BALLS[1 - s.foot][0]
        over[:, 1:] += (stands * x)[:, None] * np.stack(
            [np.cos(base[:, 0]), -np.sin(base[:, 0])], -1
        )
    return smooth(base, 0.1) + smooth(over, 0.12)


def make_root(
    c: dict[str, np.ndarray], base: np.ndarray, feet: tuple[Foot, Foot], rate: float, smooth: Smooth
) -> np.ndarray:
    """[F,3] place of the root: over the base, and no higher than the planted legs allow."""
    place = np.stack([c["side"], body.ROOT_HEIGHT_M + c["up"], c["fore"]], axis=-1)
    root = np.asarray(planar.apply(base, place))
    limit = root[:, 1]
    turn = np.stack([base[:, 0] + c["yaw"], 0 * c["yaw"], 0 * c["yaw"]], axis=-1)
    for foot, sign in zip(feet, (1, -1), strict=True):
        hip = planar.apply(turn, np.array(body.HIP_M) * [sign, 1, 1])
        away = foot.ankle() - root - hip
        flat = np.minimum(away[:, 0] ** 2 + away[:, 2] ** 2, _REACH_M**2)
        height = foot.ankle()[:, 1] + np.sqrt(_REACH_M**2 - flat) - hip[:, 1]
        limit = np.minimum(limit, height)
    root[:, 1] = smooth(minimum_filter1d(limit, round(0.1 * rate), mode="nearest"), 0.055)
    return root


def _jumps(score: Score, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far jumps lift the root and the feet, m."""
    root, feet = np.zeros_like(t), np.zeros_like(t)
    for jump in score.jumps:
        knots = np.array(jump.knots)
        inside = (t >= knots[0, 0]) & (t < knots[-1, 0])
        root[inside] += BPoly.from_derivatives(knots[:, 0], knots[:, 1:])(t[inside])
        u = np.clip((t - jump.takeoff_s) / (jump.land_s - jump.takeoff_s), 0, 1)
        feet += jump.tuck * 16 * (u * (1 - u)) ** 2
    return root, feet
