from __future__ import annotations

import dataclasses
import math

import chex
import hypothesis
import hypothesis.strategies as st
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy import kernel as energy_kernel
from mgjax.avoidance.energy.energies import (
    energies,
    energies_batch,
)
from mgjax.avoidance.energy.score import movement_energy, time_scale_energy, total_energy
from mgjax.avoidance.rates import FAR
from mgjax.core.errors import ConfigError
from tests.reference import energy as reference

FIELDS = ("avoidance", "body", "penetration", "d", "d0")
CONFIGS = [
    EnergyConfig(form=form, d0=d0, E_avoidance=scale)
    for form, scale in (("paper", 40.0), ("overlap", 1.0))
    for d0 in ("clamped", "paper")
]
DT = 0.05


def problem(seed: int, T: int = 9, I: int = 2, S: int = 4, *, spread: float = 0.4) -> tuple:  # noqa: E741
    """A random path: a body that drifts about the origin, attack spheres that fly past it."""
    rng = np.random.default_rng(seed)
    flight = np.linspace(-1.0, 1.0, T)[:, None, None] * rng.normal(size=(1, I, 3))
    attack = flight + rng.normal(scale=spread, size=(1, I, 3))
    place = rng.normal(scale=spread, size=(1, S, 3))
    body = place + np.cumsum(rng.normal(scale=0.1, size=(T, S, 3)), axis=0)
    first, last = np.sort(rng.choice(np.arange(1, T), 2, replace=False))
    avoidance = (np.arange(T) >= first) & (np.arange(T) <= last)
    start = body[first] + rng.normal(scale=0.02, size=(S, 3))
    active = rng.random(T) < 0.8
    radii = rng.uniform(0.05, 0.2, I), rng.uniform(0.05, 0.2, S)
    floats = (attack, radii[0], body, radii[1], start)
    return (*(a.astype(np.float32) for a in floats), avoidance, active)


def batched(problems: list[tuple]) -> tuple:
    """The candidates' arrays for the batched kernel; all share the first one's attack."""
    attack, attack_radii, _, body_radii, *_ = problems[0]
    avoidance, active = (np.stack([p[k] for p in problems], axis=-1) for k in (5, 6))
    body = np.moveaxis(np.stack([p[2] for p in problems], axis=1), -1, 0)
    start = np.moveaxis(np.stack([p[4] for p in problems]), -1, 0)
    return np.moveaxis(attack, 2, 0), attack_radii, body, body_radii, start, avoidance, active


def candidates(count: int, **sizes: int) -> list[tuple]:
    """Problems that share attack and radii."""
    shared = problem(0, **sizes)
    found = [problem(seed, **sizes) for seed in range(count)]
    return [(*shared[:2], p[2], shared[3], *p[4:]) for p in found]


def assert_same(got: object, wanted: object, *, atol: float = 2e-5) -> None:
    for name in FIELDS:
        a, b = np.asarray(getattr(got, name)), np.asarray(getattr(wanted, name))
        b = np.where(np.isinf(b), FAR, b)
        np.testing.assert_allclose(a, b, rtol=2e-5, atol=atol, err_msg=name)


@pytest.mark.parametrize("config", CONFIGS, ids=lambda c: f"{c.form}-{c.d0}")
def test_agrees_with_plain_loops(config: EnergyConfig) -> None:
    kinds = set()
    for seed in range(40):
        arguments = problem(seed)
        wanted = reference.energies(*arguments, dt=DT, config=config)
        assert_same(energies(*arguments, dt=DT, config=config), wanted, atol=5e-5)
        kinds.add((wanted.penetration > 0, 0 < wanted.body < 1, wanted.d < 0, wanted.d0 < wanted.d))
    assert {True, False} == {kind[1] for kind in kinds}  # e_body on its slope and on its plateau
    assert {True, False} == {kind[2] for kind in kinds}  # hit and clear


def test_case_by_hand() -> None:
    # A ball of radius 0.1 flies along x: −1, 0, 1. One body sphere of radius 0.2 stands at
    # (0.5, 0.1, 0) and steps aside to (0.5, 0.6, 0) at time 2; the avoidance starts at time 1.
    attack = np.array([[[-1, 0, 0]], [[0, 0, 0]], [[1, 0, 0]]], np.float32)
    body = np.array([[[0.5, 0.1, 0]], [[0.5, 0.1, 0]], [[0.5, 0.6, 0]]], np.float32)
    arguments = (
        attack,
        np.array([0.1], np.float32),
        body,
        np.array([0.2], np.float32),
        body[1],
        np.array([False, True, True]),
        np.array([True, True, True]),
    )
    paper = EnergyConfig(form="paper", d0="paper", E_avoidance=0.1, D_body=0.5)
    got = energies(*arguments, dt=0.1, config=paper)
    # Time 1: the body is where it started, 0. Time 2: D(start) = √(0.25 + 0.01) − 0.3,
    # D(body) = √(0.25 + 0.36) − 0.3; the difference of the roots is 0.271123, × dt.
    moved = (math.sqrt(0.61) - math.sqrt(0.26)) * 0.1
    np.testing.assert_allclose(got.penetration, moved, rtol=1e-5)
    np.testing.assert_allclose(got.avoidance, 1 - moved / 0.1, rtol=1e-5)
    # Last interval: the ball relative to the body runs from (−0.5, −0.1) to (0.5, −0.6), a line
    # at distance |(−0.5)(−0.5) − (−0.1)(1)|/√1.25 = 0.35/√1.25 = 0.313050 from the origin.
    np.testing.assert_allclose(got.d, 0.35 / math.sqrt(1.25) - 0.3, atol=1e-6)
    # Frozen, the ball passes at 0.1 m: d0 = 0.1 − 0.3, and e_body = (0.013050 + 0.2)/0.5.
    np.testing.assert_allclose(got.d0, -0.2, atol=1e-6)
    np.testing.assert_allclose(got.body, (0.35 / math.sqrt(1.25) - 0.1) / 0.5, rtol=1e-5)
    # At the sampled times the ball never touches the start: nothing overlaps. And d0 is 0 at least.
    got = energies(*arguments, dt=0.1, config=EnergyConfig(D_body=0.5))
    assert (float(got.penetration), float(got.avoidance)) == (0.0, 1.0)
    np.testing.assert_allclose(got.body, (0.35 / math.sqrt(1.25) - 0.3) / 0.5, rtol=1e-4)
    # With a ball of radius 0.4 time 2 has depths 0.6 − √0.26 at the start and 0 for the body.
    big = (attack, np.array([0.4], np.float32), *arguments[2:])
    got = energies(*big, dt=0.1, config=EnergyConfig())
    np.testing.assert_allclose(got.penetration, (0.6 - math.sqrt(0.26)) * 0.1, rtol=1e-5)


def test_sweep_into_the_frozen_pose() -> None:
    # The body jumps from (0, 1, 0) to (2, 1, 0) at time 1, but the frozen one to (0, −1, 0): on its
    # way it meets the resting ball at the origin, which no sample and not the body itself does.
    body = np.array([[[0, 1, 0]], [[2, 1, 0]]], np.float32)
    radius, always = np.array([0.1], np.float32), np.array([True, True])
    start = np.array([[0, -1, 0]], np.float32)
    mask = np.array([False, True])
    ball = np.zeros((2, 1, 3), np.float32)
    got = energies(ball, radius, body, radius, start, mask, always, dt=DT, config=EnergyConfig())
    np.testing.assert_allclose([got.d, got.d0], [0.8, -0.2], atol=1e-6)


def test_no_avoidance_part_and_no_active_time() -> None:
    *arrays, avoidance, active = problem(3)
    got = energies(*arrays, avoidance & False, active, dt=DT, config=EnergyConfig())
    assert float(got.d) == float(got.d0)
    assert (float(got.body), float(got.penetration), float(got.avoidance)) == (1.0, 0.0, 1.0)
    got = energies(*arrays, avoidance, active & False, dt=DT, config=EnergyConfig())
    assert (float(got.d), float(got.d0), float(got.body)) == (FAR, FAR, 1.0)


def test_a_body_at_rest_is_not_modest() -> None:
    for seed in range(30):
        attack, attack_radii, body, body_radii, _, avoidance, active = problem(seed)
        body = np.repeat(body[:1] + np.float32(7.3), len(body), axis=0)
        attack = attack + np.float32(7.3)
        # The pose at t0 has been computed in another way than the same pose at the other times.
        start = body[0] + np.random.default_rng(seed).choice([-1e-6, 1e-6], size=(4, 3))
        start = start.astype(np.float32)
        arguments = (attack, attack_radii, body, body_radii, start, avoidance, active)
        for d0 in ("clamped", "paper"):
            got = energies(*arguments, dt=DT, config=EnergyConfig(d0=d0, D_body=5.0))
            if d0 == "paper" or float(got.d0) >= 0:
                assert float(got.body) == 1.0


@pytest.mark.parametrize("config", CONFIGS[::3], ids=lambda c: f"{c.form}-{c.d0}")
def test_batch_is_the_loop(config: EnergyConfig, monkeypatch: pytest.MonkeyPatch) -> None:
    problems = candidates(6)
    one_by_one = [energies(*p, dt=DT, config=config) for p in problems]
    wanted = jax.tree.map(lambda *fields: jnp.stack(fields), *one_by_one)
    assert_same(energies_batch(*batched(problems), dt=DT, config=config), wanted, atol=2e-6)
    # Straight code in blocks of 4 times for all batches.
    monkeypatch.setattr(energy_kernel, "WIDE", 1)
    monkeypatch.setattr(energy_kernel, "_BLOCK", 4)
    eager = energies_batch.__wrapped__(*batched(problems), dt=DT, config=config)
    assert_same(eager, wanted, atol=2e-6)


@pytest.fixture(scope="module")
def wide() -> tuple:
    """Enough candidates for straight code."""
    return batched(candidates(energy_kernel.WIDE, T=12, S=3))


def test_wide_batches_agree_with_plain_loops(wide: tuple) -> None:
    got = energies_batch(*wide, dt=DT, config=CONFIGS[2])
    for c, p in enumerate(candidates(energy_kernel.WIDE, T=12, S=3)[:10]):
        wanted = reference.energies(*p, dt=DT, config=CONFIGS[2])
        assert_same(jax.tree.map(lambda field, c=c: field[c], got), wanted, atol=5e-5)


def test_gradients_of_wide_batches_are_those_of_single_paths(wide: tuple) -> None:
    attack, attack_radii, body, *rest = wide
    config = EnergyConfig(E_avoidance=1.0)

    def loss(body: jax.Array) -> jax.Array:
        got = energies_batch(attack, attack_radii, body, *rest, dt=DT, config=config)
        return jnp.sum(got.penetration + got.d + 2 * got.d0)

    def loss_of_one(body: jax.Array, p: tuple) -> jax.Array:
        got = energies(*p[:2], body, *p[3:], dt=DT, config=config)
        return got.penetration + got.d + 2 * got.d0

    got = jax.grad(loss)(body)
    gradient = jax.jit(jax.grad(loss_of_one))
    for c, p in enumerate(candidates(energy_kernel.WIDE, T=12, S=3)[:5]):
        wanted = jnp.moveaxis(gradient(p[2], p), -1, 0)
        np.testing.assert_allclose(got[:, :, c], wanted, rtol=1e-4, atol=1e-5)


def test_gradient_agrees_with_differences() -> None:
    *arrays, avoidance, active = problem(5, T=5, I=1, S=2)
    config = EnergyConfig(form="paper", E_avoidance=40.0)

    def of_body(body: np.ndarray, f: object) -> object:
        changed = (*arrays[:2], body, *arrays[3:], avoidance, active)
        got = f(*changed, dt=DT, config=config)
        return got.penetration + got.d + got.d0

    gradient = jax.grad(lambda body: of_body(body, energies))(arrays[2])
    for index in np.ndindex(arrays[2].shape):
        step = np.zeros(arrays[2].shape)
        step[index] = 1e-5
        up, down = (of_body(arrays[2] + s * step, reference.energies) for s in (1, -1))
        np.testing.assert_allclose(gradient[index], (up - down) / 2e-5, atol=2e-3)


def test_jit_is_eager() -> None:
    arguments = problem(1, T=4, I=1, S=2)
    compiled = energies(*arguments, dt=DT, config=CONFIGS[0])
    with jax.disable_jit():
        eager = energies(*arguments, dt=DT, config=CONFIGS[0])
    assert_same(compiled, eager, atol=1e-6)


def test_vmap_is_the_loop() -> None:
    problems = [problem(seed) for seed in range(4)]
    stacked = [np.stack(parts) for parts in zip(*problems, strict=True)]
    got = jax.vmap(lambda *a: energies(*a, dt=DT, config=CONFIGS[1]))(*stacked)
    for k, p in enumerate(problems):
        one = jax.tree.map(lambda field, k=k: field[k], got)
        assert_same(one, energies(*p, dt=DT, config=CONFIGS[1]), atol=2e-6)


def test_padding_changes_nothing(wide: tuple) -> None:
    arguments = problem(2)
    attack, attack_radii, body, body_radii, start, *masks = arguments
    far = np.full((3, 1, 3), 12.0, np.float32)
    attack = np.concatenate([attack, np.repeat(far, attack.shape[1], axis=1)])
    body = np.concatenate([body, np.repeat(far, body.shape[1], axis=1)])
    masks = [np.concatenate([mask, np.zeros(3, bool)]) for mask in masks]
    padded = (attack, attack_radii, body, body_radii, start, *masks)
    wanted = energies(*arguments, dt=DT, config=CONFIGS[0])
    assert_same(energies(*padded, dt=DT, config=CONFIGS[0]), wanted, atol=1e-6)

    attack, attack_radii, body, body_radii, start, avoidance, active = wide
    body, start = (np.concatenate([a, 0 * a], axis=-2) for a in (body, start))
    avoidance, active = (np.concatenate([m, m & False], axis=-1) for m in (avoidance, active))
    more = (attack, attack_radii, body, body_radii, start, avoidance, active)
    got = energies_batch(*more, dt=DT, config=CONFIGS[0])
    half = jax.tree.map(lambda field: field[: energy_kernel.WIDE], got)
    assert_same(half, energies_batch(*wide, dt=DT, config=CONFIGS[0]), atol=1e-6)
    assert (np.asarray(got.d[energy_kernel.WIDE :]) == FAR).all()


@pytest.mark.parametrize("form", ["paper", "overlap"])
@pytest.mark.parametrize("masks", [(True, True), (False, True), (True, False), (False, False)])
def test_gradients_are_finite_at_degenerate_points(form: str, masks: tuple[bool, bool]) -> None:
    # Everything in one point and at rest; then a ball that passes exactly through the centre; then
    # spheres that barely move.
    rest = np.zeros((3, 1, 3), np.float32)
    through = np.array([[[-1, 0, 0]], [[0, 0, 0]], [[1, 0, 0]]], np.float32)
    radius, avoidance = np.array([0.1], np.float32), np.full(3, masks[0])

    def loss(attack, body, start, config: EnergyConfig) -> jax.Array:
        active = np.full(3, masks[1])
        got = energies(attack, radius, body, radius, start, avoidance, active, dt=DT, config=config)
        scale = time_scale_energy(1.0, config.E_time)
        return total_energy(got.avoidance, got.body, scale, config) + got.d + got.d0

    gradient = jax.jit(jax.value_and_grad(loss, argnums=(0, 1, 2, 3)))
    for attack in (rest, through, 1e-12 * through, 1e-20 * through):
        for start in (rest[0], rest[0] + 1):
            chex.assert_tree_all_finite(gradient(attack, rest, start, EnergyConfig(form=form)))


def test_numbers_are_traced() -> None:
    arguments = problem(1, T=4, I=1, S=2)

    @jax.jit
    @chex.assert_max_traces(n=1)
    def total(config: EnergyConfig, dt: float) -> jax.Array:
        got = energies(*arguments, dt=dt, config=config)
        return total_energy(got.avoidance, got.body, time_scale_energy(2.0, config.E_time), config)

    config = EnergyConfig(form="paper")
    numbers = [f.name for f in dataclasses.fields(config) if f.name not in ("form", "d0")]
    before = total(config, DT)
    for name in numbers:
        total(dataclasses.replace(config, **{name: 2 * getattr(config, name)}), 2 * DT)
    np.testing.assert_allclose(total(config, DT), before)
    sweep = dataclasses.replace(config, E_avoidance=jnp.array([0.5, 40.0]))
    axes = jax.tree.map(lambda x: 0 if isinstance(x, jax.Array) else None, sweep)
    swept = jax.vmap(lambda c: energies(*arguments, dt=DT, config=c).avoidance, (axes,))(sweep)
    assert swept.shape == (2,)


def test_unknown_form_is_refused() -> None:
    config = EnergyConfig()
    object.__setattr__(config, "form", "overlop")  # past the type check of the tests
    with pytest.raises(ConfigError, match="overlop"):
        energies(*problem(1, T=4, I=1, S=2), dt=DT, config=config)


def test_time_scale_and_total() -> None:
    s = np.array([0.25, 0.5, 1.0, 2.0, 4.0, 8.0], np.float32)
    # 1/(s·4) below 1, s/4 above, 1/4 at 1.
    np.testing.assert_allclose(time_scale_energy(s, 4.0), [1, 0.5, 0.25, 0.5, 1, 2], rtol=1e-6)
    for value in s:
        wanted = reference.time_scale_energy(float(value), 3.0)
        np.testing.assert_allclose(time_scale_energy(float(value), 3.0), wanted, rtol=1e-6)
        wanted = reference.time_scale_energy(float(value), 3.0, 4.0)
        np.testing.assert_allclose(time_scale_energy(float(value), 3.0, 4.0), wanted, rtol=1e-6)
    # (1 + 4 (1/s − 1))/4 below 1.
    np.testing.assert_allclose(time_scale_energy(s[:4], 4.0, 4.0), [3.25, 1.25, 0.25, 0.5])
    config = EnergyConfig(w_a=1.0, w_b=10.0, w_t=100.0)
    np.testing.assert_allclose(total_energy(0.1, 0.2, 0.3, config), 0.1 + 2.0 + 30.0, rtol=1e-6)
    config = dataclasses.replace(config, w_m=5.0)
    total = total_energy(0.1, 0.2, 0.3, config, movement_energy(0.12, 0.3))
    np.testing.assert_allclose(total, 0.1 + 2.0 + 30.0 + 5 * 0.4, rtol=1e-6)


def test_unswept_distances_bound_the_swept_ones() -> None:
    problems = candidates(6)
    arguments = batched(problems)
    config = EnergyConfig()
    swept = energies_batch(*arguments, dt=DT, config=config)
    sampled = energies_batch(*arguments, dt=DT, config=config, swept=False)
    relative = arguments[0][:, :, :, None, None] - arguments[2][:, :, None]
    step = np.linalg.norm(np.diff(relative, axis=1), axis=0).max(axis=(0, 1, 3))
    assert (np.asarray(sampled.d) >= np.asarray(swept.d) - 1e-6).all()
    assert (np.asarray(sampled.d) <= np.asarray(swept.d) + step / 2 + 1e-6).all()
    np.testing.assert_array_equal(sampled.penetration, swept.penetration)


@hypothesis.given(seed=st.integers(0, 10**6), form=st.sampled_from(["paper", "overlap"]))
def test_sweep_lies_between_samples_and_dense_samples(seed: int, form: str) -> None:
    arguments = problem(seed, T=6, I=1, S=2)
    attack, attack_radii, body, body_radii, start, avoidance, active = arguments
    got = energies(*arguments, dt=DT, config=EnergyConfig(form=form, E_avoidance=1.0))
    bodies = {"d": body, "d0": reference.frozen_body(body, start, avoidance)}
    for name, centres in bodies.items():
        case = (attack, attack_radii, centres, body_radii, active)
        value = float(getattr(got, name))
        at_samples = reference.clearance(*case, distance=lambda p0, p1: np.inf)
        dense = reference.clearance(*case, distance=reference.sampled_distance)
        assert value <= at_samples + 1e-5
        assert min(dense, FAR) - 2e-3 <= value <= dense + 1e-5


@hypothesis.given(seed=st.integers(0, 10**6), factor=st.sampled_from([0.25, 0.5, 2.0, 8.0]))
def test_units(seed: int, factor: float) -> None:
    # Lengths in another unit: e', d and d0 scale, the energies stay if their scales do as well.
    # With powers of two this is exact, but for the clearances taken as equal.
    arguments = problem(seed, T=6, I=1, S=2)
    scaled = tuple(a if a.dtype == bool else a * np.float32(factor) for a in arguments)
    config = EnergyConfig(form="paper", E_avoidance=1.0, D_body=0.3)
    other = dataclasses.replace(config, E_avoidance=factor, D_body=0.3 * factor)
    one, two = energies(*arguments, dt=DT, config=config), energies(*scaled, dt=DT, config=other)
    np.testing.assert_allclose(two.penetration, factor * one.penetration, rtol=1e-5)
    np.testing.assert_allclose(two.avoidance, one.avoidance, rtol=1e-5, atol=1e-6)
    if float(one.d) < FAR:
        np.testing.assert_allclose([two.d, two.d0], [factor * one.d, factor * one.d0], rtol=1e-5)


def test_a_nan_is_seen(wide: tuple) -> None:
    # Two candidates of many have a NaN at an active time: it must not look like clearance.
    attack, attack_radii, body, body_radii, start, avoidance, active = wide
    body, active = body.copy(), active | True
    body[0, 5, 3, 1] = body[2, 0, 7, 0] = np.nan
    arguments = (attack, attack_radii, body, body_radii, start, avoidance, active)
    got = energies_batch(*arguments, dt=DT, config=EnergyConfig())
    assert np.flatnonzero(np.isnan(got.d)).tolist() == [3, 7]
