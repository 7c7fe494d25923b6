"""Quality: feet, smoothness, limbs and limits of a motion, beside the same measures of capture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mgjax._lazy import attach

if TYPE_CHECKING:
    from mgjax.core.body.joint_limits import JointLimits as JointLimits
    from mgjax.quality.in_body import self_penetration as self_penetration
    from mgjax.quality.kernel import Curves as Curves
    from mgjax.quality.kernel import Extremes as Extremes
    from mgjax.quality.kernel import measured as measured
    from mgjax.quality.known import Captured as Captured
    from mgjax.quality.known import captured as captured
    from mgjax.quality.limits import CapturedRanges as CapturedRanges
    from mgjax.quality.limits import beyond as beyond
    from mgjax.quality.limits import captured_ranges as captured_ranges
    from mgjax.quality.measuring import curves_of as curves_of
    from mgjax.quality.measuring import measure as measure
    from mgjax.quality.measuring import measure_many as measure_many
    from mgjax.quality.result import Quality as Quality
    from mgjax.quality.smoothness import normalised_jerk as normalised_jerk
    from mgjax.quality.speeds import hellinger as hellinger
    from mgjax.quality.subject import Subject as Subject
    from mgjax.quality.subject import subject_of as subject_of
    from mgjax.quality.tracks import Tracks as Tracks
    from mgjax.quality.tracks import make_tracks as make_tracks
else:
    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "beyond": "mgjax.quality.limits",
            "Captured": "mgjax.quality.known",
            "captured": "mgjax.quality.known",
            "captured_ranges": "mgjax.quality.limits",
            "CapturedRanges": "mgjax.quality.limits",
            "Curves": "mgjax.quality.kernel",
            "curves_of": "mgjax.quality.measuring",
            "Extremes": "mgjax.quality.kernel",
            "hellinger": "mgjax.quality.speeds",
            "JointLimits": "mgjax.core.body.joint_limits",
            "make_tracks": "mgjax.quality.tracks",
            "measure": "mgjax.quality.measuring",
            "measure_many": "mgjax.quality.measuring",
            "measured": "mgjax.quality.kernel",
            "normalised_jerk": "mgjax.quality.smoothness",
            "Quality": "mgjax.quality.result",
            "self_penetration": "mgjax.quality.in_body",
            "Subject": "mgjax.quality.subject",
            "subject_of": "mgjax.quality.subject",
            "Tracks": "mgjax.quality.tracks",
        },
    )
