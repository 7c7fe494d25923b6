from __future__ import annotations

import re
from dataclasses import replace

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import MAX_SECONDS, Attack, validate_attack
from mgjax.avoidance.attacks.ball import BEYOND_M, ball_attack
from mgjax.avoidance.attacks.crop import crop_attack
from mgjax.core.errors import AttackError
from tests.reference import avoidance as reference

START, AT = (3.0, 1.5, 4.0), (0.2, 1.2, -0.1)


def thrown(
    start=START, at=AT, *, speed: float = 10.0, arrives: float = 1.2, **more: object
) -> Attack:
    places = np.array(start, np.float64), np.array(at, np.float64)
    return ball_attack(*places, speed=speed, arrives=arrives, **more)  # type: ignore[arg-type]


def place(attack: Attack, time: float) -> np.ndarray:
    return attack.at(np.array([time]))[0, 0]


@pytest.mark.parametrize("gravity", [False, True])
@hypothesis.given(
    start=st.tuples(st.floats(-6, 6), st.floats(0.1, 3), st.floats(2, 6)),
    at=st.tuples(st.floats(-0.5, 0.5), st.floats(0.1, 2), st.floats(-0.5, 0.5)),
    speed=st.floats(12, 30),
    arrives=st.floats(0.05, 3),
)
def test_is_where_it_should_be(gravity: bool, start, at, speed: float, arrives: float) -> None:
    attack = thrown(start, at, speed=speed, arrives=arrives, gravity=gravity)
    validate_attack(attack)
    np.testing.assert_allclose(place(attack, arrives), at, atol=1e-4)
    for time in np.linspace(max(attack.start, 0.0), attack.end, 7):
        wanted = reference.ball_place(start, at, speed, arrives, gravity, time)
        np.testing.assert_allclose(place(attack, time), wanted, atol=2e-4)
    # At launch, or at the first moment known, it has the speed that energy leaves it.
    step = attack.times[1] - attack.times[0]
    first = np.linalg.norm(attack.centres[1, 0] - attack.centres[0, 0]) / step
    fallen = 2 * 9.8 * (start[1] - attack.centres[0, 0, 1]) if gravity else 0.0
    np.testing.assert_allclose(first, np.sqrt(speed**2 + fallen), rtol=0.01)
    assert attack.acceleration == (9.8 if gravity else 0.0)


def test_launched_when_it_has_to_be() -> None:
    way = np.linalg.norm(np.subtract(START, AT))
    attack = thrown(arrives=2.0)
    np.testing.assert_allclose(attack.start, 2.0 - way / 10, atol=1e-9)
    np.testing.assert_allclose(place(attack, attack.start), START, atol=1e-9)
    # Held before and after.
    np.testing.assert_allclose(place(attack, 0.0), START, atol=1e-9)
    np.testing.assert_allclose(attack.end, 2.0 + BEYOND_M / 10, atol=1e-9)
    np.testing.assert_allclose(attack.largest_speed, 10.0, rtol=1e-6)


def test_launched_in_the_past() -> None:
    attack = thrown(arrives=0.1)
    assert attack.start == 0.0  # what was before now does not matter
    toward = np.subtract(AT, START) / np.linalg.norm(np.subtract(AT, START))
    np.testing.assert_allclose(place(attack, 0.0), AT - toward, atol=1e-6)
    np.testing.assert_allclose(place(attack, 0.1), AT, atol=1e-6)


def test_slow_balls_stay_small() -> None:
    attack = thrown(speed=1e-6)
    np.testing.assert_allclose(attack.end, 1.2 + 10 * BEYOND_M)
    assert len(attack.times) < 10_000


def test_ends_at_the_floor() -> None:
    down = thrown((0.0, 2.0, 3.0), (0.0, 0.5, 0.0))
    np.testing.assert_allclose(down.centres[-1, 0, 1], 0.0, atol=1e-9)
    assert (down.centres[..., 1] >= -1e-9).all()
    lob = thrown((0.0, 1.0, 5.0), (0.0, 0.3, 0.0), speed=8.0, gravity=True)
    np.testing.assert_allclose(lob.centres[-1, 0, 1], 0.0, atol=1e-9)
    # Never before it is where it was aimed at.
    rolling = thrown((0.0, 0.1, 3.0), (0.0, 0.0, 0.0))
    np.testing.assert_allclose(place(rolling, 1.2), 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("start", "at"),
    [(START, AT), ((0, 0.2, 6), (0, 1.9, 0)), ((0, 2.0, 2), (0.1, 0.3, 0)), ((9, 1, 9), AT)],
)
def test_too_slow_under_gravity(start, at) -> None:
    with pytest.raises(AttackError, match="cannot reach") as caught:
        thrown(start, at, speed=1.0, arrives=3.0, gravity=True)
    least = float(re.search(r"at least ([0-9.]+) m/s", str(caught.value))[1])  # type: ignore[index]
    attack = thrown(start, at, speed=least, arrives=3.0, gravity=True)
    np.testing.assert_allclose(place(attack, 3.0), at, atol=1e-3)
    with pytest.raises(AttackError, match="cannot reach"):
        thrown(start, at, speed=least - 0.005, arrives=3.0, gravity=True)


BAD: list[tuple[dict, str]] = [
    ({"speed": 0.0}, "speed"),
    ({"speed": -3.0}, "speed -3"),
    ({"speed": float("nan")}, "speed nan"),
    ({"speed": float("inf")}, "speed inf"),
    ({"speed": 1001.0}, "speed"),
    ({"arrives": 0.0}, "arrival 0"),
    ({"arrives": -1.0}, "arrival -1"),
    ({"arrives": float("nan")}, "arrival"),
    ({"radius": 0.0}, "radius 0"),
    ({"radius": -0.1}, "radius"),
    ({"radius": float("inf")}, "radius"),
    ({"start": (float("nan"), 1, 1)}, "start"),
    ({"at": (0, float("inf"), 0)}, "target"),
    ({"at": (0, 2000.0, 0)}, "target"),
    ({"start": (0, -0.5, 3)}, "under the floor"),
    ({"at": (0, -0.5, 0)}, "under the floor"),
    ({"start": AT}, "place it starts from"),
    ({"arrives": MAX_SECONDS}, "under way until"),
]


@pytest.mark.parametrize(("change", "text"), BAD, ids=lambda x: str(x))
def test_bad_numbers(change: dict, text: str) -> None:
    with pytest.raises(AttackError, match=text) as caught:
        thrown(**change)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith("got ")
    assert "expected" in message


def unchecked(**fields: object) -> Attack:
    """An attack as it is made where nobody checks shapes."""
    attack = object.__new__(Attack)
    for name, value in ({"acceleration": 0.0} | fields).items():
        object.__setattr__(attack, name, value)
    return attack


def test_bad_attacks() -> None:
    times, centres, radii = np.array([0.0, 1.0]), np.zeros((2, 1, 3)), np.array([0.1])
    good = {"times": times, "centres": centres, "radii": radii}
    validate_attack(Attack(**good))
    for change in (
        {"times": np.array([1.0, 1.0])},
        {"times": np.array([1.0, 0.5])},
        {"times": np.array([0.0, np.nan])},
        {"times": np.array([0.0, 1e9])},
        {"centres": np.full((2, 1, 3), np.inf)},
        {"centres": np.zeros((3, 1, 3))},
        {"centres": np.zeros((2, 0, 3)), "radii": np.zeros(0)},
        {"times": np.zeros(0), "centres": np.zeros((0, 1, 3))},
        {"radii": np.array([0.0])},
        {"radii": np.array([np.nan])},
        {"acceleration": -1.0},
        {"acceleration": float("nan")},
    ):
        with pytest.raises(AttackError, match="expected"):
            validate_attack(unchecked(**(good | change)))


def test_several_spheres_and_one_knot() -> None:
    times = np.array([0.0, 1.0, 3.0])
    centres = np.random.default_rng(0).normal(size=(3, 2, 3))
    attack = Attack(times=times, centres=centres, radii=np.array([0.1, 0.2]))
    got = attack.at(np.array([-1.0, 0.5, 2.0, 9.0]))
    wanted = [centres[0], centres[:2].mean(0), centres[1:].mean(0), centres[2]]
    np.testing.assert_allclose(got, wanted)
    speeds = np.linalg.norm(np.diff(centres, axis=0), axis=-1) / np.array([[1.0], [2.0]])
    np.testing.assert_allclose(attack.largest_speed, speeds.max())
    one = Attack(times=times[:1], centres=centres[:1], radii=attack.radii)
    validate_attack(one)
    assert one.largest_speed == 0.0


@pytest.mark.parametrize("gravity", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_crop(seed: int, gravity: bool) -> None:
    rng = np.random.default_rng(seed)
    start = rng.uniform((-4, 0.5, 3), (4, 2.5, 5))
    at = rng.uniform((-0.7, 0.3, -0.7), (0.7, 2.6, 0.7))
    attack = thrown(start, at, speed=12.0, arrives=1.0, gravity=gravity)
    crop = crop_attack(attack, radius=1.0, height=2.3)
    times = np.linspace(max(attack.start, 0), attack.end, 40_001)
    x, y, z = attack.at(times)[:, 0].T
    inside = times[(np.hypot(x, z) <= 1.0) & (y >= 0) & (y <= 2.3)]
    if not len(inside):
        assert crop is None
        return
    assert crop is not None
    np.testing.assert_allclose((crop.start, crop.end), (inside[0], inside[-1]), atol=2e-3)
    assert crop.middle == 0.5 * (crop.start + crop.end)


def test_crop_by_hand() -> None:
    # Straight through the vertical at 10 m/s: inside from 0.1 s before to 0.1 s after.
    attack = thrown((0, 1.0, 5.0), (0, 1.0, 0.0))
    crop = crop_attack(attack, radius=1.0, height=2.3)
    assert crop is not None
    np.testing.assert_allclose((crop.start, crop.end), (1.1, 1.3), atol=2e-3)
    np.testing.assert_allclose(crop.middle, 1.2, atol=1e-3)
    later = crop_attack(attack, radius=1.0, height=2.3, start=1.25)
    assert later is not None
    np.testing.assert_allclose((later.start, later.end), (1.25, 1.3), atol=2e-3)
    assert crop_attack(attack, radius=1.0, height=2.3, start=5.0) is None
    assert crop_attack(attack, radius=1.0, height=0.9) is None
    wide = thrown((3, 1.0, 5.0), (3, 1.0, 0.0))
    assert crop_attack(wide, radius=1.0, height=2.3) is None


def crop_of_every_moment(attack: Attack, radius: float, height: float, start: float):
    """First and last moment inside, of evenly spaced ones that are all looked at."""
    begin = max(attack.start, start)
    if attack.end < begin:
        return None
    times = np.linspace(begin, attack.end, int(np.ceil((attack.end - begin) * 1000)) + 2)
    x, y, z = np.moveaxis(attack.at(times), -1, 0)
    near = (np.hypot(x, z) <= radius) & (y >= 0) & (y <= height) & attack.active(times)
    inside = times[near.any(axis=1)]
    return (inside[0], inside[-1]) if len(inside) else None


def wandering(rng: np.random.Generator, knots: int) -> Attack:
    """Spheres on random lines around the character, perhaps coming and going."""
    count = int(rng.integers(1, 4))
    times = np.sort(rng.uniform(-0.3, 1.5, knots))
    centres = np.cumsum(rng.normal(size=(knots, count, 3)) * rng.uniform(0, 0.6), axis=0)
    attack = Attack(times=times, centres=centres + np.array([0, 1, 0]), radii=np.full(count, 0.1))
    if rng.random() < 0.5:
        return attack
    starts, stops = np.sort(rng.integers(0, knots, (2, count)), axis=0)
    return replace(attack, starts=times[starts], stops=times[stops])


@pytest.mark.parametrize("knots", [1, 2, 3, 7, 60])
def test_crop_is_that_of_every_moment(knots: int) -> None:
    # To the last bit, however few of the moments are looked at.
    rng = np.random.default_rng(knots)
    found = 0
    for _ in range(150):
        attack = wandering(rng, knots)
        radius, height = float(rng.choice([0.3, 1.0, 2.0])), float(rng.choice([0.5, 2.3, 50.0]))
        start = float(rng.choice([0.0, rng.uniform(0, 1.5)]))
        crop = crop_attack(attack, radius=radius, height=height, start=start)
        want = crop_of_every_moment(attack, radius, height, start)
        assert (None if crop is None else (crop.start, crop.end)) == want
        found += want is not None
    assert found > 20


def test_crop_at_its_limits() -> None:
    # Along the vertical, along the side of the cylinder, and along the floor.
    for start, at in (((0, 3, 0), (0, 1, 0)), ((1, 1, 5), (1, 1, 0)), ((0, 0, 5), (0, 0, 0))):
        for attack in (thrown(start, at), thrown(start, at, speed=0.8)):
            crop = crop_attack(attack, radius=1.0, height=2.3)
            want = crop_of_every_moment(attack, 1.0, 2.3, 0.0)
            assert (None if crop is None else (crop.start, crop.end)) == want
            # Beside the vertical it is at the limit for no longer than a moment.
            assert (want is not None) or start[0] == 1
