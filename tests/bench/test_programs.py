"""Hot programs are as large as they were: a blow-up of compiled code is seen at once."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy.energies import energies_batch
from mgjax.ballsport.aiming.passes import aim
from mgjax.ballsport.ball.physics import BallPhysics
from mgjax.ballsport.ball.trajectory import fly
from mgjax.core.kinematics import forward
from mgjax.graph.distances.distance import distance_matrix
from mgjax.hybrid.ik.chain import fabrik
from tests.conftest import make_skeleton
from tests.programs import check, operations, operations_within


def kinematics() -> int:
    skeleton = make_skeleton()
    run = jax.jit(lambda root, turns: forward(skeleton, root, turns)[0])
    return operations(run, jnp.zeros((8, 3)), jnp.ones((8, skeleton.num_joints, 4)))


def distances() -> int:
    a, b = (np.zeros((20, 5, 3), np.float32) + x for x in (0, 1))
    return operations_within(
        "mgjax.graph.distances.distance._distance_matrix", lambda: distance_matrix(a, b, window=4)
    )


def energies() -> int:
    mask = jnp.ones((6, 4), bool)
    return operations(
        energies_batch, jnp.zeros((3, 6, 1)), jnp.ones(1), jnp.zeros((3, 6, 4, 5)), jnp.ones(5),
        jnp.zeros((3, 4, 5)), mask, mask, dt=0.05, config=EnergyConfig(),
    )  # fmt: skip


def inverse_kinematics() -> int:
    return operations(fabrik, jnp.zeros((4, 5, 3)), jnp.zeros((4, 3)))


def its_slope() -> int:
    run = jax.jit(jax.grad(lambda joints, target: jnp.sum(fabrik(joints, target)[0])))
    return operations(run, jnp.zeros((4, 5, 3)), jnp.zeros((4, 3)))


def flight() -> int:
    return operations(fly, jnp.zeros(3), jnp.zeros(3), jnp.zeros(5), physics=BallPhysics())


def aiming() -> int:
    ends = np.array([0.0, 0.3, 0.0]), np.array([4.0, 0.5, 3.0])
    call = partial(aim, *ends, bounces=1, guess=np.array([4.0, 3.0, 3.0]))
    return operations_within("mgjax.ballsport.aiming.passes._aim", call)


@pytest.mark.parametrize(
    "program", [kinematics, distances, energies, inverse_kinematics, its_slope, flight, aiming]
)
def test_operations(program: Callable[[], Any]) -> None:
    check(program.__name__, program())


def test_a_blow_up_is_seen() -> None:
    def unrolled(x: jax.Array, times: int) -> jax.Array:
        for _ in range(times):
            x = jnp.sin(x) + 1
        return x

    sizes = [operations(jax.jit(partial(unrolled, times=n)), jnp.zeros(3)) for n in (2, 20)]
    assert sizes[1] > 5 * sizes[0]
    with pytest.raises(AssertionError):
        check("flight", 10**6)
