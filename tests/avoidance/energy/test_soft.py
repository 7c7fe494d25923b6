from __future__ import annotations

import jax
import numpy as np
import pytest

from mgjax.avoidance import EnergyConfig, clearance, energies, soft_energies
from mgjax.avoidance.energy.score import time_scale_energy
from mgjax.avoidance.energy.soft import soft_time_scale_energy
from mgjax.avoidance.rates import FAR
from tests.avoidance.energy.test_energies import DT, FIELDS, problem
from tests.reference import energy as reference

CONFIG = EnergyConfig(E_avoidance=1.0, D_body=0.3)


def near(arguments: tuple, *, temperature: float | None = None):
    attack, attack_radii, body, body_radii, _, _, active = arguments
    return clearance(attack, attack_radii, body, body_radii, active, temperature=temperature)


def test_clearance_is_that_of_the_energies_and_says_where() -> None:
    for seed in range(20):
        attack, attack_radii, body, body_radii, *_, active = arguments = problem(seed)
        found = near(arguments)
        wanted = reference.clearance(attack, attack_radii, body, body_radii, active)
        np.testing.assert_allclose(found.distance, min(wanted, FAR), atol=5e-5)
        if not active.any():
            continue
        # At the moment and the spheres that are named, they are so far apart.
        moment, i, s = float(found.moment), int(found.attack_sphere), int(found.body_sphere)
        times = np.arange(len(active))
        places = [
            np.array([np.interp(moment, times, x[:, k]) for k in range(3)])
            for x in (attack[:, i], body[:, s])
        ]
        apart = np.linalg.norm(places[0] - places[1]) - attack_radii[i] - body_radii[s]
        np.testing.assert_allclose(found.distance, apart, atol=5e-5)


def test_only_the_nearest_pair_pulls_and_softly_all_that_are_as_near() -> None:
    # A ball halfway between two spheres, a hand's breadth from each.
    attack, body = np.zeros((2, 1, 3), np.float32), np.zeros((2, 2, 3), np.float32)
    body[:, 0, 0], body[:, 1, 0] = 0.3, -0.3
    radii = np.float32([0.1]), np.float32([0.1, 0.1])

    def of_body(body, temperature):
        found = clearance(attack, radii[0], body, radii[1], temperature=temperature)
        return found.distance

    sharp, soft = (np.asarray(jax.grad(of_body)(body, t)) for t in (None, 0.05))
    assert np.count_nonzero(np.abs(sharp).sum(axis=(0, 2))) == 1
    np.testing.assert_allclose(soft.sum(axis=0), [[0.5, 0, 0], [-0.5, 0, 0]], atol=1e-5)
    found = [float(of_body(body, t)) for t in (0.1, 0.01, 0.001)]
    # Two spheres, at two times each: below by τ log 4.
    wanted = 0.1 - np.array([0.1, 0.01, 0.001]) * np.log(4)
    np.testing.assert_allclose(found, wanted, atol=1e-5)
    body[:] = 0.0  # all at one point, at rest
    assert np.isfinite(jax.grad(of_body)(body, None)).all()
    assert np.isfinite(jax.grad(of_body)(body, 0.05)).all()


def test_far_where_nothing_is_there() -> None:
    *rest, active = problem(0)
    for temperature in (None, 0.01):
        assert float(near((*rest, active & False), temperature=temperature).distance) == FAR


@pytest.mark.parametrize("form", ["overlap", "paper"])
def test_the_limit_is_the_papers(form: str) -> None:
    config = EnergyConfig(form=form, E_avoidance=1.0 if form == "overlap" else 40.0, D_body=0.3)
    temperatures = (0.1, 0.01, 1e-3, 1e-5)
    worst = {name: [] for name in FIELDS}
    for seed in range(12):
        arguments = problem(seed)
        wanted = energies(*arguments, dt=DT, config=config)
        for off in worst.values():
            off.append([])
        for temperature in temperatures:
            got = soft_energies(*arguments, dt=DT, config=config, temperature=temperature)
            for name, off in worst.items():
                off[-1].append(abs(float(getattr(got, name)) - float(getattr(wanted, name))))
    for name, off in worst.items():
        means = np.mean(off, axis=0)
        assert means[-1] <= means[0] + 1e-6, name
        if name in ("penetration", "d", "d0"):
            assert (np.diff(means) <= 1e-6).all(), name  # the colder, the nearer
        np.testing.assert_allclose(np.max(off, axis=0)[-1], 0.0, atol=2e-4, err_msg=name)


def test_time_scale_energy_in_the_limit() -> None:
    s = np.linspace(0.3, 3.0, 28)
    wanted = time_scale_energy(s, 4.0, 4.0)
    off = [
        float(np.abs(soft_time_scale_energy(s, 4.0, 4.0, t) - wanted).max())
        for t in (0.3, 0.03, 0.003)
    ]
    assert off[0] > off[1] > off[2]
    assert off[2] < 2e-3


def test_slopes_where_the_paper_has_none() -> None:
    # A perfect avoidance and a large clearance: both energies are flat, their soft forms are not.
    arguments = problem(3)
    flat = EnergyConfig(E_avoidance=1e-3, D_body=0.01)

    def total(config, soft):
        if soft:
            got = soft_energies(*arguments, dt=DT, config=config, temperature=0.1)
        else:
            got = energies(*arguments, dt=DT, config=config)
        return got.avoidance + got.body

    sharp, soft = (jax.grad(lambda c, s=soft: total(c, s))(flat) for soft in (False, True))
    assert float(sharp.D_body) == 0.0
    assert float(soft.D_body) != 0.0
    assert all(np.isfinite(x) for x in jax.tree.leaves(soft))
