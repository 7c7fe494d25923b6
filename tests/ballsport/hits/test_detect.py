from __future__ import annotations

import json
from dataclasses import asdict, replace

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from mgjax.ballsport.config import FEET, HIT_BONES, AnalysisConfig
from mgjax.ballsport.hits.bones import LiveAnalysis, analyse
from mgjax.ballsport.hits.detect import NO_FRAME, find_hits, hit_joint, links, mark, sections
from mgjax.ballsport.hits.smoothing import smooth
from mgjax.ballsport.hits.stream import HitStream
from mgjax.clips.oddities import first_clean_frame
from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.core.errors import ConfigError, MotionError, SkeletonError
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import cut
from mgjax.io.load import load_motion
from tests.ballsport.made import bumps, wavy_path
from tests.reference import hits as reference


def settings(seed: int) -> AnalysisConfig:
    rng = np.random.default_rng(seed)
    return AnalysisConfig(
        height_m=float(rng.choice([0.1, 0.25, 0.5])),
        merge_s=float(rng.choice([0.0, 0.1, 0.2])),
        reach_s=float(rng.choice([0.1, 0.5])),
        smoothing_s=float(rng.choice([0.0, 0.01, 0.03])),
    )


def found_in(path, rate: float, config: AnalysisConfig) -> list:
    return sections(mark(path, rate, config), rate, config)


@hypothesis.given(st.integers(0, 10_000), st.integers(4, 160), st.sampled_from([30.0, 60.0]))
def test_agrees_with_the_definition(seed: int, frames: int, rate: float) -> None:
    # Odd seeds: without plateaus no two speeds are equal but for their rounding.
    path, config = wavy_path(2 * seed + 1, frames, rate), settings(seed)
    config = replace(config, smoothing_s=0.0)
    got = [asdict(hit) for hit in found_in(path, rate, config)]
    assert got == reference.hits(path, rate, config)


def test_curves_agree_with_the_definition() -> None:
    path = wavy_path(1, 50, 60.0)
    for seconds in (0.0, 0.02, 0.05):
        got = mark(path, 60.0, AnalysisConfig(smoothing_s=seconds))
        height, speed = reference.curves(path, 60.0, seconds)
        np.testing.assert_allclose(got.height, height, atol=1e-12)
        np.testing.assert_allclose(got.speed, speed, atol=1e-10)
    np.testing.assert_array_equal(smooth(path, 60.0, 0.0), path)


@hypothesis.given(st.integers(0, 10_000), st.integers(1, 400), st.sampled_from([30.0, 60.0, 120.0]))
def test_stream_gives_the_same_hits(seed: int, frames: int, rate: float) -> None:
    path, config = wavy_path(seed, frames, rate), settings(seed)
    whole = found_in(path, rate, config) if frames >= 3 else []
    stream = HitStream(rate, config)
    got = []
    for number, place in enumerate(path):
        for hit in stream.push(place):
            assert number - max(hit.fastest, hit.highest[-1]) <= stream.delay_frames
            got.append(hit)
    assert stream.num_frames == frames
    assert got + stream.finish() == whole


@hypothesis.given(st.integers(0, 10_000), st.integers(3, 400))
def test_sections_are_in_order(seed: int, frames: int) -> None:
    hits = found_in(wavy_path(seed, frames, 60.0), 60.0, settings(seed))
    for hit in hits:
        assert 0 <= hit.start <= hit.hit_start < hit.hit_stop <= hit.stop <= frames
        assert hit.start <= hit.top < hit.stop
        assert list(hit.key_frames) == sorted(hit.key_frames)
        assert hit.top in hit.highest
    for a, b in zip(hits, hits[1:], strict=False):
        assert a.stop <= b.start
    covered = np.zeros(frames, int)
    for start, stop in [(h.start, h.stop) for h in hits] + links(hits, frames):
        covered[start:stop] += 1
    np.testing.assert_array_equal(covered, 1)


def test_by_hand() -> None:
    # Up 0.125 m a frame for 5 frames, down for 5: the top is frame 15, the speed 1 m/s all the way
    # but at the top, where the central difference is 0; so the first frame of each flank counts.
    config = AnalysisConfig(height_m=0.3, merge_s=0.0, reach_s=1.0, smoothing_s=0.0)
    path = np.zeros((30, 3))
    path[10:21, 1] = 0.125 * (5 - np.abs(np.arange(-5, 6)))
    (hit,) = find_hits(path, 8.0, config)
    assert hit.highest == (15,)
    assert (hit.before, hit.after) == (11, 16)
    assert hit.fastest == 11  # equal speeds: the earlier
    assert (hit.hit_start, hit.hit_stop) == (11, 16)
    assert (hit.start, hit.stop) == (10, 21)  # the first frames within 2 cm of the floor
    assert hit.key_frames == (10, 11, 15, 16, 20)
    assert links([hit], 30) == [(0, 10), (21, 30)]


def test_high_points_on_both_sides_of_the_fastest_are_one_hit() -> None:
    # A ground kick: backswing, low and fast through the ball, follow-through.
    t = np.arange(240) / 120
    path = bumps(120.0, (0.8, 0.4, 0.06), (1.1, 0.35, 0.06), seconds=2.0)
    path[:, 2] = 1.2 / (1 + np.exp(-(t - 0.95) / 0.025))
    (hit,) = find_hits(path, 120.0)
    assert [round(f / 120, 2) for f in hit.highest] == [0.8, 1.1]
    assert abs(hit.fastest / 120 - 0.95) < 0.02
    assert hit.top == hit.highest[0]
    # Apart from each other, without the swing between them, they are two.
    assert len(find_hits(bumps(120.0, (1.0, 0.4, 0.06), (2.5, 0.35, 0.06)), 120.0)) == 2


def test_merging_never_crosses_a_high_point() -> None:
    config = AnalysisConfig(height_m=0.2, merge_s=0.5, reach_s=0.5, smoothing_s=0.0)
    (hit,) = find_hits(bumps(120.0, (1.0, 0.5, 0.05)), 120.0, config)
    assert hit.before != NO_FRAME
    assert hit.after != NO_FRAME


def test_nothing_found_is_one_clear_line() -> None:
    path = bumps(60.0, (1.0, 0.15, 0.1))
    with pytest.raises(MotionError, match=r"every frame is below .* 0.25 m, the bone reaches 0.20"):
        find_hits(path, 60.0)
    with pytest.raises(MotionError, match="no hit is above"):
        find_hits(path + np.array([0, 1, 0]), 60.0, AnalysisConfig(height_m=1.05, reach_s=0.0))
    with pytest.raises(MotionError, match="at least 3 finite"):
        find_hits(path[:2], 60.0)
    with pytest.raises(MotionError, match="not finite"):
        find_hits(path * np.nan, 60.0)
    assert found_in(path, 60.0, AnalysisConfig()) == []


@pytest.mark.parametrize("name", ["merge_s", "reach_s", "margin_m", "smoothing_s", "height_m"])
def test_thresholds_that_cannot_be(name: str) -> None:
    config = replace(AnalysisConfig(), **{name: float("nan")})
    with pytest.raises(ConfigError, match=name):
        HitStream(60.0, config)
    with pytest.raises(ConfigError, match=name):
        find_hits(np.zeros((9, 3)), 60.0, config)


def test_streams_refuse_what_is_not_finite() -> None:
    stream = HitStream(60.0)
    with pytest.raises(MotionError, match="finite"):
        stream.push(np.array([0.0, np.nan, 0.0]))
    assert stream.num_frames == 0
    with pytest.raises(MotionError, match="frame rate"):
        HitStream(0.0)


def test_bones(body) -> None:
    assert [body.names[hit_joint(body, b)] for b in FEET] == ["ltoes", "rtoes"]
    assert body.names[hit_joint(body, "head")] == "head"
    with pytest.raises(SkeletonError, match="left_elbow"):
        hit_joint(body, "left_elbow")
    clip = synthetic_kicks(takes=1, frame_rate=30.0)[0][0]
    names = [clip.skeleton.names[hit_joint(clip.skeleton, b)] for b in HIT_BONES]
    assert names == ["ltoes", "rtoes", "lfingers", "rfingers", "head_end"]
    # A hand that is raised over the head is found like a foot.
    positions = np.asarray(global_positions(clip.skeleton, clip.motion)).copy()
    hand = hit_joint(clip.skeleton, "left_hand")
    positions[:, hand, 1] += bumps(30.0, (1.0, 1.2, 0.1), seconds=99)[: len(positions), 1]
    config = AnalysisConfig(height_m=1.5)
    found = analyse(clip.skeleton, positions, 30.0, bones=HIT_BONES[:4], config=config)
    assert [item.bone for item in found] == ["left_hand"]


def test_live_analysis_is_the_whole() -> None:
    clips, _ = synthetic_kicks(takes=2, frame_rate=60.0)
    for clip in clips[:6]:
        positions = np.asarray(global_positions(clip.skeleton, clip.motion))
        whole = analyse(clip.skeleton, positions, 60.0)
        live = LiveAnalysis(clip.skeleton, 60.0)
        got = [item for frame in positions for item in live.push(frame)] + live.finish()
        assert len(whole) == 2
        assert [(x.bone, x.hit) for x in got] == [(x.bone, x.hit) for x in whole]
        for a, b in zip(got, whole, strict=True):
            np.testing.assert_allclose(a.vector.displacements, b.vector.displacements, atol=1e-5)
            np.testing.assert_allclose(a.vector.v_max, b.vector.v_max, rtol=1e-5)


CAPTURED = (
    *(f"cmu10/10_0{k}.amc" for k in (1, 2, 3, 5)),
    *(f"cmu135/135_0{k}.amc" for k in (4, 7)),
    *(f"cmu135_bvh/135_0{k}.bvh" for k in (4, 7)),
)


@pytest.mark.parametrize("name", CAPTURED)
def test_labelled_kicks(capture, name: str) -> None:
    kicks = json.loads((capture / "ball" / "labels.json").read_text())["clips"][name]
    skeleton, motion = load_motion(capture / "ball" / name)
    first = first_clean_frame(skeleton, motion)
    motion = cut(motion, first, motion.num_frames)
    positions = np.asarray(global_positions(skeleton, motion))
    found = analyse(skeleton, positions, motion.frame_rate)
    found = sorted(found, key=lambda item: item.hit.fastest)
    assert [item.bone for item in found] == [f"{k['foot']}_foot" for k in kicks]
    for item, kick in zip(found, kicks, strict=True):
        assert abs((item.hit.fastest + first) / motion.frame_rate - kick["peak_s"]) < 0.05
        assert abs(float(item.vector.v_max) - kick["peak_toe_speed_m_s"]) < 2.5
