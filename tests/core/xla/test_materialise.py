from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from mgjax.core.xla.materialise import stage


def test_a_stage_changes_nothing() -> None:
    x = jnp.arange(6.0)

    def pair(values: jax.Array) -> dict[str, jax.Array]:
        return {"double": 2 * values, "sum": jnp.sum(values)}

    def staged(there: jax.Array, values: jax.Array) -> dict[str, jax.Array]:
        return stage(there, pair, values)

    wanted = pair(x)
    for call in (staged, jax.jit(staged)):
        got = call(jnp.asarray(True), x)
        np.testing.assert_array_equal(got["double"], wanted["double"])
        np.testing.assert_array_equal(got["sum"], wanted["sum"])
        nothing = call(jnp.asarray(False), x)
        assert not np.any(nothing["double"])
        assert nothing["sum"] == 0
    many = jnp.stack([x, x + 1])
    got = jax.vmap(staged, in_axes=(None, 0))(jnp.asarray(True), many)
    np.testing.assert_array_equal(got["double"], 2 * many)


def test_what_is_staged_is_computed_once() -> None:
    # Two readers of a product: without the stage the compiler puts it into both of them.
    def work(there: jax.Array, x: jax.Array) -> tuple[jax.Array, jax.Array]:
        product = stage(there, lambda x: jnp.sin(x) * jnp.cos(x), x)
        return product + 1, jnp.cumsum(product)

    text = jax.jit(work).lower(jnp.asarray(True), jnp.ones(512)).compile().as_text()
    assert text is not None
    assert text.count(" sine(") == 1
    assert "conditional" in text
