from __future__ import annotations

import math

import chex
import hypothesis
import hypothesis.strategies as st
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.ballsport import BallPhysics, ball_states, contact_times, fly
from mgjax.ballsport.ball.trajectory import BOUNCES
from tests.reference import ball as reference

PAPER = BallPhysics()
VACUUM = BallPhysics(drag=0.0)
TIMES = np.linspace(0.0, 1.6, 161).astype(np.float32)
QUADRATIC = BallPhysics(drag=0.013, drag_law="quadratic")


def launches(count: int, seed: int = 0) -> list[tuple[np.ndarray, np.ndarray]]:
    """Starts on the ground and above it, velocities from a touch to a hard kick, down and up."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        place = rng.uniform(-5, 5, 3)
        place[1] = rng.choice([0.11, 0.3, 1.0, 2.5])
        velocity = rng.uniform(-12, 12, 3) * rng.choice([0.1, 1.0, 2.0])
        found.append((place.astype(np.float32), velocity.astype(np.float32)))
    return found


@pytest.mark.parametrize(
    ("physics", "count"),
    [
        (PAPER, 60),
        (VACUUM, 15),
        (BallPhysics(drag=2.0, restitution=0.8, radius=0.2, gravity=3.7), 15),
        (QUADRATIC, 6),
        (BallPhysics(drag_law="quadratic"), 6),
    ],
    ids=["paper", "vacuum", "thick", "football", "quadratic"],
)
def test_agrees_with_the_integrator(physics: BallPhysics, count: int) -> None:
    for place, velocity in launches(count):
        got = fly(place, velocity, TIMES, physics=physics)
        wanted = reference.fly(place, velocity, TIMES.astype(float), physics)
        np.testing.assert_allclose(got, wanted, atol=5e-5)


def test_reference_in_closed_form_is_the_adaptive_one() -> None:
    # Linear drag flown by the adaptive integrator, arc by arc, is the reference's closed form.
    for place, velocity in launches(5, seed=3):
        x, v = place.astype(float), velocity.astype(float)
        x[1] += 0.01
        time, x1, v1 = reference.integrated(x, v, 100.0, PAPER, until_ground=True)
        closed = reference.contact(x, v, PAPER)
        np.testing.assert_allclose(time, closed[0], atol=1e-9)
        np.testing.assert_allclose([x1, v1], closed[1:], atol=1e-8)


def test_drop_by_hand() -> None:
    # From 1 m above rest height without drag: contact after √(2/9.8) s at √19.6 m/s; it rises with
    # 0.7 of that, to 0.49 m, its highest point 0.7 √(2/9.8) s later, and touches again as much on.
    first = math.sqrt(2 / 9.8)
    start, rest = np.array([0, 1.11, 0], np.float32), np.zeros(3, np.float32)
    contacts = contact_times(start, rest, physics=VACUUM)
    np.testing.assert_allclose(contacts[:3], [first, 2.4 * first, 3.38 * first], rtol=1e-6)
    times = np.array([0.0, first, 1.7 * first, 2.4 * first], np.float32)
    got = fly(start, rest, times, physics=VACUUM)
    np.testing.assert_allclose(got[:, 1], [1.11, 0.11, 0.11 + 0.49, 0.11], atol=3e-6)
    assert (np.asarray(got)[:, [0, 2]] == 0).all()


def test_projectile_by_hand() -> None:
    # Without drag x = vt, y = y₀ + vt − 4.9 t². With drag 0.5 after 1 s: the way is 2 (1 − e^−½) of
    # the speed.
    start, v = np.array([1, 2, 3], np.float32), np.array([4, 3, -2], np.float32)
    t = np.array([0.5], np.float32)
    got = fly(start, v, t, physics=VACUUM)
    np.testing.assert_allclose(got[0], [3.0, 2 + 1.5 - 1.225, 2.0], atol=1e-6)
    high = np.array([1, 20, 3], np.float32)
    got = fly(high, v, np.ones(1, np.float32), physics=BallPhysics(drag=0.5))
    gain = 2 * (1 - math.exp(-0.5))
    np.testing.assert_allclose(got[0, 0], 1 + 4 * gain, atol=1e-6)
    # y: (3 + 9.8/0.5) of the same, less the terminal speed 19.6 m/s times 1 s.
    np.testing.assert_allclose(got[0, 1], 20 + 22.6 * gain - 19.6, atol=1e-5)


@pytest.mark.parametrize("physics", [PAPER, VACUUM, QUADRATIC, BallPhysics(restitution=1.0)])
def test_energy_never_grows(physics: BallPhysics) -> None:
    for place, velocity in launches(8, seed=1):
        x, v = (np.asarray(a) for a in ball_states(place, velocity, TIMES, physics=physics))
        energy = 9.8 * x[:, 1] + (v**2).sum(axis=1) / 2
        assert (np.diff(energy) <= 1e-5 * energy[0]).all()
        assert (x[:, 1] >= np.float32(0.11)).all()


def test_beyond_the_capacity_it_rolls() -> None:
    # A ball that loses nothing: at the contact after the last bounce its vertical speed is gone.
    lively = BallPhysics(drag=0.0, restitution=1.0)
    start, v = np.array([0, 0.2, 0], np.float32), np.array([1, 0, 2], np.float32)
    contacts = np.asarray(contact_times(start, v, physics=lively))
    assert contacts.shape == (BOUNCES + 1,)
    one = math.sqrt(2 * 0.09 / 9.8)
    np.testing.assert_allclose(contacts, one * (1 + 2 * np.arange(BOUNCES + 1)), rtol=1e-5)
    times = np.array([contacts[-1] - one, contacts[-1] + 1, contacts[-1] + 2], np.float32)
    x = np.asarray(fly(start, v, times, physics=lively))
    np.testing.assert_allclose(x[:, 1], [0.2, 0.11, 0.11], atol=1e-5)
    np.testing.assert_allclose(x[2] - x[1], [1, 0, 2], atol=1e-5)
    # With drag 0.2 it rolls on like a ball in the air: 5 (1 − e^−0.2) m in a second at 1 m/s.
    rest = np.array([0, 0.11, 0], np.float32)
    x = fly(rest, v, np.ones(1, np.float32), physics=PAPER)
    gain = 5 * (1 - math.exp(-0.2))
    np.testing.assert_allclose(x[0], [gain, 0.11, 2 * gain], atol=1e-6)


def test_starts_on_and_in_the_ground() -> None:
    v = np.array([1, -2, 0], np.float32)
    on, below = np.array([0, 0.11, 0], np.float32), np.array([0, -3, 0], np.float32)
    times = np.array([0.0, 0.05, 0.1, 0.4], np.float32)
    x = np.asarray(fly(on, v, times, physics=PAPER))
    np.testing.assert_array_equal(fly(below, v, times, physics=PAPER), x)
    np.testing.assert_allclose(x, reference.fly(on, v, times.astype(float), PAPER), atol=1e-5)
    assert x[1, 1] > 0.15  # it has bounced at once, and rises with 1.4 m/s
    still = fly(on, 0 * v, times, physics=PAPER)
    np.testing.assert_array_equal(still, np.repeat(on[None], 4, axis=0))
    early = fly(on, v, -times, physics=PAPER)
    np.testing.assert_array_equal(early, np.repeat(on[None], 4, axis=0))


def scalar(place, v, t, drag, restitution, law="linear", f=None):
    """A weighted sum of a position, by ``fly`` or by the reference."""
    if f is reference.fly:
        physics = BallPhysics(drag=float(drag), restitution=float(restitution), drag_law=law)
        return float(f(place, v, [t], physics)[0] @ [1.0, 2.0, -0.5])
    physics = BallPhysics(drag=drag, restitution=restitution, drag_law=law)
    weights = jnp.array([1.0, 2.0, -0.5], jnp.float32)
    return jnp.sum(fly(place, v, t[None], physics=physics)[0] * weights)


@pytest.mark.parametrize("law", ["linear", "quadratic"])
def test_gradient_through_bounces(law: str) -> None:
    place, v = np.array([0.3, 1.2, 0.0], np.float32), np.array([3, 2, -1], np.float32)
    gradient = jax.jit(jax.grad(scalar, argnums=(0, 1, 2, 3, 4)), static_argnames="law")
    for t in (0.3, 1.0, 1.5, 1.75):  # 0, 1, 2, 3 bounces
        numbers = [np.float32(x) for x in (t, 0.2, 0.7)]
        got = gradient(place, v, *numbers, law=law)
        flat = np.concatenate([place, v, numbers]).astype(float)
        wanted = []
        for i in range(9):
            step = 1e-6 * np.eye(9)[i]
            ends = [
                scalar(z[:3], z[3:6], z[6], z[7], z[8], law=law, f=reference.fly)
                for z in (flat + step, flat - step)
            ]
            wanted.append((ends[0] - ends[1]) / 2e-6)
        got = np.concatenate([np.atleast_1d(g) for g in got])
        np.testing.assert_allclose(got, wanted, rtol=2e-4, atol=2e-4)


def test_gradients_are_finite_at_degenerate_points() -> None:
    gradient = jax.jit(jax.value_and_grad(scalar, argnums=(0, 1, 2, 3, 4)), static_argnames="law")
    zero = np.zeros(3, np.float32)
    for place in ([0, 0.11, 0], [0, -1, 0], [0, 0.5, 0]):
        for v in (zero, np.array([0, -1, 0], np.float32), np.array([1, 0, 0], np.float32)):
            for drag in (0.0, 0.2):
                numbers = [np.float32(x) for x in (0.0, drag, 0.0)]
                for law in ("linear", "quadratic"):
                    place32 = np.array(place, np.float32)
                    chex.assert_tree_all_finite(gradient(place32, v, *numbers, law=law))
                    numbers[0] = np.float32(1.3)
                    chex.assert_tree_all_finite(gradient(place32, v, *numbers, law=law))


def test_vmap_is_the_loop_and_jit_is_eager() -> None:
    given = launches(5, seed=2)
    places, velocities = (np.stack(a) for a in zip(*given, strict=True))
    times = TIMES[::20]
    got = jax.vmap(lambda p, v: fly(p, v, times, physics=PAPER))(places, velocities)
    for k, (p, v) in enumerate(given):
        np.testing.assert_allclose(got[k], fly(p, v, times, physics=PAPER), atol=2e-6)
    with jax.disable_jit():
        eager = fly(places[0], velocities[0], times[-2:], physics=PAPER)
    np.testing.assert_allclose(got[0, -2:], eager, atol=5e-6)


@hypothesis.given(seed=st.integers(0, 10**6), turn=st.floats(-3.0, 3.0))
def test_turning_the_launch_turns_the_path(seed: int, turn: float) -> None:
    (place, v), times = launches(1, seed)[0], TIMES[::20]
    place[[0, 2]] = 0
    c, s = math.cos(turn), math.sin(turn)
    matrix = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    one = np.asarray(fly(place, v, times, physics=PAPER), np.float64)
    two = fly(place, (matrix @ v).astype(np.float32), times, physics=PAPER)
    np.testing.assert_allclose(two, one @ matrix.T, atol=2e-5)
