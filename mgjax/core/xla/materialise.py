"""Stages: results that a compiled function computes once and keeps.

XLA for CPUs merges cheap operations into everything that reads them, and so computes them anew for
every reader; a barrier (``jax.lax.optimization_barrier``) is dropped before that. What one branch
of a conditional returns is not merged with what comes after it, and costs about 2 µs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import jax
import jax.numpy as jnp

from mgjax.core.arrays import Array

T = TypeVar("T")


def stage(there: Array, function: Callable[..., T], *operands: object) -> T:
    """``function(*operands)`` computed once, or zeros where ``there`` is false.

    Args:
        there: a scalar that is not known when the call is compiled, such as whether there is
            anything to do. Under ``vmap`` it has to be the same for all.
        function: returns a pytree of arrays.
        operands: pytrees of arrays; what ``function`` closes over need not be among them.
    """

    def nothing(*given: object) -> T:
        shapes = jax.eval_shape(function, *given)
        return jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), shapes)

    return jax.lax.cond(there, function, nothing, *operands)
