"""The graph of made clips, built once."""

from __future__ import annotations

import pytest

from mgjax.clips.types import Clip, Label
from mgjax.graph.build import build_graph
from mgjax.graph.types import MotionGraph
from tests.graph.made import made_clips

ClipsAndLabels = tuple[list[Clip], dict[str, tuple[Label, ...]]]


@pytest.fixture(scope="package")
def made() -> ClipsAndLabels:
    return made_clips()


@pytest.fixture(scope="package")
def made_graph(made: ClipsAndLabels) -> MotionGraph:
    return build_graph(made[0], labels=made[1])
