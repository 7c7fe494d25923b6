"""Procedural kicks for ball sport: toss, pass and attack with either foot, idling and links."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import gaussian_filter1d

from mgjax.clips import synthetic as base_set
from mgjax.clips.procedural.gestures import ease
from mgjax.clips.procedural.score import Score, Step
from mgjax.clips.procedural.verbs import VERBS
from mgjax.clips.synthetic_skeleton import Foot, synthetic_skeleton
from mgjax.clips.types import Clip, Label
from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.core.errors import MotionError
from mgjax.core.motion import Motion

_TABLE = """
toss    back .10 .26  rise .05 .14  low .14 .22  fore .28 .46  top .36 .60  side -.02 .05
        lift .24 .32  swing .38 .50  fall .50 .62  point 15 35  bend -4 -10  yaw 3 8
pass    back .16 .34  rise .08 .22  low .13 .20  fore .34 .56  top .40 .68  side -.03 .06
        lift .24 .32  swing .26 .34  fall .46 .58  point 20 40  bend -6 -13  yaw 6 13
attack  back .36 .52  rise .34 .48  low .10 .16  fore .50 .66  top .70 .96  side -.08 .04
        lift .26 .34  swing .20 .26  fall .50 .62  point 30 50  bend -10 -20  yaw 12 22
"""
"""Ranges of a kick. Place of the ball of the foot from neutral, m: ``back`` behind and ``rise`` up
at the end of the backswing, ``low`` as it passes the standing leg, ``fore`` ahead and ``top`` up at
the end of the swing, ``side`` outward. Durations of the three phases, s. Degrees: how far the toes
``point``, the torso's ``bend`` and the pelvis' ``yaw`` into the kick. Those of toss and pass
overlap in all but their speed."""
_RANGE = re.compile(r"(\w+) (-?\.?\d+) (-?\.?\d+)")
KICKS = {
    block.split()[0]: {name: (float(a), float(b)) for name, a, b in _RANGE.findall(block)}
    for block in re.split(r"\n(?=\w)", _TABLE.strip())
}
LINKS = {
    "ball_idle": "idle 3; look; idle 2; look; idle 2",
    "ball_steps": "idle; step forward; idle; step back; idle; step left; idle; step right; idle",
    "ball_turns": "idle; turn 45; idle; turn -45; idle; turn 90; idle; turn -90; idle",
}
"""What a player does between two hits: scripts of :data:`mgjax.clips.procedural.verbs.VERBS`."""
_SHIFT = 0.85
"""Share of the way over to the standing foot that the pelvis goes during a kick."""


@dataclass(frozen=True, kw_only=True)
class _Phase:
    """One phase of a kick: from the first to the last of three control points and its pace."""

    foot: int
    begin: float
    end: float
    points: tuple[np.ndarray, np.ndarray, np.ndarray]

    def at(self, t: np.ndarray) -> np.ndarray:
        """[F,4] the deviation of the foot while the phase lasts, else 0."""
        u = ease((t - self.begin) / (self.end - self.begin))[:, None]
        first, middle, last = self.points
        curve = (1 - u) ** 2 * first + 2 * u * (1 - u) * middle + u**2 * last
        return np.asarray(curve * ((t >= self.begin) & (t < self.end))[:, None])


@dataclass(kw_only=True)
class _KickScore(Score):
    """A score whose feet also kick."""

    kicks: list[_Phase] = field(default_factory=list)


def synthetic_kicks(
    *, seed: int = 0, frame_rate: float = 60.0, takes: int = 2
) -> tuple[list[Clip], dict[str, tuple[Label, ...]]]:
    """Kicks of a foot volleyball player and what lies between them, the same for the same seed.

    One clip ``kick_<kind>_<foot>`` for each of toss, pass and attack with the left and the right
    foot, and the clips of :data:`LINKS`. Every clip begins and ends at rest in the neutral stance
    of :func:`mgjax.clips.synthetic.synthetic_clips`, on the same skeleton.

    Args:
        seed: of the generator.
        frame_rate: frames per second.
        takes: kicks in a clip, each with a strength, form and timing of its own.

    Returns:
        The clips, and a label for each kick by clip name: its kind, the foot as the direction, from
        the lift of the foot to its landing.
    """
    if not 1 <= frame_rate <= 10000:
        raise MotionError(f"frame rate is {frame_rate}, expected 1 … 10000 per second")
    if takes < 1:
        raise MotionError(f"got {takes} takes, expected at least one")
    rng = np.random.default_rng(seed)
    skeleton = synthetic_skeleton()
    clips: list[Clip] = []
    labels: dict[str, tuple[Label, ...]] = {}
    for kind in KICKS:
        for foot, side in enumerate(("left", "right")):
            score = _KickScore(rng=rng)
            VERBS["idle"](score)
            for _ in range(takes):
                _kick(score, kind, foot)
                VERBS["idle"](score)
            name = f"kick_{kind}_{side}"
            clips.append(Clip(name=name, skeleton=skeleton, motion=_perform(score, frame_rate)))
            labels[name] = tuple(score.labels)
    for name, script in LINKS.items():
        score = _KickScore(rng=rng)
        for line in script.split(";"):
            verb, *words = line.split()
            VERBS[verb](score, *words)
        clips.append(Clip(name=name, skeleton=skeleton, motion=_perform(score, frame_rate)))
    return clips, labels


def _kick(score: _KickScore, kind: str, foot: int) -> None:
    """Lifts, swings and puts back one foot; all amplitudes of about one strength."""
    strength = score.uniform(0.0, 1.0)
    k: dict[str, float] = {}
    for name, (low, high) in KICKS[kind].items():
        share = float(np.clip(strength + score.uniform(-0.35, 0.35), 0, 1))
        k[name] = high + (low - high) * share if name == "swing" else low + (high - low) * share
    start, sign = score.time, 1 - 2 * foot
    swing, land = start + k["lift"], start + k["lift"] + k["swing"] + k["fall"]
    out = sign * k["side"]
    across = out - sign * 0.08 * k["fore"]
    # Outward, up and forward, m; pitch of the foot, degrees. Each phase is a curve from place to
    # place; the middle one pulls it, so that the swing passes the standing leg at ``low``.
    rest = np.zeros(4)
    back = np.array([out, k["rise"], -k["back"], 1.2 * k["point"]])
    top = np.array([across, k["top"], k["fore"], 0.3 * k["point"] - 12.0])
    low = np.array([out, k["low"], 0.3 * k["fore"], k["point"]])
    lifted = np.array([0.5 * out, 0.5 * k["rise"], -k["back"], k["point"]])
    lowered = np.array([0.3 * out, 0.3 * k["top"], 0.7 * k["fore"], 8.0])
    score.kicks += [
        _Phase(foot=foot, begin=start, end=swing, points=(rest, lifted, back)),
        _Phase(
            foot=foot,
            begin=swing,
            end=swing + k["swing"],
            points=(back, 2 * low - 0.5 * (back + top), top),
        ),
        _Phase(foot=foot, begin=swing + k["swing"], end=land, points=(top, lowered, rest)),
    ]
    place = score.feet[foot]
    score.steps.append(
        Step(
            foot=foot,
            lift_s=start,
            land_s=land,
            start=place,
            end=place,
            travel=np.zeros(3),
            height=0.0,
            shift=_SHIFT,
        )
    )
    _swing_body(score, k, foot, swing)
    score.time = land
    score.label(start, kind, ("left", "right")[foot])
    score.time += 0.15


def _swing_body(score: _KickScore, k: dict[str, float], foot: int, swing: float) -> None:
    """Pelvis, torso and arms follow the leg."""
    sign, near, far = (1, "l", "r") if foot == 0 else (-1, "r", "l")
    windup = {"yaw": 0.6 * sign * k["yaw"], "bend": -0.6 * k["bend"], f"flex_{near}": 14.0}
    score.gesture(swing - 0.26, 0.26, 0.0, 0.8 * k["swing"] + 0.1, windup)
    moves = {
        "yaw": -sign * k["yaw"],
        "twist": sign * 1.2 * k["yaw"],
        "bend": k["bend"],
        "pitch": 0.5 * k["bend"],
        "nod": 8.0,
        f"flex_{far}": 25.0 + k["yaw"],
        f"open_{far}": 12.0,
        f"flex_{near}": -18.0 - k["yaw"],
        f"open_{near}": 14.0,
        "elbow": 12.0,
    }
    score.gesture(swing, k["swing"], 0.05, k["fall"], moves)


def _perform(score: _KickScore, frame_rate: float) -> Motion:
    """The motion of a score, its kicks laid over the planted feet."""
    ratio = max(1, int(np.ceil(120.0 / frame_rate)))
    rate = frame_rate * ratio
    t = np.arange(round(score.time * frame_rate) * ratio) / rate

    def smooth(x: Array, seconds: float) -> np.ndarray:
        return gaussian_filter1d(x, seconds * rate, axis=0, mode="nearest")

    c = base_set.make_channels(score, t)
    over = base_set.make_base(score, t, smooth)
    planted = [base_set.make_foot(score, i, t, smooth, c[f"heel_{'lr'[i]}"]) for i in (0, 1)]
    feet = (_kicked(score, 0, planted[0], t, over, smooth),)
    feet += (_kicked(score, 1, planted[1], t, over, smooth),)
    root = base_set.make_root(c, over, feet, rate, smooth)
    return base_set.make_motion(c, over, feet, root, t, ratio, frame_rate)


def _kicked(
    score: _KickScore,
    foot: int,
    planted: Foot,
    t: np.ndarray,
    over: np.ndarray,
    smooth: base_set.Smooth,
) -> Foot:
    """The foot with its kicks laid over it."""
    place = np.zeros((len(t), 4))
    for phase in (phase for phase in score.kicks if phase.foot == foot):
        place += phase.at(t)
    place = smooth(place, 0.015)
    turn = np.stack([over[:, 0], np.zeros_like(t), np.zeros_like(t)], axis=-1)
    ball = planted.ball + np.asarray(planar.apply(turn, place[:, :3]))
    kicking = np.clip(place[:, 1] / 0.03, 0, 1)
    pitch = planted.pitch * (1 - kicking) + np.radians(place[:, 3])
    toe_pitch = planted.toe_pitch * (1 - kicking) + np.radians(place[:, 3])
    return Foot(ball=ball, yaw=planted.yaw, pitch=pitch, toe_pitch=toe_pitch)
