"""Motions that all measures are taken of."""

from __future__ import annotations

import pytest

from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from tests.quality.moving import moving


@pytest.fixture(scope="session")
def motions(body: Skeleton) -> list[Motion]:
    """Three of different lengths, at most one second."""
    return [moving(body, 0.7, 1), moving(body, 0.8, 2), moving(body, 1.0, 3)]
