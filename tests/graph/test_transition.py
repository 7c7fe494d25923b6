from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.core.motion import Motion
from mgjax.graph.distances.distance import normalised_weights
from mgjax.graph.feet.legs import foot_chains
from mgjax.graph.transition import CHUNK, build_transitions
from tests.graph.made import BODY, march, places
from tests.reference import graph as reference
from tests.reference import kinematics

WEIGHTS = normalised_weights(None, BODY.num_joints)


def assert_same_turns(got, want, atol=1e-5) -> None:
    """Quaternions [..., 4] against rotation matrices [..., 3, 3]."""
    for index in np.ndindex(*np.shape(got)[:-1]):
        np.testing.assert_allclose(kinematics.matrix(got[index]), want[index], atol=atol)


def transitions(motions: list[Motion], rows, columns, window: int, *, clean=False, form="paper"):
    """Of clips one after another; rows and columns count on their common axis."""
    positions = np.concatenate([places(m) for m in motions])
    return build_transitions(
        BODY,
        np.concatenate([m.root_translation for m in motions]),
        np.concatenate([m.local_rotations for m in motions]),
        positions,
        positions[:, [BODY.index("ltoes"), BODY.index("rtoes")], 1] < 0.06,
        foot_chains(BODY),
        np.array(rows, np.int64),
        np.array(columns, np.int64),
        WEIGHTS,
        window,
        form=form,
        clean=clean,
    )


def test_the_sign_of_a_quaternion_does_not_matter():
    a, b = march(12, seed=1), march(12, seed=2)
    flipped = b.local_rotations * np.where(np.arange(BODY.num_joints) % 2, -1, 1)[None, :, None]
    other = replace(b, local_rotations=flipped.astype(np.float32))
    one = transitions([a, b], [1], [13], 5)
    two = transitions([a, other], [1], [13], 5)
    np.testing.assert_allclose(one[0], two[0], atol=1e-6)
    want = np.vectorize(kinematics.matrix, signature="(q)->(i,j)")(one[1])
    assert_same_turns(two[1], want)
    # And no joint goes the long way round: in each step of the blend less than in all.
    between = np.sum(one[1][0, 1:] * one[1][0, :-1], axis=-1)
    assert np.abs(between).min() > np.cos(0.25)


@pytest.mark.parametrize("window", [1, 4, 10])
def test_whole_transitions_against_the_reference(window):
    a = march(30, seed=1, speed=0.5)
    b = march(30, seed=2, heading=2.0, place=(20.0, 5.0), swing=0.5)
    rows, columns = [3, 12, 31], [32, 47, 8]
    root, rotations, transforms, slides = transitions([a, b], rows, columns, window)
    assert root.shape == (3, window + 1, 3)
    assert rotations.shape == (3, window + 1, BODY.num_joints, 4)
    np.testing.assert_array_equal(slides, 0)
    all_root = np.concatenate([a.root_translation, b.root_translation])
    all_turns = np.concatenate([a.local_rotations, b.local_rotations])
    p = np.concatenate([places(a), places(b)])
    w = reference.cloud_weights(None, BODY.num_joints, window)
    for m, (r, c) in enumerate(zip(rows, columns, strict=True)):
        transform = reference.align(reference.cloud(p, r, window), reference.cloud(p, c, window), w)
        np.testing.assert_allclose(
            np.exp(1j * transforms[m, 0]), np.exp(1j * transform[0]), atol=1e-5
        )
        np.testing.assert_allclose(transforms[m, 1:], transform[1:], atol=2e-4)
        want_root, want_turns = reference.blend(
            all_root[r : r + window],
            all_turns[r : r + window],
            all_root[c : c + window],
            all_turns[c : c + window],
            transform,
        )
        np.testing.assert_allclose(root[m, :-1], want_root, atol=2e-4)
        assert_same_turns(rotations[m, :-1], want_turns, atol=2e-4)
        # After the window comes B's next frame, mapped.
        arrival = kinematics.planar_apply(transform, all_root[c + window])
        np.testing.assert_allclose(root[m, -1], arrival, atol=2e-4)
        turn = kinematics.axis_rotation("Y", transform[0])
        np.testing.assert_allclose(
            kinematics.matrix(rotations[m, -1, 0]),
            turn @ kinematics.matrix(all_turns[c + window, 0]),
            atol=1e-4,
        )
        np.testing.assert_allclose(rotations[m, -1, 1:], all_turns[c + window, 1:], atol=1e-6)


def test_the_blend_begins_near_a_and_ends_at_b():
    a, b = march(30, seed=1), march(30, seed=2, heading=1.0)
    window = 10
    root, rotations, transforms, _ = transitions([a, b], [5], [37], window)
    share = 1 - reference.alpha(0, window)
    assert share < 0.03
    mapped = kinematics.planar_apply(transforms[0], b.root_translation[7])
    apart = np.linalg.norm(a.root_translation[5] - mapped)
    assert np.linalg.norm(root[0, 0] - a.root_translation[5]) <= share * apart + 1e-5
    # The last blended frame is all B.
    want = kinematics.planar_apply(transforms[0], b.root_translation[7 + window - 1])
    np.testing.assert_allclose(root[0, window - 1], want, atol=1e-5)
    np.testing.assert_allclose(
        np.abs(np.sum(rotations[0, window - 1, 1:] * b.local_rotations[16, 1:], axis=-1)),
        1.0,
        atol=1e-6,
    )


def test_a_transition_between_equal_windows_changes_nothing():
    a = march(40, seed=1, speed=0.7)
    far = march(40, seed=1, speed=0.7, place=(12.0, -9.0))
    root, rotations, transforms, _ = transitions([a, far], [8], [48], 10)
    np.testing.assert_allclose(transforms[0], [0, -12, 9], atol=1e-4)
    np.testing.assert_allclose(root[0], a.root_translation[8:19], atol=1e-4)
    np.testing.assert_allclose(rotations[0], a.local_rotations[8:19], atol=1e-4)


@pytest.mark.parametrize("clean", [False, True])
def test_a_batch_of_one_equals_its_part_of_the_whole(clean):
    clips = [march(40, seed=1), march(40, seed=2, heading=0.4)]
    rng = np.random.default_rng(0)
    rows, columns = rng.integers(1, 28, 7), rng.integers(41, 68, 7)
    whole = transitions(clips, rows, columns, 8, clean=clean)
    for m in (0, 3, 6):
        one = transitions(clips, rows[m : m + 1], columns[m : m + 1], 8, clean=clean)
        for x, y in zip(one, whole, strict=True):
            np.testing.assert_array_equal(x[0], y[m])


def test_more_transitions_than_one_call_takes():
    clips = [march(40, seed=1), march(40, seed=2)]
    count = CHUNK + 3
    rng = np.random.default_rng(1)
    rows, columns = rng.integers(1, 28, count), rng.integers(41, 68, count)
    whole = transitions(clips, rows, columns, 8)
    tail = transitions(clips, rows[CHUNK:], columns[CHUNK:], 8)
    assert len(whole[0]) == count
    for x, y in zip(whole, tail, strict=True):
        np.testing.assert_array_equal(x[CHUNK:], y)


def test_none_at_all():
    root, rotations, transforms, slides = transitions([march(20)], [], [], 5)
    assert root.shape == (0, 6, 3)
    assert rotations.shape == (0, 6, BODY.num_joints, 4)
    assert transforms.shape == (0, 3)
    assert slides.shape == (0, 2)
