from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgjax.core import quaternion
from mgjax.core.errors import ConfigError
from mgjax.graph.blending.forms import blend_form, blend_weights, inertia, smooth_weights
from mgjax.graph.blending.mixing import Window, blend, lead_by_support, mix
from mgjax.graph.config import BLENDS, GraphConfig, validate_graph_config
from mgjax.graph.feet.legs import foot_chains
from tests.conftest import make_motion
from tests.graph.made import BODY, march, places
from tests.reference import blend as reference
from tests.reference import kinematics
from tests.reference.graph import alpha

CHAINS = foot_chains(BODY)
KINDS = {"paper": "paper", "smooth": "smooth", "inertial": "inertial", "support": "crossfade"}
"""Forms of different decay, and how the reference calls it."""


def decay_of(form: str, window: int) -> jax.Array:
    return jnp.asarray(blend_form(form, window).decay)


def window_of(motion) -> Window:
    arrays = motion.root_translation, motion.local_rotations, places(motion)
    return Window(*(jnp.asarray(x) for x in arrays))


def test_paper_weights():
    np.testing.assert_allclose(blend_weights(2), [0.5, 0.0])
    np.testing.assert_allclose(blend_weights(4), [27 / 32, 0.5, 5 / 32, 0.0])
    for window in (1, 2, 10, 13):
        want = [alpha(p, window) for p in range(window)]
        np.testing.assert_allclose(blend_weights(window), want, atol=1e-6)
    assert alpha(-1, 10) == alpha(-5, 10) == 1
    assert alpha(10, 10) == 0


def test_curves_worked_by_hand():
    # u = 0, ½, 1; at ½ the quintic is ½, and W (u − 6u³ + 8u⁴ − 3u⁵) = 2 · 5/32.
    np.testing.assert_allclose(smooth_weights(2), [1, 0.5, 0])
    np.testing.assert_allclose(inertia(2), [[1, 0, 0], [0.5 - 5 / 16, 5 / 16, 0], [0, 0, 0]])


@pytest.mark.parametrize("form", KINDS)
@pytest.mark.parametrize("window", [1, 4, 10])
def test_decay_against_the_reference(form, window):
    differences = np.random.default_rng(window).normal(size=(window + 1, 3))
    got = np.asarray(decay_of(form, window)) @ differences
    np.testing.assert_allclose(got, reference.offsets(KINDS[form], differences), atol=1e-5)


@pytest.mark.parametrize("form", ["smooth", "inertial", "support"])
def test_an_offset_goes_on_as_it_was_and_comes_to_rest(form):
    fine = 200  # frames, so that differences are derivatives
    x = 0.3 + 0.8 * np.arange(fine + 1)[:, None] / fine
    left = np.asarray(blend_form(form, fine).decay, np.float64) @ x
    assert left[0] == pytest.approx(x[0])
    assert (left[1] - left[0]) * fine == pytest.approx(0.8, abs=0.05)
    assert left[-1] == 0
    assert (left[-1] - left[-2]) * fine == pytest.approx(0, abs=0.05)


@pytest.mark.parametrize("form", ["smooth", "inertial", "support"])
@given(st.integers(0, 10**6), st.sampled_from([1, 2, 5]))
def test_blend_against_the_reference(form, seed, window):
    a, b = march(window + 1, seed=seed, swing=0.9), make_motion(BODY, 1, seed=seed)
    apart = quaternion.multiply(b.local_rotations, march(window + 1, seed=3).local_rotations)
    root_b = b.root_translation + 0.1 * a.root_translation[::-1]
    transform = np.random.default_rng(seed).uniform(-3, 3, 3).astype(np.float32)
    arrays = (a.root_translation, a.local_rotations, root_b, np.asarray(apart), transform)
    root, rotations = blend(
        *(jnp.asarray(x, jnp.float32) for x in arrays), decay_of(form, window), continuous=True
    )
    want_root, want_turns = reference.blend(KINDS[form], *arrays)
    np.testing.assert_allclose(root, want_root, atol=2e-5)
    turn = (np.cos(transform[0] / 2), 0, np.sin(transform[0] / 2), 0)
    for j in range(BODY.num_joints):
        first, last = a.local_rotations[window // 2 + window % 2, j], apart[(window + 1) // 2, j]
        other = quaternion.multiply(np.array(turn), last) if j == 0 else last
        if abs(np.dot(first, other)) > 0.02:  # else the shorter arc is not defined
            for p in range(window + 1):
                got = kinematics.matrix(rotations[p, j])
                np.testing.assert_allclose(got, want_turns[p, j], atol=5e-4)


@given(st.integers(0, 10**6), st.sampled_from([1, 2, 5]))
def test_the_papers_blend_against_slerp(seed, window):
    a, b = (make_motion(BODY, window + 1, seed=seed + i) for i in range(2))
    arrays = (a.root_translation, a.local_rotations, b.root_translation, b.local_rotations)
    arguments = (*(jnp.asarray(x) for x in arrays), jnp.zeros(3), decay_of("paper", window))
    root, rotations = blend(*arguments, continuous=False)
    for p in range(window + 1):
        share = alpha(p, window) if p < window else 0.0
        want = share * a.root_translation[p] + (1 - share) * b.root_translation[p]
        np.testing.assert_allclose(root[p], want, atol=1e-5)
        for j in range(BODY.num_joints):
            ends = a.local_rotations[p, j], b.local_rotations[p, j]
            if abs(np.dot(*ends)) > 0.02:
                want = kinematics.slerp(*ends, 1 - share)
                np.testing.assert_allclose(kinematics.matrix(rotations[p, j]), want, atol=3e-4)


def test_blend_worked_by_hand():
    # A stands at the origin, not turned; B at (0, 0, 1), turned by 90° about X, and is mapped by a
    # quarter turn about Y and 1 m along x: to (2, 0, 0). Half-way it is at (1, 0, 0).
    root_a, turn_a = jnp.zeros((3, 3)), jnp.tile(jnp.array([1.0, 0, 0, 0]), (3, 2, 1))
    root_b = jnp.tile(jnp.array([0.0, 0, 1]), (3, 1))
    half = np.sqrt(0.5)
    turn_b = jnp.tile(jnp.array([half, half, 0, 0], jnp.float32), (3, 2, 1))
    arrays = (root_a, turn_a, root_b, turn_b, jnp.array([np.pi / 2, 1, 0]))
    root, rotations = blend(*arrays, decay_of("support", 2), continuous=True)
    np.testing.assert_allclose(root, [[0, 0, 0], [1, 0, 0], [2, 0, 0]], atol=1e-6)
    # Joint 1 is halfway at 45° about X, then all the way.
    eighth = np.cos(np.pi / 8), np.sin(np.pi / 8)
    np.testing.assert_allclose(rotations[1, 1], [*eighth, 0, 0], atol=1e-6)
    np.testing.assert_allclose(rotations[2, 1], [half, half, 0, 0], atol=1e-6)
    # The root arrives at Ry(90°)·Rx(90°).
    want = kinematics.axis_rotation("Y", np.pi / 2) @ kinematics.axis_rotation("X", np.pi / 2)
    np.testing.assert_allclose(kinematics.matrix(rotations[2, 0]), want, atol=1e-6)


@pytest.mark.parametrize("form", ["smooth", "inertial", "support"])
def test_a_long_blend_over_half_a_turn_does_not_flip(form):
    # The two turn about X by 150° … 210° against each other; frame by frame, the shorter arc
    # changes sides in the middle, by up to 180°. Stored signs change at random.
    window = 40
    apart = np.deg2rad(np.linspace(150, 210, window + 1))
    axis = np.tile([1.0, 0.0, 0.0], (window + 1, 1))
    a = quaternion.from_axis_angle(axis, apart)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (2, window + 1, 1))
    b = quaternion.from_axis_angle(axis, 0 * apart)
    turns = [jnp.asarray(s * q, jnp.float32)[:, None] for s, q in zip(signs, (a, b), strict=True)]
    nothing, still = jnp.zeros((window + 1, 3)), jnp.zeros(3)

    def steps(name: str, *, continuous: bool) -> np.ndarray:
        arguments = (nothing, turns[0], nothing, turns[1], still, decay_of(name, window))
        rotations = np.asarray(blend(*arguments, continuous=continuous)[1])[:, 0]
        near = np.abs(np.sum(rotations[1:] * rotations[:-1], axis=-1))
        if continuous:  # and the signs go on
            assert np.all(np.sum(rotations[1:] * rotations[:-1], axis=-1) > 0)
        return np.rad2deg(2 * np.arccos(np.minimum(near, 1)))

    assert steps(form, continuous=True).max() < 15
    if form != "inertial":  # that looks at the first two frames only
        assert steps(form, continuous=False).max() > 90


@pytest.mark.parametrize("form", ["smooth+support", "inertial+support", "support"])
def test_a_led_root_against_the_reference(form):
    a, b = march(6, seed=1, swing=0.9), march(6, seed=2, swing=0.2)
    standing = np.array([[1, 0], [1, 0], [1, 1], [0, 1], [0, 0]], dtype=bool)
    first, second, decay = window_of(a), window_of(b), decay_of(form, 5)
    still = jnp.zeros(3)
    root, rotations = blend(*first[:2], *second[:2], still, decay, continuous=True)
    arguments = (first.places, second.places, jnp.asarray(standing), decay)
    got = lead_by_support(BODY, CHAINS, root, rotations, *arguments)
    where = kinematics.global_positions(BODY.parents, np.asarray(BODY.offsets), root, rotations)
    balls = list(CHAINS.balls)
    kind = {"support": "crossfade"}.get(form, form.split("+")[0])
    want = reference.led(
        kind, root, where[:, balls], first.places[:, balls], second.places[:, balls], standing
    )
    np.testing.assert_allclose(got, want, atol=2e-5)
    assert np.abs(np.asarray(got) - np.asarray(root)).max() > 5e-4
    assert np.array_equal(got[0], root[0])
    assert np.array_equal(got[-1], root[-1])


def test_a_foot_at_one_place_in_both_does_not_move():
    # The right foot is brought to the origin in both, as if it stood there.
    a, b = (window_of(march(11, seed=s, swing=w, noise=0)) for s, w in ((1, 0.2), (1, 0.5)))
    ball = CHAINS.balls[1]
    a, b = (w._replace(root=w.root - w.places[:, ball]) for w in (a, b))
    a, b = (w._replace(places=w.places - w.places[:, ball, None]) for w in (a, b))
    standing = jnp.tile(jnp.array([False, True]), (10, 1))
    travels = []
    for chains in (None, CHAINS):
        root, rotations = mix(
            BODY, chains, a, b, standing, jnp.zeros(3), decay_of("support", 10), continuous=True
        )
        where = kinematics.global_positions(BODY.parents, np.asarray(BODY.offsets), root, rotations)
        travels.append(np.abs(where[:, ball]).max())
    assert travels[1] < 1e-5
    assert travels[0] > 1e-3


def test_jit_and_vmap_agree_with_the_plain_call():
    pairs = [
        (window_of(march(7, seed=s)), window_of(march(7, seed=s + 9, heading=1.0))) for s in (0, 1)
    ]
    standing = jnp.tile(jnp.array([True, False]), (6, 1))
    call = partial(mix, BODY, CHAINS, continuous=True)

    def one(a, b):
        return call(a, b, standing, jnp.array([0.3, 1.0, 2.0]), decay_of("support", 6))

    plain = [one(*pair) for pair in pairs]
    batch = jax.jit(jax.vmap(one))(
        *(jax.tree.map(lambda *x: jnp.stack(x), *y) for y in zip(*pairs, strict=True))
    )
    for i, results in enumerate(plain):
        for x, y in zip(results, batch, strict=True):
            np.testing.assert_allclose(x, y[i], atol=1e-5)


def test_gradients_are_finite_also_between_equal_windows():
    a, b = window_of(march(7, seed=1)), window_of(march(7, seed=2))
    standing = jnp.ones((6, 2), dtype=bool)

    def total(x: Window, y: Window) -> jax.Array:
        arguments = (standing, jnp.zeros(3), decay_of("inertial", 6))
        root, rotations = mix(BODY, CHAINS, x, y, *arguments, continuous=True)
        return jnp.sum(root) + jnp.sum(rotations[..., 1:])

    for other in (a, b):
        for leaf in jax.tree.leaves(jax.jit(jax.grad(total, argnums=(0, 1)))(a, other)):
            assert jnp.isfinite(leaf).all()


def test_unknown_names():
    with pytest.raises(ConfigError, match="got blend = 'fade', expected support or paper"):
        validate_graph_config(GraphConfig(blend="fade"))
    with pytest.raises(ConfigError, match="expected support or paper"):
        blend_form("fade", 10)
    for name in BLENDS:
        validate_graph_config(GraphConfig(blend=name))
        assert blend_form(name, 10).decay.shape == (11, 11)
