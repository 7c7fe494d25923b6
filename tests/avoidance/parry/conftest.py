from __future__ import annotations

import pytest

from mgjax.graph.types import MotionGraph
from tests.avoidance.parry.made import guarding_graph


@pytest.fixture(scope="package")
def guarding() -> MotionGraph:
    """A body that stands with hanging arms."""
    return guarding_graph()
