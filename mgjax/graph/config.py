"""Settings of the graph. Imports neither jax nor numpy, so that help texts stay quick."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class GraphConfig:
    """How a motion graph is built.

    Attributes:
        frame_rate: frames per second of the graph; clips are resampled to it.
        window_s: length of the compared and blended windows, s.
        neighbourhood: a minimum is the lowest value within this many window starts on each side.
        self_gap_s: on one clip, windows nearer in time than this make no transition.
        threshold_m: largest distance of a transition, m RMS; None: the smallest that keeps
            ``keep`` of the labels (or, with none, of the motion that ``max_threshold_m`` keeps).
        normalised: instead of ``threshold_m``, the threshold as a share of the largest distance
            (the paper's normalisation of the error to 0 … 1).
        keep: share of the labels that the automatic threshold must keep.
        max_threshold_m: the automatic threshold may not exceed this, m.
        weights: how much each joint counts: ``"uniform"``, ``"limbs"``, or a table of joint names
            and numbers.
        mirror: adds a left-right mirrored copy of every clip.
        clean_feet: keeps planted feet in place within transitions.
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
    clean_feet: bool = True
    horizon_s: float = 2.0
