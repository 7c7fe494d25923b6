"""Settings of the graph. Imports neither jax nor numpy, so that help texts stay quick."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from mgjax.core.errors import ConfigError
from mgjax.core.ranges import Ranges, check_ranges

BLENDS = ("support", "paper", "smooth", "inertial", "smooth+support", "inertial+support")
"""How windows are blended; see :mod:`mgjax.graph.blending.forms`."""


@dataclass(frozen=True, kw_only=True)
class GraphConfig:
    """How a motion graph is built.

    Thresholds are those of an adult (:data:`mgjax.core.body.height.ADULT_M`) and scaled to the
    graph's body.

    Attributes:
        frame_rate: frames per second of the graph; clips are resampled to it.
        window_s: length of the compared and blended windows, s.
        neighbourhood: a minimum is the lowest value within this many window starts on each side.
        self_gap_s: on one clip, windows nearer in time than this make no transition.
        threshold_m: largest distance of a transition, m RMS of an adult; None: the smallest that
            keeps ``keep`` of the labels (or, with none, of the motion that ``max_threshold_m``
            keeps).
        normalised: instead of ``threshold_m``, the threshold as a share of the largest distance
            (the paper's normalisation of the error to 0 … 1).
        keep: share of the labels that the automatic threshold must keep.
        max_threshold_m: the automatic threshold may not exceed this, of an adult, m.
        weights: how much each joint counts: ``"uniform"``, ``"limbs"``, or a table of joint names
            and numbers.
        mirror: adds a left-right mirrored copy of every clip.
        interpolate_m: adds a clip halfway between each labelled part and the one of its kind that
            is most like it, if joints are no farther apart on average, of an adult, m
            (:mod:`mgjax.clips.interpolated`); 0: none.
        retarget: puts clips of other skeletons on the graph's.
        clean_feet: keeps planted feet in place, within transitions and in all that is played of
            the graph (:mod:`mgjax.graph.feet`).
        blend: ``"support"``, a crossfade of windows aligned by the feet that stand in both, which
            also lead the root; ``"paper"``, the plain crossfade (eqs 2–5); ``"smooth"``, one whose
            acceleration does not jump either; ``"inertial"``, the second window plus an offset that
            decays from where, and how fast, the first one is; and the last two with support.
        contacts: smallest share of a transition's frames in which the same feet stand in both
            windows; 0: any.
        minima: a minimum is the lowest pair of windows among: ``"allowed"``, those that may become
            transitions, so that beside a label its neighbour stands in for one that touches it;
            ``"all"``, as the paper has it.
        range_frames: adds the lowest pair of each block of so many by so many windows below the
            threshold to the minima; 0: none. Many more transitions, for somewhat better timing.
        best_per_s: so many of the transitions that leave one second of motion stay, the nearest to
            each place that they lead to first (:mod:`mgjax.graph.pruning.thin`); 0: all. With it a
            graph grows with the length of its clips, without with its square.
        label_quiet: blends may overlap the ends of a label at which every joint is slower than this
            share of the label's own peak speed; 0: not at all.
        label_overlap: blends may overlap this share of a label's length at either end anyway: the
            exercises of real capture follow each other without a pause. 0: not at all.
        horizon_s: a label is enterable if a walk from some node reaches its middle within this, s.
    """

    frame_rate: float = 30.0
    window_s: float = 1.0 / 3.0
    neighbourhood: int = 1
    self_gap_s: float = 0.5
    threshold_m: float | None = None
    normalised: float | None = None
    keep: float = 0.9
    max_threshold_m: float = 0.20
    weights: str | dict[str, float] = "uniform"
    mirror: bool = False
    interpolate_m: float = 0.0
    retarget: bool = False
    clean_feet: bool = True
    blend: str = "support"
    contacts: float = 0.0
    horizon_s: float = 2.0
    minima: Literal["allowed", "all"] = "allowed"
    range_frames: int = 0
    best_per_s: int = 100
    label_quiet: float = 0.2
    label_overlap: float = 0.33


EMBEDDED = GraphConfig(threshold_m=0.05, best_per_s=200)
"""For the embedded clips. The automatic threshold keeps each of their labels with a handful of
transitions, and then an avoidance part is hardly ever near; and they stand still for long, where
one transition is as good as another."""

_RANGES: Ranges = {
    "frame_rate": (1.0, 1000.0),
    "window_s": (1e-6, 10.0),
    "neighbourhood": (1, 50),
    "self_gap_s": (0.0, 1e9),
    "threshold_m": (1e-9, 1e9),
    "normalised": (1e-9, 1.0),
    "keep": (0.0, 1.0),
    "max_threshold_m": (1e-9, 10.0),
    "contacts": (0.0, 1.0),
    "interpolate_m": (0.0, 1.0),
    "range_frames": (0, 1024),
    "best_per_s": (0, 1_000_000),
    "label_quiet": (0.0, 1.0),
    "label_overlap": (0.0, 0.49),
    "horizon_s": (1e-6, math.inf),
}
"""Smallest and largest value of each setting that is a number."""


def validate_graph_config(config: GraphConfig) -> None:
    """Raises :class:`ConfigError` naming the first setting that is out of range."""
    check_ranges(config, _RANGES, optional=("threshold_m", "normalised"))
    if config.threshold_m is not None and config.normalised is not None:
        raise ConfigError(got="both threshold_m and normalised", expected="at most one")
    if config.blend not in BLENDS:
        raise ConfigError(got=f"blend = {config.blend!r}", expected=" or ".join(BLENDS))
    if config.minima not in ("allowed", "all"):
        raise ConfigError(got=f"minima = {config.minima!r}", expected="allowed or all")
