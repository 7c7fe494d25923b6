from __future__ import annotations

import pytest

from mgjax.graph.types import MotionGraph
from tests.avoidance.refinement.made import still_graph


@pytest.fixture(scope="package")
def still() -> MotionGraph:
    """A body that stands still."""
    return still_graph()
