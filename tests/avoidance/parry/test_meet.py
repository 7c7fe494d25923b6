"""The arm that meets something, and its course: against plain NumPy, and worked by hand."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from mgjax.avoidance.parry.course import EARLY_S, FALL_S, RISE_S, STAY_S, course, share_at
from mgjax.avoidance.parry.meet import ArmPose, meet, turned
from mgjax.avoidance.rates import EXPORT_RATE
from tests.reference import parry as reference

ONE = np.array([[1.0, 0, 0, 0]])


def straight_arm() -> ArmPose:
    """Along x, 30 cm to the elbow and 30 cm on to the wrist."""
    places = {"shoulder": 0.0, "elbow": 0.3, "wrist": 0.6, "tip": 0.7}
    along = {name: np.array([[x, 0, 0]]) for name, x in places.items()}
    return ArmPose(**along, shoulder_turn=ONE, elbow_turn=ONE)


def test_a_straight_arm_meets_a_ball_on_a_line_worked_by_hand() -> None:
    # The wrist has to go to (0.3, 0, 0.3), √2 · 0.3 away: the elbow bends by a right angle. Its
    # elbow points backwards (−z), so the upper arm stays and the forearm turns from x to z, which
    # is −90° about y.
    arm = straight_arm()
    target = np.array([[0.3, 0, 0.3]])
    turns, missed = meet(arm, arm.wrist, target, np.zeros(1))
    assert float(missed[0]) < 1e-6
    np.testing.assert_allclose(turns[0], [[0, 0, 0], [0, -np.pi / 2, 0]], atol=1e-6)
    met = turned(arm, np.asarray(turns))
    np.testing.assert_allclose(met.elbow[0], [0.3, 0, 0], atol=1e-6)
    np.testing.assert_allclose(met.wrist[0], target[0], atol=1e-6)
    np.testing.assert_allclose(met.tip[0], [0.3, 0, 0.4], atol=1e-6)


def test_what_is_out_of_reach_is_missed_by_how_far_it_is() -> None:
    arm = straight_arm()
    _, missed = meet(arm, arm.wrist, np.array([[0.0, 0.9, 0]]), np.zeros(1))
    assert float(missed[0]) == pytest.approx(0.3, abs=1e-3)


def random_arms(count: int) -> tuple[ArmPose, np.ndarray, np.ndarray]:
    """Bent arms in any pose, targets within their reach, and swivels."""
    rng = np.random.default_rng(3)
    shoulder = rng.normal(size=(count, 3))
    first, second = rng.normal(size=(2, count, 3))
    first *= 0.3 / np.linalg.norm(first, axis=1, keepdims=True)
    second *= 0.25 / np.linalg.norm(second, axis=1, keepdims=True)
    turns = rng.normal(size=(2, count, 4))
    turns /= np.linalg.norm(turns, axis=-1, keepdims=True)
    elbow = shoulder + first
    wrist = elbow + second
    away = rng.normal(size=(count, 3))
    away *= rng.uniform(0.15, 0.5, size=(count, 1)) / np.linalg.norm(away, axis=1, keepdims=True)
    arm = ArmPose(
        shoulder=shoulder,
        elbow=elbow,
        wrist=wrist,
        tip=wrist + 0.3 * second + rng.normal(scale=0.01, size=(count, 3)),
        shoulder_turn=turns[0],
        elbow_turn=turns[1],
    )
    return arm, shoulder + away, rng.uniform(-1.5, 1.5, size=count)


def test_any_arm_meets_what_is_in_reach_as_forward_kinematics_has_it() -> None:
    arm, target, swivel = random_arms(40)
    vectors, missed = meet(arm, arm.wrist, target, swivel)
    assert np.asarray(missed).max() < 1e-6
    met = turned(arm, np.asarray(vectors))
    for row in range(len(swivel)):
        bones = (arm.shoulder[row], arm.elbow[row])
        frames = (arm.shoulder_turn[row], arm.elbow_turn[row], np.asarray(vectors)[row])
        elbow, wrist = reference.arm_turned(*bones, arm.wrist[row], *frames)
        np.testing.assert_allclose(wrist, target[row], atol=1e-6)
        np.testing.assert_allclose(met.elbow[row], elbow, atol=1e-9)
        np.testing.assert_allclose(met.wrist[row], wrist, atol=1e-9)
        _, tip = reference.arm_turned(*bones, arm.tip[row], *frames)
        np.testing.assert_allclose(met.tip[row], tip, atol=1e-9)


def test_the_elbow_bends_to_the_side_to_which_it_is_bent() -> None:
    arm, target, swivel = random_arms(40)
    met = turned(arm, np.asarray(meet(arm, arm.wrist, target, swivel)[0]))
    for before, after in ((arm, met),):
        normals = [np.cross(x.elbow - x.shoulder, x.wrist - x.elbow) for x in (before, after)]
        # In the frame of the upper arm the normal of both bones is the same.
        local = [
            np.stack([
                reference.kinematics.matrix(q).T @ (n / np.linalg.norm(n))
                for q, n in zip(np.asarray(x.shoulder_turn), normal, strict=True)
            ])
            for x, normal in zip((before, after), normals, strict=True)
        ]  # fmt: skip
        np.testing.assert_allclose(*local, atol=1e-5)


def test_compiled_as_eager() -> None:
    arm, target, swivel = jax.tree.map(lambda x: x.astype(np.float32), random_arms(40))
    eager = meet(arm, arm.wrist, target, swivel)
    compiled = jax.jit(meet)(arm, arm.wrist, target, swivel)
    for one, other in zip(eager, compiled, strict=True):
        np.testing.assert_allclose(one, other, atol=2e-5)


@pytest.mark.parametrize("contact", [1.1, 0.25])
def test_the_course_begins_and_ends_without_a_jerk(contact: float) -> None:
    when = np.array([contact])
    begin, end = max(contact - EARLY_S - RISE_S, 0.0), contact + STAY_S + FALL_S
    times = np.linspace(begin - 0.1, end + 0.1, 4001)
    share = np.asarray(share_at(times[None], when))[0]
    inside = (times > begin) & (times < end)
    assert (share[~inside] == 0).all()
    assert share.max() == 1.0
    assert share_at(np.array([[contact]]), when)[0, 0] == 1.0
    step = times[1] - times[0]
    # Of a quintic step over d the second derivative is at most 5.774 / d², and it is continuous.
    second = np.diff(share, n=2) / step**2
    shortest = min(contact - EARLY_S - begin, FALL_S)
    assert np.abs(second).max() < 5.78 / shortest**2
    assert np.abs(np.diff(second)).max() < 70 * step / shortest**3
    start, values = course(contact, np.array([[0.3, 0, 0], [0, -0.2, 0.1]]))
    np.testing.assert_allclose(values[[0, -1]], 0.0, atol=1e-12)
    there = round((contact - start) * EXPORT_RATE)
    np.testing.assert_allclose(values[there], [0.3, 0, 0, 0, -0.2, 0.1], atol=1e-12)
