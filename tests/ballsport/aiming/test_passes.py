from __future__ import annotations

import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.ballsport import Aim, BallPhysics, Net, aim, aim_batch, choose_frame, fly
from mgjax.ballsport.aiming.problem import Launch, arrive, make_problem
from mgjax.ballsport.aiming.solve import IN_GROUND, NOT_FINITE, OK, STATUS_TEXT, TOO_FAR, UNDER_NET
from mgjax.ballsport.aiming.updates import differential_updates
from mgjax.core.errors import ConfigError
from tests.reference import ball as reference

PAPER = BallPhysics()
START = np.array([0.0, 0.15, 0.0], np.float32)
GUESS = np.array([0.0, 4.0, 9.0], np.float32)


def passes(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Starts at foot height, targets near (0.2 m) to far (20 m), on the ground to high (2.5 m),
    guesses like the velocity of a foot that is roughly turned towards them."""
    rng = np.random.default_rng(seed)
    way = np.exp(rng.uniform(math.log(0.2), math.log(20.0), count))
    way[:4], angle = (0.2, 0.2, 20.0, 20.0), rng.uniform(0, 2 * np.pi, count)
    starts = rng.uniform(-10, 10, (count, 3))
    starts[:, 1] = rng.choice([0.11, 0.15, 0.3, 1.0], count)
    targets = starts + np.stack([way * np.sin(angle), 0 * way, way * np.cos(angle)], axis=1)
    targets[:, 1] = rng.choice([0.11, 0.2, 0.5, 1.7, 2.5], count)
    targets[:4, 1] = (0.11, 2.5, 0.11, 2.5)
    angle, speed = angle + rng.normal(0, 0.5, count), rng.uniform(2, 14, count)
    up = rng.uniform(-2, 6, count)
    guesses = np.stack([speed * np.sin(angle), up, speed * np.cos(angle)], axis=1)
    return tuple(a.astype(np.float32) for a in (starts, targets, guesses))


def assert_met(found: Aim, start, target, bounces: int, physics: BallPhysics = PAPER) -> None:
    """The integrator finds the ball within 0.1 mm, after just these bounces."""
    velocity, time = np.asarray(found.velocity, np.float64), float(found.time)
    place, count = reference.arrival(start, velocity, time, physics)
    assert count == bounces
    assert np.linalg.norm(place - target) <= 1e-4
    np.testing.assert_allclose(found.arrival, place, atol=3e-5)
    assert abs(float(found.miss) - np.linalg.norm(place - target)) <= 3e-5


def item(found: Aim, k: int) -> Aim:
    return jax.tree.map(lambda a: a[k], found)


@pytest.mark.parametrize("bounces", [0, 1, 2])
def test_every_feasible_target_is_met(bounces: int) -> None:
    starts, targets, guesses = passes(250)
    found = aim_batch(starts, targets, bounces=bounces, guesses=guesses, physics=PAPER)
    assert (found.status == OK).all()
    assert (np.linalg.norm(found.velocity, axis=1) <= 30.0).all()
    for k in range(len(starts)):
        assert_met(item(found, k), starts[k], targets[k], bounces)


@pytest.mark.parametrize("bounces", [0, 1])
def test_quadratic_drag(bounces: int) -> None:
    physics = BallPhysics(drag=0.013, drag_law="quadratic")
    starts, targets, guesses = passes(12, seed=1)
    found = aim_batch(starts, targets, bounces=bounces, guesses=guesses, physics=physics)
    assert (found.status == OK).all()
    for k in range(len(starts)):
        assert_met(item(found, k), starts[k], targets[k], bounces, physics)


def test_case_by_hand() -> None:
    # Without drag, 9.8 m away at the same height, in the time of 2 · 4.9/9.8 = 1 s: launched with
    # (9.8, 4.9) m/s. With one bounce, from the ground: up with 7 m/s, 10/7 s in the air, then with
    # 4.9 m/s and 1 s more.
    vacuum = BallPhysics(drag=0.0)
    start, target = np.array([0, 0.5, 0], np.float32), np.array([9.8, 0.5, 0], np.float32)
    found = aim(start, target, bounces=0, guess=np.float32([9.8, 4.9, 0]), physics=vacuum)
    np.testing.assert_allclose(found.velocity, [9.8, 4.9, 0], atol=5e-2)
    assert_met(found, start, target, 0, vacuum)
    start, target = np.array([0, 0.11, 0], np.float32), np.array([17.0, 0.11, 0], np.float32)
    guess = np.float32([7.0, 7.0, 0])
    found = aim(start, target, bounces=1, guess=guess, physics=vacuum)
    np.testing.assert_allclose(found.time, 1.7 * 10 / 7, atol=1e-2)
    np.testing.assert_allclose(found.velocity, guess, atol=5e-2)


def test_nothing_is_changed_where_the_guess_already_meets() -> None:
    for bounces, time in ((0, 0.6), (1, 1.1), (2, 1.5)):
        guess = np.array([3.0, 3.5, 2.0], np.float32)
        target = np.asarray(fly(START, guess, np.float32([time]), physics=PAPER)[0])
        assert reference.arrival(START, guess.astype(float), time, PAPER)[1] == bounces
        found = aim(START, target, bounces=bounces, guess=guess, physics=PAPER)
        assert np.linalg.norm(found.velocity - guess) < 0.15
        assert_met(found, START, target, bounces)


def test_batch_is_the_loop() -> None:
    starts, targets, guesses = passes(20, seed=2)
    targets[3] += 500.0
    found = aim_batch(starts, targets, bounces=1, guesses=guesses, physics=PAPER)
    assert found.status.tolist() == [TOO_FAR if k == 3 else OK for k in range(20)]
    for k in range(6):
        one = aim(starts[k], targets[k], bounces=1, guess=guesses[k], physics=PAPER)
        for name in ("velocity", "time", "arrival", "miss"):
            a, b = getattr(one, name), getattr(found, name)[k]
            np.testing.assert_allclose(a, b, atol=2e-3, err_msg=name)
    mapped = jax.vmap(lambda s, t, g: aim(s, t, bounces=1, guess=g, physics=PAPER))
    other = mapped(starts[:6], targets[:6], guesses[:6])
    np.testing.assert_array_equal(other.status, found.status[:6])
    np.testing.assert_allclose(other.velocity, found.velocity[:6], atol=2e-3)
    none = aim_batch(starts[:0], targets[:0], bounces=1, guesses=guesses[:0], physics=PAPER)
    assert none.velocity.shape == (0, 3)


def test_padding_changes_nothing() -> None:
    starts, targets, guesses = passes(17, seed=3)  # padded to 32, and 16 are not padded
    many = aim_batch(starts, targets, bounces=1, guesses=guesses, physics=PAPER)
    few = aim_batch(starts[:16], targets[:16], bounces=1, guesses=guesses[:16], physics=PAPER)
    np.testing.assert_allclose(many.velocity[:16], few.velocity, atol=1e-4)


def test_too_far_comes_as_near_as_it_can() -> None:
    # Without drag and from the ground a kick of 7 m/s reaches 5 m at best (45°), seen from a target
    # on the ground; and 2.5 m up.
    vacuum, start = BallPhysics(drag=0.0), np.array([0, 0.11, 0], np.float32)
    shared = {"bounces": 0, "guess": GUESS, "physics": vacuum, "max_speed": 7.0}
    found = aim(start, np.float32([6.0, 0.11, 0]), **shared)
    assert int(found.status) == TOO_FAR
    np.testing.assert_allclose(found.arrival, [5.0, 0.11, 0], atol=5e-3)
    np.testing.assert_allclose(found.miss, 1.0, atol=5e-3)
    found = aim(start, np.float32([0, 4.11, 0]), **shared)
    assert int(found.status) == TOO_FAR
    np.testing.assert_allclose(found.arrival, [0, 2.61, 0], atol=5e-3)
    assert np.linalg.norm(found.velocity) <= 7.0
    # What is just within reach is met.
    found = aim(start, np.float32([4.99, 0.11, 0]), **shared)
    assert int(found.status) == OK


@pytest.mark.parametrize("bounces", [0, 1, 2])
def test_no_launch_comes_nearer(bounces: int) -> None:
    target = np.array([3.0, 2.0, 9.0], np.float32)
    found = aim(START, target, bounces=bounces, guess=GUESS, physics=PAPER, max_speed=6.0)
    assert int(found.status) == TOO_FAR
    place, count = reference.arrival(
        START, np.asarray(found.velocity, float), float(found.time) - 1e-5, PAPER
    )
    assert count == bounces
    np.testing.assert_allclose(np.linalg.norm(place - target), found.miss, atol=1e-3)
    rng = np.random.default_rng(0)
    ahead = target - START
    ahead[1] = 0
    for _ in range(300):
        angle = rng.uniform(-1.5, 1.5)
        velocity = math.cos(angle) * ahead / np.linalg.norm(ahead) + [0, math.sin(angle), 0]
        arcs = reference.arcs(START, 6.0 * velocity, PAPER, end=10.0)
        if bounces and arcs[1][0] < 0.01:
            continue
        times = np.linspace(arcs[bounces][0], arcs[bounces + 1][0], 60)[1:-1]
        path = np.array([reference.on_arc(arcs[bounces], t, PAPER) for t in times])
        assert np.linalg.norm(path - target, axis=1).min() >= float(found.miss) - 2e-3


def height_at(start, found: Aim, z: float) -> float:
    """Height of the ball's lowest point where it passes ``z``, by the integrator."""
    times = np.linspace(0.0, float(found.time), 4001)
    path = reference.fly(start, np.asarray(found.velocity, float), times, PAPER)
    return float(np.interp(z, path[:, 2], path[:, 1])) - 0.11


def test_net() -> None:
    target, net = np.array([1.0, 0.5, 8.0], np.float32), Net(z=4.0, height=2.0)
    flat = np.array([0.0, 2.0, 14.0], np.float32)
    for bounces in (0, 1):
        free = aim(START, target, bounces=bounces, guess=flat, physics=PAPER)
        assert height_at(START, free, 4.0) < 1.9
        found = aim(START, target, bounces=bounces, guess=flat, physics=PAPER, net=net)
        assert int(found.status) == OK
        assert_met(found, START, target, bounces)
        assert height_at(START, found, 4.0) >= 2.0
    # 8 m/s do not lift it over 4 m: it stays before the net. A net behind the target is no net.
    high = dataclasses.replace(net, height=4.0)
    shared = {"bounces": 1, "guess": flat, "physics": PAPER, "max_speed": 9.0}
    found = aim(START, target, net=high, **shared)
    assert int(found.status) == UNDER_NET
    assert float(found.arrival[2]) <= 4.001
    assert 4.0 < float(found.miss) < 4.3
    found = aim(START, target, net=Net(z=8.5, height=4.0), **shared)
    assert int(found.status) == OK
    # Turned by a quarter it stands along Z, beside the path.
    found = aim(START, target, net=Net(x=4.0, heading=math.pi / 2, height=4.0), **shared)
    assert int(found.status) == OK


def test_wanted_flight_time() -> None:
    target = np.array([1.0, 0.8, 8.0], np.float32)
    shared = {"bounces": 1, "guess": GUESS, "physics": PAPER, "time_weight": 1000.0}
    for wanted in (1.2, 1.6, 2.0):
        found = aim(START, target, flight_time=wanted, **shared)
        assert_met(found, START, target, 1)
        assert abs(float(found.time) - wanted) < 0.02
    batch = aim_batch(
        np.stack([START] * 2),
        np.stack([target] * 2),
        guesses=np.stack([GUESS] * 2),
        flight_times=np.float32([1.2, np.nan]),
        bounces=1,
        time_weight=1000.0,
    )
    assert abs(batch.time[0] - 1.2) < 0.02
    free = aim(START, target, bounces=1, guess=GUESS, physics=PAPER)
    np.testing.assert_allclose(batch.velocity[1], free.velocity, atol=2e-3)


def test_degenerate_requests() -> None:
    shared = {"guess": GUESS, "physics": PAPER}
    for bounces in (0, 1, 2):
        for start in (START, np.array([0, 0.11, 0], np.float32)):  # target = start, no guess
            zero = np.zeros(3, np.float32)
            found = aim(start, start, bounces=bounces, guess=zero, physics=PAPER)
            assert int(found.status) == OK
            assert_met(found, start, start, bounces)
    sunk = np.array([0, -0.5, 8], np.float32)
    found = aim(START, sunk, bounces=1, **shared)
    assert int(found.status) == IN_GROUND
    np.testing.assert_allclose(found.arrival, [0, 0.11, 8], atol=1e-4)
    np.testing.assert_allclose(found.miss, 0.61, atol=1e-4)
    below = np.array([0, -1, 0], np.float32)
    found = aim(below, np.float32([0, 1, 8]), bounces=1, **shared)
    assert_met(found, below, [0, 1, 8], 1)
    found = aim(START, np.float32([0, np.nan, 8]), bounces=1, **shared)
    assert int(found.status) == NOT_FINITE
    assert np.isnan(found.velocity).all()
    found = aim(START, np.float32([0, 1, 8]), bounces=1, max_speed=0.0, **shared)
    assert int(found.status) == TOO_FAR
    assert np.isfinite(found.velocity).all()
    assert len(STATUS_TEXT) == NOT_FINITE + 1


@pytest.mark.parametrize("bounces", [-1, 5, 1.0, True])
def test_bounces_out_of_range(bounces) -> None:
    with pytest.raises((ConfigError, TypeError)):
        aim(START, START, bounces=bounces, guess=GUESS, physics=PAPER)


def test_updates_close_a_miss_and_stay_near() -> None:
    # From the bone's own velocity, 0.2 m off after one bounce: the steps converge quadratically.
    guess = np.array([3.0, 3.5, 2.0], np.float32)
    end = np.asarray(fly(START, guess, np.float32([1.1]), physics=PAPER)[0])
    target = end + np.array([0.15, 0.1, -0.1], np.float32)
    problem = make_problem(START, target, guess, np.nan, 5.0, 30.0, None, PAPER)
    launch = Launch(jnp.asarray(guess), jnp.float32(1.1))
    update = jax.jit(lambda most: differential_updates(problem, launch, 1, most))
    misses = [float(np.linalg.norm(update(most).miss)) for most in range(5)]
    assert misses == sorted(misses, reverse=True)
    assert misses[0] > 0.19
    assert misses[3] < 1e-4
    done = update(16)
    assert bool(done.kept)
    # To first order it is the smallest change: none that keeps the ball on the target is shorter.
    jacobian = jax.jit(jax.jacfwd(lambda x: arrive(problem, Launch(x[:3], x[3]), 1)[0]))
    x = jnp.concatenate([done.launch.velocity, done.launch.time[None]])
    free = np.linalg.svd(np.asarray(jacobian(x)))[2][3]
    step = np.asarray(x) - [*guess, 1.1]
    along = abs((free * [1, 1, 1, 25]) @ step)
    size = math.sqrt(step @ (step * [1, 1, 1, 25]))
    assert along < 0.1 * size * math.sqrt(free @ (free * [1, 1, 1, 25]))


def swing(frames: int = 20) -> tuple[np.ndarray, np.ndarray]:
    """A foot that swings forward and up."""
    u = np.linspace(-1.0, 1.0, frames)
    place = np.stack([0 * u, 0.15 + 0.35 * (u + 1) ** 2 / 4, 0.4 * u], axis=1)
    speed = np.stack([0 * u, 3 * (u + 1), 9 - 3 * u * u], axis=1)
    return place.astype(np.float32), speed.astype(np.float32)


@pytest.mark.parametrize("bounces", [0, 1])
def test_the_chosen_frame_ends_nearest(bounces: int) -> None:
    places, speeds = swing()
    target = np.array([0.0, 0.4, 8.0], np.float32)
    mask = np.arange(20) % 3 != 0
    found = choose_frame(
        places, speeds, target, bounces=bounces, mask=mask, physics=PAPER, scales=(1.0, 1.0)
    )
    nearest = np.full(20, np.inf)
    for k in np.flatnonzero(mask):
        arcs = reference.arcs(places[k], speeds[k], PAPER, end=10.0)
        times = np.linspace(arcs[bounces][0], arcs[bounces + 1][0], 400)
        path = np.array([reference.on_arc(arcs[bounces], t, PAPER) for t in times])
        nearest[k] = np.linalg.norm(path - target, axis=1).min()
    np.testing.assert_allclose(found.distances, nearest, atol=0.03)
    frame = int(found.frame)
    assert nearest[frame] <= nearest.min() + 0.03
    np.testing.assert_allclose(found.velocities[frame], speeds[frame], rtol=1e-6)
    assert_met(found.aim, places[frame], target, bounces)


def test_choice_fits_a_wanted_time_and_ignores_padding() -> None:
    places, speeds = swing()
    target = np.array([0.0, 0.4, 8.0], np.float32)
    shared = {"bounces": 1, "physics": PAPER}
    free = choose_frame(places, speeds, target, **shared)
    # Frames outside the mask, here better ones, change nothing.
    more = np.concatenate([places, places]), np.concatenate([speeds, 1.1 * speeds])
    masked = choose_frame(*more, target, mask=np.arange(40) < 20, **shared)
    assert int(masked.frame) == int(free.frame)
    assert np.isinf(masked.distances[20:]).all()
    gaps = []
    for wanted in (1.1, 1.5):
        found = choose_frame(places, speeds, target, flight_time=wanted, time_weight=20.0, **shared)
        assert int(found.aim.status) == OK
        gaps.append(abs(float(found.aim.time) - wanted))
    assert max(gaps) < 0.1
    with pytest.raises(ConfigError, match="no frame"):
        choose_frame(places, speeds, target, mask=np.zeros(20, bool), **shared)
    with pytest.raises(ConfigError, match="scales"):
        choose_frame(places, speeds, target, scales=(1.4, 0.8), **shared)


@pytest.mark.parametrize("guess", [[0.0, 50.0, 0.0], [1.9, 29.9, 0.9], [0.0, -50.0, 0.0]])
def test_a_guess_at_the_largest_speed_and_beyond(guess: list[float]) -> None:
    aimed = aim([0.0, 0.4, 0.0], [6.0, 0.9, 3.0], bounces=0, guess=guess)
    assert aimed.status == OK
    assert np.linalg.norm(aimed.velocity) <= 30.0 * (1 + 1e-6)
