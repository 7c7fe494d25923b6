"""The installed jax computes what it says.

jax 0.10.2 (and 0.11.1) miscompile vmapped matrix-vector products followed by a reduction on CPU
(jax issue 39103): the results are wrong without any error. pyproject.toml excludes both; this is
the reproducer, so that a version with the fault never passes.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

# The fault shows only above a size: 32,769 products of 3×3 in the report.
BATCHES = [1, 33, 1000, 16_385, 32_769, 65_537]


def squares(product):
    return jnp.sum(product**2)


def problem(size: int, batch: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(size)
    matrix = np.eye(size) + rng.normal(size=(size, size)) * 0.1
    return matrix, rng.normal(size=(batch, size)) + np.arange(batch)[:, None] / 100


@pytest.mark.parametrize("batch", BATCHES)
@pytest.mark.parametrize("size", [3, 4])
def test_one_matrix_and_many_vectors(size, batch):
    matrix, rows = problem(size, batch)
    fixed = jnp.asarray(matrix, "float32")
    run = jax.jit(jax.vmap(lambda row: squares(fixed @ row)))
    want = ((rows @ matrix.T) ** 2).sum(axis=-1)
    np.testing.assert_allclose(run(rows.astype(np.float32)), want, rtol=1e-4, atol=1e-3)


@pytest.mark.xfail(
    jax.__version__ in ("0.10.1", "0.10.2"),
    reason="jax 0.10.1 has the fault too where the reduction is linear: 3-vectors, and between"
    " 32,769 and 43,690 of them; write such a product for the whole batch, as the next test does",
)
@pytest.mark.parametrize("reduce", [jnp.sum, jnp.max])
def test_one_matrix_and_many_vectors_with_a_linear_reduction(reduce):
    matrix, rows = problem(3, 32_769)
    fixed = jnp.asarray(matrix, "float32")
    run = jax.jit(jax.vmap(lambda row: reduce(fixed @ row)))
    want = getattr(rows @ matrix.T, reduce.__name__)(axis=-1)
    np.testing.assert_allclose(run(rows.astype(np.float32)), want, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize("batch", BATCHES)
@pytest.mark.parametrize("reduce", [jnp.sum, jnp.max])
def test_a_product_for_the_whole_batch(reduce, batch):
    matrix, rows = problem(3, batch)
    fixed = jnp.asarray(matrix, "float32")
    run = jax.jit(lambda all_rows: reduce(all_rows @ fixed.T, axis=-1))
    want = getattr(rows @ matrix.T, reduce.__name__)(axis=-1)
    np.testing.assert_allclose(run(rows.astype(np.float32)), want, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize("batch", [1, 33, 32_769])
@pytest.mark.parametrize("size", [(3, 3), (4, 7)])
def test_a_matrix_for_each_vector(size, batch):
    rng = np.random.default_rng(size[0] * 1000 + batch)
    matrices = rng.normal(size=(batch, *size))
    vectors = rng.normal(size=(batch, size[1]))
    run = jax.jit(jax.vmap(lambda matrix, vector: squares(matrix @ vector)))
    want = (np.einsum("bij,bj->bi", matrices, vectors) ** 2).sum(axis=-1)
    got = run(matrices.astype(np.float32), vectors.astype(np.float32))
    np.testing.assert_allclose(got, want, rtol=1e-4, atol=1e-3)


def test_the_reproducer_as_reported():
    count = 32_769
    i = jnp.arange(count, dtype="float32")
    rows = jnp.stack((i, jnp.zeros_like(i), jnp.zeros_like(i)), axis=1)
    matrix = jnp.eye(3, dtype="float32")
    got = jax.jit(jax.vmap(lambda row: jnp.sum((matrix @ row) ** 2)))(rows)
    np.testing.assert_allclose(got, np.arange(count, dtype=np.float64) ** 2, rtol=1e-6)


def test_strict_promotion_is_on():
    with pytest.raises(ValueError, match="rank"):
        jnp.zeros((2, 3)) + jnp.zeros(3)
    with pytest.raises(jax.dtypes.TypePromotionError):
        jnp.zeros(3, "float32") + jnp.zeros(3, "int32")
