"""Settings of the ball sport room. Neither jax nor numpy is imported here."""

from __future__ import annotations

from dataclasses import dataclass

FEET = ("left_foot", "right_foot")
HANDS = ("left_hand", "right_hand")
HIT_BONES = (*FEET, *HANDS, "head")
"""What can hit a ball."""
KINDS = ("toss", "pass", "attack")
"""To the nearest player, to one at a medium distance, and a strong one to an opponent (§3)."""


@dataclass(frozen=True, kw_only=True)
class AnalysisConfig:
    """How hits are found in the height and the speed of a hit bone (Choi et al. 2019, §3).

    Attributes:
        height_m: a frame F_H is a local maximum of the height above this, m over the floor. The
            paper leaves it to the user. A toe of a running or walking foot reaches 0.18 m in the
            captured run-ups, one that kicks a ball on the ground 0.37 m. For hands and the head a
            height over the shoulders is a sensible choice.
        merge_s: F_S closer than this merge into the faster one, never across an F_H, s.
        reach_s: how far F_S are looked for on either side of an F_H, and the ends of S_H on either
            side of the hit, s. It bounds the delay of the streaming analysis.
        margin_m: S_H ends at the first frame, going outwards, whose height is within this of the
            lowest, m.
        smoothing_s: standard deviation of the Gaussian with which positions are smoothed before
            anything else, s; 0 leaves them as they are, and then ripples of captured speed split
            two of 18 kicks in two. A sensor with 10 mm of noise a frame wants 0.04.
    """

    height_m: float = 0.25
    merge_s: float = 0.1
    reach_s: float = 0.5
    margin_m: float = 0.02
    smoothing_s: float = 0.02


@dataclass(frozen=True, kw_only=True)
class MatchConfig:
    """Weights of the distance of two hits (eq. 2). The paper prints none.

    Attributes:
        w_v: of the difference of the largest speeds, per m/s.
        w_m: of the differences of the displacements, per m.
        w_t: of the differences of their times, per s.
    """

    w_v: float = 0.2
    w_m: float = 1.0
    w_t: float = 1.0


@dataclass(frozen=True, kw_only=True)
class TransitionConfig:
    """How two link motions are joined (eq. 1).

    Attributes:
        seconds: length of the section S_T in which one motion blends into the other, s.
        w_p: weights of the positions of the left and right foot, left and right hand and root.
        w_v: weights of their velocities, s.
        loop_s: a link motion is joined to itself only by going back this far or more, s.
    """

    seconds: float = 1 / 3
    w_p: tuple[float, float, float, float, float] = (1.0, 1.0, 0.5, 0.5, 1.0)
    w_v: tuple[float, float, float, float, float] = (0.1, 0.1, 0.05, 0.05, 0.1)
    loop_s: float = 0.5


@dataclass(frozen=True, kw_only=True)
class KindConfig:
    """What a captured hit without a kind counts as: by the largest speed of the hit bone.

    Attributes:
        pass_m_s: from this speed on a hit is a pass, below it a toss, m/s.
        attack_m_s: from this speed on it is an attack, m/s.
    """

    pass_m_s: float = 4.2
    attack_m_s: float = 7.2


@dataclass(frozen=True, kw_only=True)
class ClipSetConfig:
    """What a clip set is made of.

    Attributes:
        frame_rate: of all its motion, frames per second.
        bones: what can hit.
        analysis: how hits are found.
        kinds: what a captured hit counts as.
        transition: how link motions are joined.
    """

    frame_rate: float = 60.0
    bones: tuple[str, ...] = FEET
    analysis: AnalysisConfig = AnalysisConfig()
    kinds: KindConfig = KindConfig()
    transition: TransitionConfig = TransitionConfig()
