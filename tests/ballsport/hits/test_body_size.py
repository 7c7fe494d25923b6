"""Kicks of larger and smaller bodies are found in the same frames.

The ball is the world's: its radius, its gravity and what it bounces on are not scaled, so flights
and the passes of a scene differ; players are always the embedded body.
"""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.ballsport.config import FEET, AnalysisConfig
from mgjax.ballsport.hits.bones import LiveAnalysis, analyse
from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.core.kinematics import global_positions
from tests.sized import EXACT, SIZES, clips_of_size

KICKS = synthetic_kicks(frame_rate=60.0)[0]
HANDS = ("left_hand", "right_hand")
HIGH = AnalysisConfig(height_m=1.0, margin_m=0.05)


def found(clip, *, live=False, config=None, bones=FEET):
    positions = np.asarray(global_positions(clip.skeleton, clip.motion), np.float64)
    rate = clip.motion.frame_rate
    if not live:
        return analyse(clip.skeleton, positions, rate, bones=bones, config=config)
    stream = LiveAnalysis(clip.skeleton, rate, bones=bones, config=config)
    hits = [hit for frame in positions for hit in stream.push(frame)]
    return sorted(hits + stream.finish(), key=lambda x: x.hit.start)


@pytest.mark.parametrize(("bones", "config"), [(FEET, None), (HANDS, HIGH)], ids=["feet", "hands"])
@pytest.mark.parametrize("size", [*EXACT, *SIZES])
def test_the_same_hits(size, bones, config):
    total = 0
    for one, other in zip(KICKS, clips_of_size(KICKS, size), strict=True):
        want, got = (found(clip, bones=bones, config=config) for clip in (one, other))
        assert [(x.bone, x.hit) for x in got] == [(x.bone, x.hit) for x in want]
        for a, b in zip(got, want, strict=True):
            np.testing.assert_allclose(a.vector.v_max, size * b.vector.v_max, rtol=1e-3)
            np.testing.assert_allclose(a.vector.seconds, b.vector.seconds)
            np.testing.assert_allclose(
                a.vector.displacements, size * np.asarray(b.vector.displacements), atol=1e-4
            )
        total += len(want)
    assert total > 5


@pytest.mark.parametrize("size", SIZES)
def test_live_they_are_the_same(size):
    (clip,) = clips_of_size([KICKS[0]], size)
    want = [(x.bone, x.hit) for x in found(clip)]
    assert [(x.bone, x.hit) for x in found(clip, live=True)] == want
    assert want
