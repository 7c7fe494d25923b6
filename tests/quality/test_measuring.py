"""A motion beside capture."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mgjax.core.errors import FileFormatError, MotionError, SkeletonError
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.load import load_motion
from mgjax.quality.known import Captured, captured
from mgjax.quality.measuring import OTHER, SLOW, curves_of, measure
from mgjax.quality.result import FIGURES, NEEDS_CAPTURE, faults_of
from mgjax.quality.same_joints import in_order_of
from mgjax.quality.seams import seams_of
from mgjax.quality.subject import subject_of


@pytest.fixture(scope="module")
def known(body: Skeleton, motions: list[Motion]) -> Captured:
    return captured([(body, motion) for motion in motions])


def test_capture_beside_itself(body: Skeleton, motions: list[Motion], known: Captured) -> None:
    found = measure(body, motions[2], against=known)
    assert set(found.figures) == set(FIGURES) == set(found.beside)
    assert found.figures["limits"] == pytest.approx(0, abs=1e-3)
    assert found.figures["jerky"] <= 1 / 19
    assert found.figures["self_penetration"] == pytest.approx(0, abs=1e-6)
    assert (found.seconds, found.notes, found.at_seams) == (1.0, (), {})
    assert "limits" not in found.faults
    # Of all its own pieces the capture shows the same as the one that is as long.
    assert len(known.windows(1.0)["sink"]) == 3
    assert known.windows(1.0)["sink"].max() == pytest.approx(found.figures["sink"], rel=1e-4)


def test_what_is_wrong_is_found(body: Skeleton, motions: list[Motion], known: Captured) -> None:
    """It sinks, jumps, turns a knee too far, and slides: at one moment, which is a seam."""
    motion = motions[2]
    root = motion.root_translation.copy()
    root[30:] += np.array([0.2, -0.3, 0], np.float32)
    turns = motion.local_rotations.copy()
    knee = body.index("ltibia")
    turns[30:, knee] = [np.cos(0.6), np.sin(0.6), 0, 0]
    broken = replace(motion, root_translation=root, local_rotations=turns)
    found = measure(body, broken, against=known, seams=[(0.45, 0.55), (5.0, 6.0)])
    assert {"velocity_jump", "sink", "limits"} <= set(found.faults)
    assert found.figures["limits"] > 20
    assert found.figures["sink"] == pytest.approx(
        -np.asarray(global_positions(body, broken))[::2, :, 1].min(), abs=1e-4
    )
    assert found.at_seams["velocity_jump"] == found.figures["velocity_jump"] > 5
    assert found.at_seams["jerk_ratio"] == found.figures["jerk_ratio"] > 1
    assert set(found.at_seams) == set(FIGURES) - {"speed_distance"}
    before = measure(body, broken, against=known, seams=[(0.0, 0.2)])
    assert before.at_seams["velocity_jump"] < 0.1 * found.at_seams["velocity_jump"]


def test_curves(body: Skeleton, motions: list[Motion], known: Captured) -> None:
    found = curves_of(body, motions[0], known)
    assert found.height.shape == (21, 4)
    assert found.toe_speed.shape == (20, 2)
    assert found.skates.shape == (13,)
    assert found.jump.shape == (19, body.num_joints)
    assert found.jerk.shape[0] == 21 - 12
    quality = measure(body, motions[0], against=known)
    assert np.max(found.jump) == pytest.approx(quality.figures["velocity_jump"], rel=1e-5)


def test_joints_in_another_order(body: Skeleton, motions: list[Motion], known: Captured) -> None:
    order = [0, *range(7, 11), *range(3, 7), 1, 13, 14, 11, 12, 2]
    names = tuple(f"ns:{body.names[j]}" for j in order)
    other = Skeleton(
        names=(*names[:11], "somewhere", *names[12:13], "Site", *names[14:]),
        parents=tuple(-1 if (p := body.parents[j]) < 0 else order.index(p) for j in order),
        offsets=np.asarray(body.offsets)[order],
        end_joints=(11, 13),
    )
    motion = replace(motions[2], local_rotations=motions[2].local_rotations[:, order])
    back = in_order_of(body, other, motion)
    assert back is not None
    np.testing.assert_array_equal(global_positions(*back), global_positions(body, motions[2]))
    wanted, found = measure(body, motions[2], against=known), measure(other, motion, against=known)
    assert found.figures == pytest.approx(wanted.figures, rel=1e-5, nan_ok=True)
    assert found.beside == wanted.beside
    renamed = replace(other, names=("other", *other.names[1:]))
    assert in_order_of(body, renamed, motion) is None
    hung = replace(other, parents=(*other.parents[:-1], 0))
    assert in_order_of(body, hung, motion) is None
    strange = measure(renamed, motion, against=known)
    assert strange.notes == (OTHER,)
    assert all(math.isnan(strange.figures[key]) for key in NEEDS_CAPTURE)
    assert not set(NEEDS_CAPTURE) & set(strange.beside)
    assert strange.figures["skate_cm"] == pytest.approx(wanted.figures["skate_cm"], rel=1e-4)
    with pytest.raises(SkeletonError, match="two skeletons"):
        captured([(body, motions[0]), (renamed, motion)])


def test_what_has_no_body(known: Captured) -> None:
    prop = Skeleton(names=("box",), parents=(-1,), offsets=np.zeros((1, 3), np.float32))
    motion = Motion(
        root_translation=np.linspace(0, 1, 40, dtype=np.float32)[:, None] * np.ones(3, np.float32),
        local_rotations=np.tile(np.array([1, 0, 0, 0], np.float32), (40, 1, 1)),
        frame_rate=20.0,
    )
    found = measure(prop, motion)
    assert any("no feet" in note for note in found.notes)
    assert any("no limbs" in note for note in found.notes)
    assert SLOW in found.notes
    assert math.isnan(found.figures["skate_cm"])
    assert math.isnan(found.figures["self_penetration"])
    assert found.figures["velocity_jump"] == pytest.approx(0, abs=1e-3)
    assert found.faults == ()


def test_one_arm_and_no_toes(body: Skeleton, motions: list[Motion]) -> None:
    kept = [j for j, name in enumerate(body.names) if name not in ("rhumerus", "rhumerus_end")]
    kept = [j for j in kept if not body.names[j].endswith("toes")]
    less = Skeleton(
        names=tuple(body.names[j] for j in kept),
        parents=tuple(-1 if body.parents[j] < 0 else kept.index(body.parents[j]) for j in kept),
        offsets=np.asarray(body.offsets)[kept],
        end_joints=(kept.index(12),),
    )
    subject, notes = subject_of(less)
    assert len(subject.feet) == 4
    assert any("toes" in note for note in notes)
    assert len(subject.pairs.reach) > 0
    motion = replace(motions[0], local_rotations=motions[0].local_rotations[:, kept])
    assert np.isfinite(measure(less, motion).figures["skate_cm"])


def test_short_motions(body: Skeleton, motions: list[Motion]) -> None:
    short = replace(
        motions[0],
        root_translation=motions[0].root_translation[:8],
        local_rotations=motions[0].local_rotations[:8],
    )
    found = measure(body, short)
    assert math.isnan(found.figures["normalised_jerk"])
    assert np.isfinite(found.figures["velocity_jump"])
    one = replace(
        short,
        root_translation=short.root_translation[:1],
        local_rotations=short.local_rotations[:1],
    )
    with pytest.raises(MotionError, match="got a motion of 1 frames"):
        measure(body, one)
    with pytest.raises(SkeletonError, match="one clip or more"):
        captured([])


def test_faults() -> None:
    beside = {"skate_cm": (0.1, 0.2), "sink": (0.0, 0.001), "skate_ratio": (0.0, 0.1)}
    good = {"skate_cm": 0.21, "sink": 0.004, "skate_ratio": 0.1, "limits": 4.0}
    assert faults_of(good, beside, 1.0) == ()
    bad = {"skate_cm": 0.23, "sink": 0.006, "skate_ratio": 0.12, "limits": 6.0}
    assert faults_of(bad, beside, 1.0) == tuple(bad)
    assert faults_of({"sink": 0.006}, {}, 2.0) == ()
    assert faults_of({"skate_cm": 9.0, "velocity_jump": math.nan}, {}, 1.0) == ()


def test_seams_beside_a_file(tmp_path: Path) -> None:
    motion = tmp_path / "motion.bvh"
    assert seams_of(motion) == ()
    result = tmp_path / "result.json"
    result.write_text(json.dumps({"seams": [{"start_s": 1, "end_s": 1.5}]}))
    assert seams_of(motion) == ((1.0, 1.5),)
    assert seams_of(tmp_path / "other.bvh") == ()
    result.write_text("[1]")
    assert seams_of(motion) == ()
    for text, words in (
        ("{", "no JSON"),
        ('{"seams": 3}', "a list"),
        ('{"seams": [\n{"start_s": 1}]}', "result.json:2: got a seam from 1 to null"),
        ('{"seams": [{"start_s": 2, "end_s": 1}]}', "not before it"),
        ('{"seams": [[]]}', "start_s"),
        ('{"seams": [{"start_s": NaN, "end_s": 1}]}', "finite"),
    ):
        result.write_text(text)
        with pytest.raises(FileFormatError, match=words):
            seams_of(motion)


def test_real_capture(capture: Path) -> None:
    """Two exercises beside each other: no fault, and what is done to one of them is found."""
    folder = capture / "avoidance" / "cmu127"
    clips = [load_motion(folder / f"127_{name}.amc") for name in ("05", "06")]
    known = captured(clips)
    skeleton, motion = clips[0]
    found = measure(skeleton, motion, against=known)
    assert not {"limits", "self_penetration", "velocity_jump", "jerk_ratio"} & set(found.faults)
    slid = motion.root_translation + np.linspace(0, 1.5, motion.num_frames)[:, None] * [1, 0, 0]
    sliding = replace(motion, root_translation=slid.astype(np.float32))
    worse = measure(skeleton, sliding, against=known)
    assert worse.figures["skate_cm"] > 3 * found.figures["skate_cm"]
    assert "skate_cm" in worse.faults
