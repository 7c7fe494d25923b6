"""One decorator that runs a law over batch shapes, and one check that all libraries agree."""

from __future__ import annotations

from collections.abc import Callable

import jax
import numpy as np
import pytest

over_batch_shapes = pytest.mark.parametrize("batch", [(), (1,), (3, 1, 2)], ids=str)


def unit_quaternions(batch: tuple[int, ...], seed: int = 0) -> np.ndarray:
    q = np.random.default_rng(seed).normal(size=(*batch, 4))
    return (q / np.linalg.norm(q, axis=-1, keepdims=True)).astype(np.float32)


def vectors(batch: tuple[int, ...], seed: int = 0, size: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(*batch, size)).astype(np.float32)


def scalars(batch: tuple[int, ...], seed: int = 0, low: float = -3, high: float = 3) -> np.ndarray:
    return np.asarray(np.random.default_rng(seed).uniform(low, high, size=batch), np.float32)


def assert_same_everywhere(function: Callable, *arrays: np.ndarray, atol: float = 2e-6) -> None:
    """NumPy, jax and jit agree, and so does vmap over the first axis where there is one."""
    want = jax.tree.map(np.asarray, function(*arrays))
    on_device = [jax.numpy.asarray(a) for a in arrays]
    runs = {"jit": jax.jit(function)(*on_device)}
    if arrays[0].ndim <= 1:  # eagerly only on the smallest: each shape is compiled op by op
        runs["jax"] = function(*on_device)
    if all(a.ndim > 1 and len(a) == len(arrays[0]) for a in arrays):
        runs["vmap"] = jax.jit(jax.vmap(function))(*on_device)
    for name, got in runs.items():
        for w, g in zip(jax.tree.leaves(want), jax.tree.leaves(got), strict=True):
            assert isinstance(g, jax.Array), name
            assert g.dtype == w.dtype, name
            np.testing.assert_allclose(g, w, atol=atol, err_msg=name)


def assert_finite_gradient(function: Callable, *arrays: np.ndarray) -> None:
    """Value and gradients with respect to every argument are finite."""

    def total(*args):
        leaves = jax.tree.leaves(function(*args))
        return sum(jax.numpy.sum(leaf * (1.0 + 0.5 * i)) for i, leaf in enumerate(leaves))

    numbers = tuple(range(len(arrays)))
    value, gradients = jax.jit(jax.value_and_grad(total, argnums=numbers))(
        *[jax.numpy.asarray(a, "float32") for a in arrays]
    )
    assert np.isfinite(value)
    for gradient in gradients:
        assert np.isfinite(gradient).all(), gradient
