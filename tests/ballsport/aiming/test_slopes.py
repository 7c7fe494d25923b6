"""Slopes of passes, compared with how the best launch moves, found anew in float64."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq, minimize

from mgjax.ballsport import BallPhysics, Net, aim
from mgjax.ballsport.aiming.solve import OK, TOO_FAR
from tests.reference import ball as reference

START, TARGET, GUESS = [0.0, 0.4, 0.0], [6.0, 0.9, 3.0], [5.0, 4.0, 2.0]
NET = Net(x=3.0, z=0.0, heading=np.pi / 2, height=2.2)
AIR = BallPhysics(drag=0.013, drag_law="quadratic")
CASES: dict[str, dict[str, Any]] = {
    "straight": {"bounces": 0},
    "one bounce": {"bounces": 1},
    "two bounces": {"bounces": 2},
    "in time": {"bounces": 1, "wanted": 1.6},
    "through air": {"bounces": 1, "physics": AIR},
    "as fast as can be": {
        "bounces": 0,
        "max_speed": 8.0,
        "target": [5.0, 0.4, 2.0],
        "guess": [3.0, 9.0, 1.0],
    },
    "over a net": {"bounces": 0, "net": NET, "guess": [8.0, 2.0, 3.0]},
}


def asked(case: dict[str, Any]) -> np.ndarray:
    """Start, target, guess, flight time and restitution as one vector."""
    physics = case.get("physics", BallPhysics())
    target, guess = case.get("target", TARGET), case.get("guess", GUESS)
    return np.array([*START, *target, *guess, case.get("wanted", 0.0), physics.restitution])


def aimed(case: dict[str, Any], vector: Any) -> Any:
    physics = replace(case.get("physics", BallPhysics()), restitution=vector[10])
    options = {name: case[name] for name in ("net", "max_speed") if name in case}
    if "wanted" in case:
        options["flight_time"] = vector[9]
    return aim(
        vector[:3],
        vector[3:6],
        bounces=case["bounces"],
        guess=vector[6:9],
        physics=physics,
        **options,
    )


def launch_of(case: dict[str, Any], vector: Any) -> tuple[jax.Array, Any]:
    found = aimed(case, vector)
    return jnp.concatenate([found.velocity, found.time[None]]), found


def best(case: dict[str, Any], vector: np.ndarray, near: np.ndarray) -> np.ndarray:
    """(v, T) of least |v − guess|² + (5 (T − wanted))² that meets the target, from ``near`` on."""
    physics = replace(case.get("physics", BallPhysics()), restitution=float(vector[10]))
    timed = 5.0 if "wanted" in case else 0.0

    def cost(x: np.ndarray) -> float:
        late = timed * (x[3] - vector[9])
        return float(np.sum((x[:3] - vector[6:9]) ** 2) + late * late)

    def missed(x: np.ndarray) -> np.ndarray:
        return reference.arrival(vector[:3], x[:3], x[3], physics)[0] - vector[3:6]

    def above_net(x: np.ndarray) -> float:
        def ahead(time: float) -> float:
            return reference.arrival(vector[:3], x[:3], time, physics)[0][0] - NET.x

        time = brentq(ahead, 1e-3, x[3], xtol=1e-12)
        place = reference.arrival(vector[:3], x[:3], time, physics)[0]
        return float(place[1] - physics.radius - NET.height)

    constraints: list[dict[str, Any]] = [{"type": "eq", "fun": missed}]
    if "max_speed" in case:
        fastest = case["max_speed"]
        constraints.append({"type": "ineq", "fun": lambda x: fastest**2 - np.sum(x[:3] ** 2)})
    if "net" in case:
        constraints.append({"type": "ineq", "fun": above_net})
    options = {"ftol": 1e-15, "maxiter": 300}
    return minimize(cost, near, method="SLSQP", constraints=constraints, options=options).x


QUICK = ("straight", "as fast as can be", "over a net")


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.long) for n in CASES]
)
def test_slopes_are_those_of_the_best_launch(name: str) -> None:
    case = CASES[name]
    vector = asked(case)
    slopes, found = jax.jit(jax.jacfwd(lambda v: launch_of(case, v), has_aux=True))(
        jnp.asarray(vector, jnp.float32)
    )
    assert found.status == OK
    there = best(case, vector, np.array([*found.velocity, found.time], np.float64))
    step, used = 2e-3, [i for i in range(11) if i != 9 or "wanted" in case]
    used = used if name in QUICK else [i for i in used if i in (4, 7, 9, 10)]
    differences = np.stack(
        [
            (best(case, vector + e, there) - best(case, vector - e, there)) / (2 * step)
            for e in step * np.eye(11)[used]
        ],
        axis=1,
    )
    off = np.abs(np.asarray(slopes)[:, used] - differences).max()
    assert off < 0.05 * max(1.0, np.abs(differences).max())


@pytest.mark.parametrize("name", ["straight", "over a net"])
def test_forwards_is_backwards_and_a_batch_is_a_loop(name: str) -> None:
    case = CASES[name]
    vector = jnp.asarray(asked(case), jnp.float32)

    def launch(vector: jax.Array) -> jax.Array:
        return launch_of(case, vector)[0]

    forwards, backwards = jax.jit(jax.jacfwd(launch)), jax.jit(jax.jacrev(launch))
    np.testing.assert_allclose(forwards(vector), backwards(vector), atol=1e-4)
    several = jnp.stack([vector, vector.at[5].add(0.5), vector.at[3].add(1.0)])
    many = jax.jit(jax.vmap(jax.jacrev(launch)))(several)
    for row, one in enumerate(several):
        np.testing.assert_allclose(many[row], backwards(one), atol=1e-3)


def test_what_is_differentiated_is_what_is_found_without() -> None:
    case = CASES["one bounce"]
    vector = jnp.asarray(asked(case), jnp.float32)
    plain = aimed(case, vector)
    moved = jnp.zeros(11).at[4].set(1.0)
    same, slope = jax.jit(lambda v, d: jax.jvp(lambda v: aimed(case, v), (v,), (d,)))(vector, moved)
    for one, other in zip(jax.tree.leaves(plain), jax.tree.leaves(same), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-4)
    np.testing.assert_allclose(slope.arrival, [0, 1, 0], atol=1e-6)
    assert slope.miss == 0


@pytest.mark.parametrize(
    ("change", "status"),
    [
        ({3: 500.0}, TOO_FAR),
        ({3: 0.0, 4: 0.4, 5: 0.0}, OK),  # at the start: a ball that comes back
        ({4: 0.11}, OK),  # on the ground
    ],
)
def test_slopes_are_finite_at_degenerate_points(change: dict[int, float], status: int) -> None:
    case = CASES["straight"]
    vector = jnp.asarray(asked(case), jnp.float32)
    for place, value in change.items():
        vector = vector.at[place].set(value)
    slopes, found = jax.jit(jax.jacrev(lambda v: launch_of(case, v), has_aux=True))(vector)
    assert found.status == status
    assert np.isfinite(slopes).all()
    if status == TOO_FAR:
        assert not np.asarray(slopes).any()
