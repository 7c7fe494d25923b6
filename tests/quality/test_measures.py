"""All measures against their definitions, alone and in batches, for bodies of any size."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, resample
from mgjax.core.skeleton import Skeleton
from mgjax.quality.kernel import curves, figures, measured, no_extremes, speeds
from mgjax.quality.speeds import hellinger
from mgjax.quality.subject import subject_of
from mgjax.quality.tracks import LEAST_FRAMES, make_tracks
from tests.quality.moving import moving
from tests.reference import quality as reference
from tests.sized import body_of_size, motion_of_size

LENGTHS = ("contact_speed", "skate_cm", "velocity_jump", "sink", "floating", "self_penetration")


def places_of(skeleton: Skeleton, motion: Motion, rate: float) -> np.ndarray:
    slow = resample(motion, rate)
    double = replace(
        slow,
        root_translation=np.asarray(slow.root_translation, np.float64),
        local_rotations=np.asarray(slow.local_rotations, np.float64),
    )
    return np.asarray(global_positions(skeleton, double))


@pytest.fixture(scope="module")
def found(body: Skeleton, motions: list[Motion]) -> dict[str, np.ndarray]:
    subject, notes = subject_of(body)
    assert notes == ()
    tracks = make_tracks(body, subject, motions)
    assert tracks.places.shape[1] == LEAST_FRAMES > tracks.counts.max()
    values = measured(tracks, subject, no_extremes(subject))
    return {key: np.asarray(value) for key, value in values.items()}


def test_against_the_definitions(
    body: Skeleton, motions: list[Motion], found: dict[str, np.ndarray]
) -> None:
    subject, _ = subject_of(body)
    scale = float(subject.scale)
    ankles = [body.index("lfoot"), body.index("rfoot")]
    toes = [body.index("ltoes"), body.index("rtoes")]
    assert np.asarray(subject.feet).tolist() == toes + ankles
    for number, motion in enumerate(motions):
        places = places_of(body, motion, 30.0)
        rests = np.quantile(places[:, toes + ankles, 1], 0.01, axis=0)
        speed, fast = reference.contact_speed(places[:, toes], scale=scale)
        jerk = reference.normalised_jerk(places[:, np.asarray(subject.joints)], scale=scale)
        wanted = {
            "skate_ratio": reference.skate_ratio(places_of(body, motion, 20.0)[:, toes], scale),
            "contact_speed": speed,
            "contact_fast": fast,
            "skate_cm": reference.skate_cm(places[:, toes + ankles], rests, scale),
            "normalised_jerk": np.exp(np.log(jerk).mean()),
            "jerk_ratio": jerk.max(),
            "velocity_jump": reference.velocity_jump(places),
            "sink": max(0.0, -places[:, toes + ankles, 1].min()),
            "floating": reference.floating(places[:, toes], rests[:2], scale=scale),
        }
        for key, value in wanted.items():
            np.testing.assert_allclose(found[key][number], value, rtol=5e-3, atol=1e-5, err_msg=key)
    # The motions show something of everything.
    assert 0 < found["skate_ratio"].max() < 1
    assert found["sink"].max() > 0
    assert found["skate_cm"].min() > 0
    assert np.isfinite(found["floating"]).any()


def test_histograms(body: Skeleton, motions: list[Motion]) -> None:
    subject, _ = subject_of(body)
    got = np.asarray(speeds(make_tracks(body, subject, motions), subject), np.float64)
    for number, motion in enumerate(motions):
        places = places_of(body, motion, 30.0)
        wanted = reference.histogram(places, scale=float(subject.scale))
        assert got[number].sum() == wanted.sum()
        assert np.abs(got[number] - wanted).sum() <= 4  # speeds at the edge of a bin
    assert hellinger(got[0], got[0]) == pytest.approx(np.zeros(body.num_joints), abs=1e-6)
    distances = [reference.hellinger(a, b) for a, b in zip(got[0], got[1], strict=True)]
    np.testing.assert_allclose(hellinger(got[0], got[1]), distances, atol=1e-6)
    one, both, other = np.array([[4.0, 0, 0], [2, 2, 0], [0, 0, 7]])
    assert hellinger(one, other) == pytest.approx(1.0)
    assert hellinger(one, both) == pytest.approx(np.sqrt(1 - np.sqrt(0.5)))


def test_alone_and_without_compilation(
    body: Skeleton, motions: list[Motion], found: dict[str, np.ndarray]
) -> None:
    """Neither padding nor the motions beside it change the figures of one."""
    subject, _ = subject_of(body)
    extremes = no_extremes(subject)
    tracks = make_tracks(body, subject, motions)
    track = jax.tree.map(lambda x: jnp.asarray(x[0]), tracks)
    bare = replace(
        track,
        places=track.places[: int(tracks.counts[0])],
        turns=track.turns[: int(tracks.counts[0])],
        toes=track.toes[: int(tracks.toe_counts[0])],
    )
    with jax.disable_jit():
        alone = figures(curves(bare, subject, extremes), subject, extremes)
    for key, value in alone.items():
        np.testing.assert_allclose(value, found[key][0], rtol=1e-3, atol=1e-6, err_msg=key)


@pytest.mark.parametrize("size", [0.5, 2.0])
def test_another_size(
    body: Skeleton, motions: list[Motion], found: dict[str, np.ndarray], size: float
) -> None:
    skeleton = body_of_size(body, size)
    subject, _ = subject_of(skeleton)
    tracks = make_tracks(skeleton, subject, [motion_of_size(motion, size) for motion in motions])
    got = measured(tracks, subject, no_extremes(subject))
    for key, value in found.items():
        factor = size if key in LENGTHS else 1.0
        np.testing.assert_allclose(got[key], factor * value, rtol=2e-3, atol=1e-6, err_msg=key)


def test_spans(body: Skeleton) -> None:
    """Frames outside of a span do not count, but windows that reach into it do."""
    subject, _ = subject_of(body)
    pose = moving(body, 1.0, 5, 30.0)
    turns = np.tile(pose.local_rotations[:1], (30, 1, 1))
    root = np.tile(pose.root_translation[:1], (30, 1))
    root[10:] += np.array([0.5, 0, 0], np.float32)  # it jumps between frames 9 and 10
    jumping = Motion(root_translation=root, local_rotations=turns, frame_rate=30.0)
    spans = [(0.0, 8 / 30), (9 / 30, 12 / 30), (23 / 30, 29 / 30)]
    tracks = make_tracks(body, subject, [jumping] * 3, spans_s=spans)
    np.testing.assert_array_equal(tracks.spans, [[0, 8], [9, 12], [23, 29]])
    np.testing.assert_array_equal(tracks.toe_spans, [[0, 5], [6, 8], [16, 19]])
    got = measured(tracks, subject, no_extremes(subject))
    assert np.asarray(got["velocity_jump"]) == pytest.approx([0, 15, 0], abs=1e-2)
    assert np.asarray(got["skate_cm"])[[0, 2]] == pytest.approx([0, 0], abs=1e-4)
    assert float(got["skate_cm"][1]) > 1
    jerk = np.asarray(got["jerk_ratio"])
    assert jerk[0] == pytest.approx(jerk[1])  # a window of frames 0 … 8 reaches frame 10
    assert jerk[2] < 1e-3 * jerk[1]
