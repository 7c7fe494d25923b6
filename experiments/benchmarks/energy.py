"""Time of the sphere energies: 1,000 candidates x 40 times x 24 body spheres, one attack sphere.

Each case is also given as a ratio to a bare pass over the same array (one multiply and add per
element, summed), measured in turns with it. Run: ``python -m experiments.benchmarks.energy``.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy.energies import energies_batch
from mgjax.runs.experiment import Results, experiment

CANDIDATES, TIMES, SPHERES, ROUNDS = 1000, 40, 24, 40


def problem(attack_spheres: int = 1, *, seed: int = 0) -> tuple[jax.Array, ...]:
    """Bodies that drift, balls at 10 m/s that cross them, active for most of the time."""
    rng = np.random.default_rng(seed)
    t = np.linspace(-1.0, 1.0, TIMES)
    attack = np.zeros((3, TIMES, attack_spheres))
    attack[0] = 10.0 * t[:, None] + 0.1 * np.arange(attack_spheres)
    drift = np.cumsum(rng.normal(scale=0.02, size=(3, TIMES, CANDIDATES, 1)), axis=1)
    body = rng.normal(scale=0.4, size=(3, 1, CANDIDATES, SPHERES)) + drift
    first = rng.integers(5, 20, CANDIDATES)
    index = np.arange(TIMES)[:, None]
    arrays = (
        attack.astype(np.float32),
        np.full(attack_spheres, 0.1, np.float32),
        body.astype(np.float32),
        np.full(SPHERES, 0.1, np.float32),
        body[:, 10].astype(np.float32),
        (index >= first) & (index < first + 15),
        np.repeat((index > 4) & (index < 36), CANDIDATES, axis=1),
    )
    return tuple(jnp.asarray(a) for a in arrays)


def bare(arrays: tuple[jax.Array, ...]) -> jax.Array:
    """One multiply and add per element and a running sum over time, as straight code."""
    body = arrays[2]
    total = 2 * body[:, 0] + 1
    for t in range(1, TIMES):
        total = total + (2 * body[:, t] + 1)
    return total


def unswept(arrays: tuple[jax.Array, ...], config: EnergyConfig) -> tuple[jax.Array, jax.Array]:
    """e' and the d of the sampled times."""
    found = energies_batch(*arrays, dt=0.05, config=config, swept=False)
    return found.penetration, found.d


def swept(arrays: tuple[jax.Array, ...], config: EnergyConfig) -> Any:
    """All fields, with d and d0 swept."""
    return energies_batch(*arrays, dt=0.05, config=config)


def measure(cases: dict[str, tuple[Callable, tuple]], rounds: int = ROUNDS) -> list[dict]:
    """Compiles each case, then runs all of them in turns; ratios refer to the first case."""
    compiled, compile_s = {}, {}
    for name, (function, arguments) in cases.items():
        start = time.perf_counter()
        compiled[name] = jax.jit(function).lower(*arguments).compile()
        compile_s[name] = time.perf_counter() - start
        jax.block_until_ready(compiled[name](*arguments))
    seconds: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(rounds):
        for name, (_, arguments) in cases.items():
            start = time.perf_counter()
            jax.block_until_ready(compiled[name](*arguments))
            seconds[name].append(time.perf_counter() - start)
    base = np.array(seconds[next(iter(cases))])
    rows = []
    for name, values in seconds.items():
        q25, q50, q75 = 1e3 * np.quantile(values, [0.25, 0.5, 0.75])
        row = {"case": name, "median_ms": q50, "q25_ms": q25, "q75_ms": q75}
        row |= {"ratio": np.median(np.array(values) / base), "compile_s": compile_s[name]}
        rows.append({k: v if isinstance(v, str) else round(float(v), 3) for k, v in row.items()})
    return rows


@dataclass(frozen=True, kw_only=True)
class Config:
    """Settings."""

    rounds: int = ROUNDS
    """How often all cases are timed, in turns."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"rounds": 1}


def run(config: Config) -> Results:
    one, four = problem(), problem(4)
    overlap, paper = EnergyConfig(), EnergyConfig(form="paper", E_avoidance=0.5)
    rows = measure(
        {
            "bare pass": (bare, (one,)),
            "unswept e' and d": (partial(unswept, config=overlap), (one,)),
            "swept, overlap": (partial(swept, config=overlap), (one,)),
            "swept, paper": (partial(swept, config=paper), (one,)),
            "swept, 4 attack spheres": (partial(swept, config=overlap), (four,)),
        },
        config.rounds,
    )
    size = {"candidates": CANDIDATES, "times": TIMES, "spheres": SPHERES}
    lines = [f"{row['case']}: {row['median_ms']} ms, {row['ratio']} x a bare pass" for row in rows]
    return Results(metrics=size, timings={"rows": rows}, lines=tuple(lines))


if __name__ == "__main__":
    experiment(run, Config)
