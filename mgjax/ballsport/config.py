"""Settings of the ball sport room. Neither jax nor numpy is imported here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from mgjax.core.body.sized import sized
from mgjax.core.errors import ConfigError, SkeletonError
from mgjax.core.ranges import Ranges, check_ranges


@dataclass(frozen=True, kw_only=True)
class HitBone:
    """What can hit a ball.

    Attributes:
        name: such as ``"left_foot"``.
        kind: of the bone.
        side: of the body; "" for the head.
        roles: of the joint whose path is that of the bone: the first that a skeleton has.
        at_end: where only the last of the roles is there, its end joint is meant, if it has one.
        radius_m: of the bone's surface about the joint: a ball is met by a sphere of this size.
    """

    name: str
    kind: Literal["foot", "hand", "head"]
    side: Literal["left", "right", ""]
    roles: tuple[str, ...]
    at_end: bool
    radius_m: float


def _foot(side: Literal["left", "right"]) -> HitBone:
    """The ball of the foot."""
    roles = (f"{side}_toe", f"{side}_ankle")
    return HitBone(
        name=f"{side}_foot", kind="foot", side=side, roles=roles, at_end=True, radius_m=0.06
    )


def _hand(side: Literal["left", "right"]) -> HitBone:
    """The fingers, or the wrist where there are none."""
    roles = (f"{side}_hand", f"{side}_wrist")
    return HitBone(
        name=f"{side}_hand", kind="hand", side=side, roles=roles, at_end=False, radius_m=0.05
    )


_HEAD = HitBone(name="head", kind="head", side="", roles=("head",), at_end=True, radius_m=0.09)
"""The end of the head, or the head."""

BONE_TABLE = {
    bone.name: bone
    for bone in (_foot("left"), _foot("right"), _hand("left"), _hand("right"), _HEAD)
}
"""The hit bones by name."""
HIT_BONES = tuple(BONE_TABLE)
FEET = tuple(name for name, bone in BONE_TABLE.items() if bone.kind == "foot")
KINDS = ("toss", "pass", "attack")
"""To the nearest player, to one at a medium distance, and a strong one to an opponent (§3)."""

MOST_BOUNCES = 4
"""Bounces of a pass that can be asked for."""
MAX_SPEED_M_S = 30.0
"""Largest kick speed unless given: about the fastest that is measured in football."""


def hit_bone(name: str) -> HitBone:
    """The hit bone of a name.

    Raises:
        SkeletonError: there is none.
    """
    if name not in BONE_TABLE:
        raise SkeletonError(f"got the hit bone {name!r}, expected a foot, a hand or the head")
    return BONE_TABLE[name]


@dataclass(frozen=True, kw_only=True)
class AnalysisConfig:
    """How hits are found in the height and the speed of a hit bone (Choi et al. 2019, §3).

    Of a body they are those of an adult, and scaled to it (:func:`analysis_for_body`); of the path
    of one point they are as they stand.

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


def analysis_for_body(config: AnalysisConfig, scale: float) -> AnalysisConfig:
    """The thresholds for one body, from those of an adult.

    Args:
        config: thresholds as a user writes them.
        scale: of the body; see :func:`mgjax.core.body.height.body_scale`.
    """
    return sized(config, ("height_m", "margin_m"), scale)


_ANALYSIS: Ranges = {
    "height_m": (-1000.0, 1000.0),
    "merge_s": (0.0, 60.0),
    "reach_s": (0.0, 60.0),
    "margin_m": (0.0, 1000.0),
    "smoothing_s": (0.0, 60.0),
}
_MATCH: Ranges = {"w_v": (0.0, 1e9), "w_m": (0.0, 1e9), "w_t": (0.0, 1e9)}
_TRANSITION: Ranges = {
    "seconds": (1e-3, 60.0),
    "w_p": (0.0, 1e9),
    "w_v": (0.0, 1e9),
    "loop_s": (0.0, 1e6),
}
_KIND: Ranges = {"pass_m_s": (0.0, 1000.0), "attack_m_s": (0.0, 1000.0)}
_CLIP_SET: Ranges = {"frame_rate": (1.0, 10000.0)}


def validate_analysis(config: AnalysisConfig, place: str = "") -> None:
    """Raises :class:`ConfigError` unless all thresholds are usable."""
    check_ranges(config, _ANALYSIS, place)


def validate_match(config: MatchConfig, place: str = "") -> None:
    """Raises :class:`ConfigError` unless the weights are usable."""
    check_ranges(config, _MATCH, place)
    if not max(config.w_v, config.w_m, config.w_t) > 0:
        raise ConfigError(got=f"{place}w_v = w_m = w_t = 0", expected="one above 0")


def validate_transition(config: TransitionConfig, place: str = "") -> None:
    """Raises :class:`ConfigError` unless lengths and weights are usable."""
    check_ranges(config, _TRANSITION, place)
    if not max(*config.w_p, *config.w_v) > 0:
        raise ConfigError(got=f"{place}w_p and w_v = 0", expected="one above 0")


def validate_kinds(config: KindConfig, place: str = "") -> None:
    """Raises :class:`ConfigError` unless the speeds are in rising order."""
    check_ranges(config, _KIND, place)
    if config.attack_m_s < config.pass_m_s:
        raise ConfigError(
            got=f"{place}attack_m_s = {config.attack_m_s!r}",
            expected=f"at least pass_m_s = {config.pass_m_s!r}",
        )


def validate_bones(bones: tuple[str, ...], place: str = "") -> None:
    """Raises :class:`ConfigError` unless these are hit bones, at least one and each once."""
    for bone in bones:
        if bone not in BONE_TABLE:
            raise ConfigError(got=f"{place}bones with {bone!r}", expected=", ".join(HIT_BONES))
    if not bones or len(set(bones)) < len(bones):
        raise ConfigError(got=f"{place}bones = {list(bones)}", expected="different ones, not none")


def validate_clip_set(config: ClipSetConfig, place: str = "") -> None:
    """Raises :class:`ConfigError` naming the first setting that cannot be."""
    check_ranges(config, _CLIP_SET, place)
    validate_bones(config.bones, place)
    validate_analysis(config.analysis, f"{place}analysis.")
    validate_kinds(config.kinds, f"{place}kinds.")
    validate_transition(config.transition, f"{place}transition.")
