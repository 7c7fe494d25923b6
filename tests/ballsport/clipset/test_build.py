from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.ballsport.clipset.build import NO_LINK, ClipSet, build_clip_set, kind_of
from mgjax.ballsport.config import KINDS, AnalysisConfig, ClipSetConfig, KindConfig
from mgjax.ballsport.hits.detect import Hit, hit_joint
from mgjax.ballsport.hits.motion_vectors import leg_length, motion_vector, scaled
from mgjax.clips.retarget.clip import retarget
from mgjax.clips.synthetic_kicks import LINKS, synthetic_kicks
from mgjax.clips.types import Clip, Label
from mgjax.core.errors import MotionError, SkeletonError
from mgjax.core.kinematics import global_positions
from mgjax.core.skeleton import Skeleton
from mgjax.io.load import load_motion
from tests.ballsport.conftest import SMALL


@pytest.fixture(params=["made", "real"])
def clips(request: pytest.FixtureRequest) -> ClipSet:
    return request.getfixturevalue(f"{request.param}_set")


def test_the_embedded_kicks(made_set: ClipSet) -> None:
    found = sorted(zip(made_set.hit_kind, made_set.hit_bone, strict=True))
    assert found == sorted(2 * [(k, f"{s}_foot") for k in KINDS for s in ("left", "right")])
    assert made_set.labelled.all()
    by_kind = {k: [] for k in KINDS}
    for kind, speed in zip(made_set.hit_kind, made_set.vectors.v_max, strict=True):
        by_kind[kind].append(float(speed))
    means = [float(np.mean(by_kind[k])) for k in KINDS]
    assert means == sorted(means)
    idle = [made_set.clip_names.index(name) for name in LINKS]
    assert not set(idle) & set(made_set.hit_clip.tolist())
    assert set(idle) <= set(made_set.link_clip.tolist())


def test_sections_fill_the_clips(clips: ClipSet) -> None:
    covered = np.zeros(clips.motion.num_frames, int)
    for starts, stops in (
        (clips.hit_starts, clips.hit_stops),
        (clips.link_starts, clips.link_stops),
    ):
        for start, stop in zip(starts, stops, strict=True):
            covered[start:stop] += 1
    np.testing.assert_array_equal(covered, 1)
    for hit in range(clips.num_hits):
        before, after = clips.link_before[hit], clips.link_after[hit]
        if before != NO_LINK:
            assert clips.link_stops[before] == clips.hit_starts[hit]
            assert clips.link_clip[before] == clips.hit_clip[hit]
        if after != NO_LINK:
            assert clips.link_starts[after] == clips.hit_stops[hit]
        keys = clips.hit_keys[hit]
        assert keys[0] == clips.hit_starts[hit]
        assert keys[2] == clips.highest[hit]
        assert keys[4] == clips.hit_stops[hit] - 1
    assert (clips.ball_starts >= clips.hit_starts).all()
    assert (clips.ball_stops <= clips.hit_stops).all()


def test_bone_path(made_set: ClipSet) -> None:
    places, velocity = made_set.bone_path(0)
    frames = slice(made_set.ball_starts[0], made_set.ball_stops[0])
    np.testing.assert_array_equal(places, made_set.positions[frames, made_set.hit_joint[0]])
    middle = (places[2:] - places[:-2]) * 15.0
    np.testing.assert_allclose(velocity[1:-1], middle, atol=1e-4)


def test_captured_kicks_and_their_mirror_images(real_set: ClipSet) -> None:
    captured = [c for c in range(len(real_set.clip_names)) if "cmu" in real_set.clip_names[c]]
    hits = [h for h in range(real_set.num_hits) if real_set.hit_clip[h] in captured]
    assert len(hits) == 22
    assert not real_set.labelled[hits].any()
    assert {real_set.hit_kind[h] for h in hits} == {"attack"}
    for h in hits:
        name = real_set.clip_names[real_set.hit_clip[h]]
        if name.endswith("~mirrored"):
            continue
        other = real_set.clip_names.index(f"{name}~mirrored")
        offset = real_set.clip_starts[other] - real_set.clip_starts[real_set.hit_clip[h]]
        (twin,) = np.flatnonzero(real_set.fastest == real_set.fastest[h] + offset)
        assert {real_set.hit_bone[h], real_set.hit_bone[twin]} == {"left_foot", "right_foot"}
        flipped = real_set.vectors.displacements[twin] * np.array([-1, 1, 1])
        np.testing.assert_allclose(real_set.vectors.displacements[h], flipped, atol=1e-3)


def test_kinds() -> None:
    config = KindConfig(pass_m_s=4.0, attack_m_s=8.0)
    assert [kind_of(v, config) for v in (0.0, 3.9, 4.0, 7.9, 8.0)] == [
        *("toss", "toss", "pass", "pass", "attack"),
    ]
    clips, labels = synthetic_kicks(takes=1, frame_rate=30.0)
    clip = replace(clips[0], name="mine")
    start, end = labels[clips[0].name][0].start_s, labels[clips[0].name][0].end_s
    named = {"mine": (Label(start_s=start, end_s=end, kind="attack"),)}
    built = build_clip_set([clip], labels=named, config=SMALL, takes=1)
    mine = [h for h in range(built.num_hits) if built.clip_names[built.hit_clip[h]] == "mine"]
    assert [built.hit_kind[h] for h in mine] == ["attack"]
    mirrored = built.clip_names.index("mine~mirrored")
    (twin,) = np.flatnonzero(built.hit_clip == mirrored)
    assert built.hit_kind[twin] == "attack"
    assert built.hit_bone[twin] == "right_foot"


def test_no_hit_is_one_clear_line() -> None:
    high = replace(SMALL, analysis=AnalysisConfig(height_m=9.0))
    with pytest.raises(MotionError, match=r"no hit found in the embedded clips: .* 9 m"):
        build_clip_set(config=high)
    idle = next(c for c in synthetic_kicks(frame_rate=30.0)[0] if c.name == "ball_idle")
    idle = replace(idle, name="standing")
    with pytest.raises(MotionError, match="no hit found in the captured clips"):
        build_clip_set([idle], config=SMALL)


def test_motion_vector_by_hand() -> None:
    # The bone goes 1 m ahead of a body that faces +X, then 0.5 m up, in steps of 0.1 s.
    path = np.array([[0, 0, 0], [1, 0, 0], [1, 0.5, 0], [1, 0.5, 0], [1, 0.5, 0.25]], float)
    hit = Hit(
        highest=(2,), fastest=1, top=2, before=1, after=3, hit_start=1, hit_stop=3, start=0, stop=5
    )
    config = AnalysisConfig(smoothing_s=0.0)
    got = motion_vector(hit, path, float(np.pi / 2), 10.0, config)
    expected = [[0, 0, 1], [0, 0.5, 0], [0, 0, 0], [-0.25, 0, 0]]
    np.testing.assert_allclose(got.displacements, expected, atol=1e-6)
    np.testing.assert_allclose(got.seconds, 0.1, rtol=1e-6)
    np.testing.assert_allclose(got.v_max, 10.0, rtol=1e-6)
    half = scaled(got, 0.5)
    np.testing.assert_allclose(half.displacements, 0.5 * got.displacements)
    np.testing.assert_allclose([half.v_max, half.seconds[0]], [5.0, 0.1], rtol=1e-6)


def test_kicks_do_not_depend_on_anything_but_the_seed() -> None:
    a, labels = synthetic_kicks(seed=3, takes=1, frame_rate=30.0)
    b, _ = synthetic_kicks(seed=3, takes=1, frame_rate=60.0)
    for x, y in zip(a, b, strict=True):
        other = y.motion.root_translation[::2][: x.motion.num_frames]
        np.testing.assert_allclose(x.motion.root_translation, other, atol=2e-3)
        places = np.asarray(global_positions(x.skeleton, x.motion))
        assert places[..., 1].min() > 0.0
        assert np.abs(np.diff(places, axis=0)).max() * 30 < 20.0
    assert {label.kind for items in labels.values() for label in items} == set(KINDS)
    with pytest.raises(MotionError, match="takes"):
        synthetic_kicks(takes=0)
    with pytest.raises(MotionError, match="frame rate"):
        synthetic_kicks(frame_rate=0)


def test_retarget_keeps_directions(capture) -> None:
    target = synthetic_kicks(takes=1, frame_rate=30.0)[0][0].skeleton
    source, motion = load_motion(capture / "ball" / "cmu10" / "10_03.amc")
    moved = retarget(source, motion, target)
    before = np.asarray(global_positions(source, motion))
    after = np.asarray(global_positions(target, moved))
    # Arms point where they pointed; legs nearly, as feet stand where they stood, scaled.
    for a, b, most in (
        ("lfemur", "ltibia", 0.12),
        ("rtibia", "rfoot", 0.12),
        ("lhumerus", "lradius", 1e-4),
        ("rradius", "rwrist", 1e-4),
    ):
        ways = [p[:, s.index(b)] - p[:, s.index(a)] for s, p in ((source, before), (target, after))]
        ways = [w / np.linalg.norm(w, axis=-1, keepdims=True) for w in ways]
        np.testing.assert_allclose(ways[0], ways[1], atol=most)
    thigh = after[:, target.index("ltibia")] - after[:, target.index("lfemur")]
    lengths = np.linalg.norm(thigh, axis=-1)
    np.testing.assert_allclose(lengths, 0.43, atol=1e-5)
    toes = [p[:, hit_joint(s, "right_foot"), 1] for s, p in ((source, before), (target, after))]
    assert np.abs(toes[0] - toes[1]).max() < 0.08


def test_a_skeleton_without_legs(body) -> None:
    stump = Skeleton(names=("root", "head"), parents=(-1, 0), offsets=np.ones((2, 3), np.float32))
    with pytest.raises(SkeletonError, match="left_hip"):
        leg_length(stump)
    clip = synthetic_kicks(takes=1, frame_rate=30.0)[0][0]
    with pytest.raises(SkeletonError, match="left_hip"):
        retarget(
            stump,
            replace(clip.motion, local_rotations=clip.motion.local_rotations[:, :2]),
            clip.skeleton,
        )
    assert leg_length(body) == pytest.approx(0.9)
    # A body with the same roles but other joints takes part.
    small = retarget(clip.skeleton, clip.motion, body)
    built = build_clip_set(
        [Clip(name="small", skeleton=body, motion=small)], config=ClipSetConfig(frame_rate=30.0)
    )
    assert built.num_hits == 12 + 2
