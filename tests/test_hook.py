"""The check of annotations that all tests run under is there, and in every test anew."""

from __future__ import annotations

import numpy as np
import pytest
from jaxtyping import TypeCheckError

from mgjax.core import quaternion
from tests import hook

WRONG = np.zeros(3)
"""No quaternion."""


def test_first_calls_are_checked_in_each_test() -> None:
    good = np.array([1.0, 0.0, 0.0, 0.0])
    for _ in range(2):
        hook.begin_test()
        with pytest.raises(TypeCheckError):
            quaternion.conjugate(WRONG)
        for _ in range(hook.MOST):
            quaternion.conjugate(good)
        quaternion.conjugate(WRONG)  # none of the first ones
