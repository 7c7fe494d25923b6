"""The table of docs/gradients.md, row by row: what it says is differentiable is differentiated."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.avoidance import EnergyConfig, clearance, energies, soft_energies
from mgjax.avoidance.timing.time_scale import time_scale
from mgjax.ballsport import BallPhysics, aim, contact_times, fly
from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core import kinematics
from mgjax.core.timing.time_warp import scaled_warp
from mgjax.hybrid import fabrik
from tests.avoidance.energy.test_energies import DT, problem

PAGE = Path(__file__).resolve().parent.parent / "docs" / "gradients.md"


class Case(NamedTuple):
    """Attributes: a function of arrays with one array as result, an ordinary point, one that is
    degenerate, how far to step for differences, and by how much they may be off."""

    function: Callable[..., Any]
    ordinary: tuple[np.ndarray, ...]
    degenerate: tuple[np.ndarray, ...]
    step: float = 1e-2
    off: float = 2e-2


def _all(record: Any) -> jax.Array:
    return jnp.stack([record.avoidance, record.body, record.penetration, record.d, record.d0])


def _energies() -> Case:
    attack, radii, body, body_radii, start, avoidance, active = problem(5, T=5, I=1, S=2)
    scales = np.float32([1.0, 0.6])

    def worth(attack: Any, body: Any, scales: Any) -> jax.Array:
        config = EnergyConfig(E_avoidance=scales[0], D_body=scales[1])
        arrays = (attack, radii, body, body_radii, start, avoidance, active)
        return _all(energies(*arrays, dt=DT, config=config))

    still = np.zeros_like(attack), np.zeros_like(body), scales
    return Case(worth, (attack, body, scales), still, step=1e-3)


def _soft_energies() -> Case:
    attack, radii, body, body_radii, start, avoidance, active = problem(5, T=5, I=1, S=2)
    scales = np.float32([1.0, 0.6, 0.1])

    def worth(attack: Any, body: Any, scales: Any) -> jax.Array:
        config = EnergyConfig(E_avoidance=scales[0], D_body=scales[1])
        arrays = (attack, radii, body, body_radii, start, avoidance, active)
        return _all(soft_energies(*arrays, dt=DT, config=config, temperature=scales[2]))

    still = np.zeros_like(attack), np.zeros_like(body), scales
    return Case(worth, (attack, body, scales), still)


def _clearance() -> Case:
    attack, radii, body, body_radii, *_ = problem(5, T=5, I=1, S=2)

    def near(attack: Any, body: Any) -> jax.Array:
        return clearance(attack, radii, body, body_radii).distance[None]

    return Case(near, (attack, body), (np.zeros_like(attack), np.zeros_like(body)), step=1e-3)


def _fly() -> Case:
    def places(position: Any, velocity: Any, times: Any) -> jax.Array:
        return fly(position, velocity, times, physics=BallPhysics())

    ordinary = np.float32([0, 1, 0]), np.float32([1, 3, 5]), np.float32([0.3, 1.2, 2.0])
    rest = np.float32([0, 0.11, 0]), np.zeros(3, np.float32), np.zeros(3, np.float32)
    return Case(places, ordinary, rest, step=2e-3)


def _contact_times() -> Case:
    def times(position: Any, velocity: Any) -> jax.Array:
        return contact_times(position, velocity, physics=BallPhysics())[:3]

    ordinary = np.float32([0, 1, 0]), np.float32([1, 3, 5])
    return Case(times, ordinary, (np.float32([0, 0.11, 0]), np.zeros(3, np.float32)))


def _aim() -> Case:
    def launch(start: Any, target: Any, guess: Any, seconds: Any) -> jax.Array:
        found = aim(start, target, bounces=0, guess=guess, flight_time=seconds)
        return jnp.concatenate([found.velocity, found.time[None]])

    start, target, guess = (np.float32(p) for p in ([0, 0.4, 0], [6, 0.9, 3], [5, 4, 2]))
    there = start, start, np.zeros(3, np.float32), np.float32(1.0)
    return Case(launch, (start, target, guess, np.float32(1.2)), there, step=0.05, off=5e-2)


def _fabrik() -> Case:
    def joints(joints: Any, target: Any) -> jax.Array:
        return fabrik(joints, target)[0]

    chain = np.float32([[0, 0, 0], [0.2, 0.3, 0], [0.5, 0.4, 0.1], [0.7, 0.2, 0.2]])
    straight = np.float32([[0, 0, 0], [0, 1, 0], [0, 2, 0], [0, 3, 0]])
    return Case(
        joints, (chain, np.float32([0.5, 0.5, 0.4])), (straight, np.float32([0, 1, 0])), 1e-3, 5e-2
    )


def _forward() -> Case:
    skeleton = synthetic_skeleton()
    local = np.zeros((skeleton.num_joints, 4), np.float32)
    local[:, 0] = 1

    def places(root: Any, local: Any) -> jax.Array:
        return kinematics.forward(skeleton, root, local)[0]

    point = np.zeros(3, np.float32), local
    return Case(places, point, point)


def _time_scale() -> Case:
    """Two edges of three may be scaled; and a walk of no length, of which none can."""
    may = np.array([True, False, True])

    def scaling(seconds: Any, centre: Any, t_attack: Any) -> jax.Array:
        found = time_scale(
            seconds, may, may, jnp.int32(3), centre, t_attack,
            half_frame=1 / 60, limits=(jnp.float32(4.0), jnp.float32(4.0)),
        )  # fmt: skip
        return jnp.concatenate([found.s_time[None], found.scales])

    walk = np.float32([0.5, 0.4, 0.8]), np.float32(0.3), np.float32(2.0)
    return Case(scaling, walk, (np.zeros(3, np.float32), np.float32(0.0), np.float32(2.0)))


def _scaled_warp() -> Case:
    """Within pieces; and asked at the knots of pieces of no length."""

    def shown(asked: Any, durations: Any, scales: Any) -> jax.Array:
        return scaled_warp(durations, scales).at(asked)

    asked, durations = np.float32([0.2, 0.7, 1.5]), np.float32([0.4, 0.7, 0.5])
    none = np.zeros(3, np.float32), np.zeros(3, np.float32), np.ones(3, np.float32)
    return Case(shown, (asked, durations, np.float32([1.0, 0.8, 1.5])), none)


CASES = {
    "mgjax.avoidance.energies": _energies,
    "mgjax.avoidance.soft_energies": _soft_energies,
    "mgjax.avoidance.clearance": _clearance,
    "mgjax.ballsport.fly": _fly,
    "mgjax.ballsport.contact_times": _contact_times,
    "mgjax.ballsport.aim": _aim,
    "mgjax.hybrid.fabrik": _fabrik,
    "mgjax.core.kinematics.forward": _forward,
    "mgjax.avoidance.timing.time_scale.time_scale": _time_scale,
    "mgjax.core.timing.time_warp.scaled_warp": _scaled_warp,
}


def table() -> dict[str, list[str]]:
    """The rows of the page: of each function what stands beside it."""
    lines = [line for line in PAGE.read_text("utf-8").splitlines() if line.startswith("| `")]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {name.strip("`"): rest for name, *rest in cells}


def test_the_table_is_what_is_tested() -> None:
    rows = table()
    assert set(rows) == set(CASES)
    assert all(rest[1:] == ["yes"] * 4 for rest in rows.values())


LONG = {"mgjax.hybrid.fabrik"}


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.long if n in LONG else ()) for n in sorted(CASES)],
)
def test_rows(name: str) -> None:
    case = CASES[name]()
    rng = np.random.default_rng(3)
    ways = tuple(np.asarray(rng.normal(size=x.shape), np.float32) for x in case.ordinary)
    if name == "mgjax.core.kinematics.forward":
        ways[1][:, 0] = 0.0  # rotations stay of unit length, to first order

    def along(point: tuple, way: tuple) -> tuple[jax.Array, ...]:
        value, forwards = jax.jvp(case.function, point, way)
        weights = jnp.linspace(-1.0, 1.0, value.size).reshape(value.shape)
        slopes = jax.grad(lambda p: jnp.sum(case.function(*p) * weights))(point)
        backwards = sum(jnp.sum(s * w) for s, w in zip(slopes, way, strict=True))
        finite = jnp.stack([jnp.all(jnp.isfinite(s)) for s in slopes])
        return value, forwards, jnp.sum(forwards * weights), backwards, jnp.all(finite)

    moved = [
        tuple(x + sign * case.step * w for x, w in zip(case.ordinary, ways, strict=True))
        for sign in (1, -1)
    ]
    points = (case.ordinary, *moved, case.degenerate)
    stacked = jax.tree.map(lambda *x: np.stack(x).astype(np.float32), *points)
    many = jax.tree.map(lambda w: np.stack([w] * 4), ways)
    value, forwards, one, other, finite = map(np.asarray, jax.jit(jax.vmap(along))(stacked, many))
    assert finite.all()
    assert np.isfinite(forwards).all()
    np.testing.assert_allclose(one, other, rtol=2e-3, atol=2e-3 * (1 + np.abs(one).max()))
    differences = (value[1] - value[2]) / (2 * case.step)
    size = 1 + np.abs(differences).max()
    np.testing.assert_allclose(forwards[0], differences, atol=case.off * size)
