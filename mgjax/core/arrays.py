"""Array types, and which library computes.

The small geometry of ``core`` (quaternions, planar transforms, kinematics) is written once against
the array API: NumPy in gives NumPy out, with no compilation, which is what loaders and builders
want; a jax array or tracer in gives jax out, which is what jitted code wants.
"""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

if TYPE_CHECKING:
    Array = jax.Array | np.ndarray
else:
    Array = jax.Array | np.ndarray | np.generic  # what NumPy makes of a result of rank 0


def namespace(*arrays: Any) -> ModuleType:
    """``jax.numpy`` if any argument is a jax array or tracer, else ``numpy``."""
    if any(isinstance(a, jax.Array) for a in arrays):
        return jax.numpy
    return np
