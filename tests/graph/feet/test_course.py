"""Where feet and root should be."""

from __future__ import annotations

from dataclasses import fields

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.graph.feet.course import (
    MOST_LEAD_M,
    MOST_M,
    FeetState,
    at_rest,
    course,
    turned,
)
from tests.reference import feet as reference

RATE = 120.0
COUNT = 64


def shuffled(seed: int) -> tuple[np.ndarray, ...]:
    """Points of feet that wander, sink and stand now and then, hips above, reach and stands."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(COUNT, 2, 2, 3)) * np.array([0.006, 0.001, 0.006])
    points = np.cumsum(steps, axis=0) + np.array([0.0, 0.01, 0.0])
    points[:, 1] += np.array([0.3, 0.0, 0.0])
    hips = points[:, :, 1] + np.array([0.0, 0.88, 0.0]) + 0.02 * rng.normal(size=(COUNT, 2, 3))
    reach = np.full((COUNT, 2), 0.88)
    stands = np.repeat(rng.random((COUNT // 8, 2, 2)) < 0.6, 8, axis=0)
    return points, hips, reach, stands


@jax.jit
def follow(points, hips, reach, stands, begin, scale):
    return course(points, hips, reach, stands, begin, rate=jnp.float32(RATE), scale=scale)


def single(arrays: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    return (*(x.astype(np.float32) for x in arrays[:3]), arrays[3])


@pytest.mark.parametrize(("seed", "scale"), [(0, 1.0), (1, 1.0), (2, 0.5)])
def test_the_kernel_is_the_definition(seed: int, scale: float) -> None:
    arrays = shuffled(seed)
    got = follow(*single(arrays), at_rest(), np.float32(scale))
    want = reference.followed(*arrays, rate=RATE, scale=scale)
    for name in (field.name for field in fields(FeetState)):
        wanted = np.array([state[name] for state in want])
        tolerance = 5e-3 if name in ("drift", "leading") else 5e-5
        np.testing.assert_allclose(getattr(got, name), wanted, atol=tolerance, err_msg=name)
    # Every branch was taken.
    assert np.asarray(got.lift).max() > 0
    assert np.asarray(got.drop).max() > 0
    far = np.linalg.norm(np.asarray(got.offset[1:] - got.lead[:-1, None, None]), axis=-1)
    assert far.max() > 0.7 * scale * MOST_M


def test_limits() -> None:
    """However a foot is dragged away, neither it nor the root is led farther than said."""
    points, hips, reach, stands = shuffled(3)
    points[:, :, :, 0] += np.linspace(0, 2.0, COUNT)[:, None, None]
    stands[:] = True
    got = follow(*single((points, hips, reach, stands)), at_rest(), np.float32(1))
    off = np.linalg.norm(np.asarray(got.offset[1:] - got.lead[:-1, None, None]), axis=-1)
    assert off.max() <= MOST_M + 1e-6
    assert np.linalg.norm(np.asarray(got.lead), axis=-1).max() <= 1.1 * MOST_LEAD_M


def test_a_walk_that_goes_on_is_one_walk() -> None:
    """The state handed in continues what was played, and what follows changes nothing before."""
    arrays = single(shuffled(4))
    whole = follow(*arrays, at_rest(), np.float32(1))
    cut = 24
    half = jax.tree.map(lambda x: np.asarray(x)[cut], whole)
    # The same shapes: the second half, and then anything.
    second = [np.concatenate([x[cut:], x[:cut]]) for x in arrays]
    later = follow(*second, half, np.float32(1))
    early = [np.concatenate([x[: cut + 1], x[: COUNT - cut - 1]]) for x in arrays]
    before = follow(*early, at_rest(), np.float32(1))
    for name in ("lead", "lift", "drop", "anchor"):
        a = np.asarray(getattr(whole, name))
        np.testing.assert_array_equal(np.asarray(getattr(before, name))[: cut + 1], a[: cut + 1])
    # What a point does before the cut is known to the whole alone, and felt for a moment.
    np.testing.assert_allclose(later.lift[: COUNT - cut], whole.lift[cut:], atol=1e-6)
    np.testing.assert_allclose(later.lead[: COUNT - cut], whole.lead[cut:], atol=1e-2)


def test_a_foot_that_slides_stands_still() -> None:
    """By hand: 5 cm in a third of a second, the other foot still; nothing moves at the start."""
    time = np.arange(COUNT) / RATE
    slide = 0.05 * np.clip(time / 0.33, 0, 1)
    points = np.zeros((COUNT, 2, 2, 3))
    points[..., 1] = 0.02
    points[:, 0, 0], points[:, 0, 1] = (0.1, 0.02, 0.12), (0.1, 0.08, 0.0)
    points[:, 1, 0], points[:, 1, 1] = (-0.1, 0.02, 0.12), (-0.1, 0.08, 0.0)
    points[:, 0, :, 2] += slide[:, None]
    hips = points[:, :, 1] + np.array([0.0, 0.8, 0.0])
    reach = np.full((COUNT, 2), 0.87)
    stands = np.ones((COUNT, 2, 2), bool)
    state = follow(*single((points, hips, reach, stands)), at_rest(), np.float32(1))
    placed = points[..., ::2] + np.asarray(state.offset)
    # The foot moves at 15 cm/s when it begins: it comes to rest within 2 mm.
    assert np.linalg.norm(placed - placed[0], axis=-1).max() < 0.0025
    moved = np.linalg.norm(np.diff(placed[8:], axis=0), axis=-1).max() * RATE
    assert moved < 1e-3
    np.testing.assert_array_equal(np.asarray(state.offset[0]), 0)
    # The root is on its way to half of what the one foot is held back: the mean of both.
    assert -0.025 < np.asarray(state.lead)[-1, 1] < -0.018
    assert np.abs(np.asarray(state.lead)[:, 0]).max() < 1e-6


def test_lifted_feet_come_back() -> None:
    begin = FeetState(**{f.name: getattr(at_rest(), f.name) + 0.0 for f in fields(FeetState)})
    begin.offset[:] = 0.05
    begin.lift[:] = 0.01
    points = np.full((COUNT, 2, 2, 3), 0.2, np.float32)
    hips, reach = points[:, :, 1] + np.float32(0.5), np.full((COUNT, 2), 2, np.float32)
    state = follow(points, hips, reach, np.zeros((COUNT, 2, 2), bool), begin, np.float32(1))
    far = np.linalg.norm(np.asarray(state.offset), axis=-1)
    assert (np.diff(far, axis=0) < 0).all()
    # The root, with no foot to stand on, comes back with them.
    assert far[-1].max() < 0.3 * far[0].max()
    assert np.asarray(state.lift)[-1].max() < 2e-4


def test_gradients_are_finite_and_vmap_is_a_loop() -> None:
    arrays = [single(shuffled(seed)) for seed in (5, 6)]

    def lead(points, hips, reach, stands):
        return follow(points, hips, reach, stands, at_rest(), np.float32(1)).lead

    together = jax.vmap(lead)(*(np.stack(x) for x in zip(*arrays, strict=True)))
    for got, own in zip(together, arrays, strict=True):
        np.testing.assert_allclose(got, lead(*own), atol=1e-6)
    still = np.zeros((COUNT, 2, 2, 3), np.float32)  # all points in one place, at rest
    rest = (np.zeros((COUNT, 2, 3), np.float32), np.ones((COUNT, 2), np.float32))
    slope = jax.grad(lambda p: jnp.sum(lead(p, *rest, arrays[0][3]) ** 2))(still)
    assert np.isfinite(slope).all()
    with jax.disable_jit():
        few = [x[:4] for x in arrays[0]]
        eager = course(*few, at_rest(), rate=np.float32(RATE), scale=np.float32(1))
    np.testing.assert_allclose(eager.lead, lead(*arrays[0])[:4], atol=1e-6)


def test_a_turned_world() -> None:
    """The course in a world that is turned is the turned course."""
    points, hips, reach, stands = shuffled(7)
    angle = 0.7
    c, s = np.cos(angle), np.sin(angle)

    def turn(places: np.ndarray) -> np.ndarray:
        x, y, z = np.moveaxis(places, -1, 0)
        return np.stack([x * c + z * s, y, z * c - x * s], axis=-1)

    here = follow(*single((points, hips, reach, stands)), at_rest(), np.float32(1))
    there = follow(*single((turn(points), turn(hips), reach, stands)), at_rest(), np.float32(1))
    wanted = turned(jax.tree.map(np.asarray, here), angle)
    np.testing.assert_allclose(there.offset, wanted.offset, atol=2e-5)
    np.testing.assert_allclose(there.lead, wanted.lead, atol=2e-5)
    np.testing.assert_allclose(there.drop, wanted.drop, atol=2e-5)
