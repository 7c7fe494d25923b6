"""Graphs that are built once: of made clips, and of real capture."""

from __future__ import annotations

from pathlib import Path

import pytest

from mgjax.clips.folder import load_clips
from mgjax.clips.labels import load_labels
from mgjax.clips.types import Clip, Label
from mgjax.graph.build import build_graph
from mgjax.graph.types import MotionGraph
from tests.graph.made import made_clips

ClipsAndLabels = tuple[list[Clip], dict[str, tuple[Label, ...]]]


@pytest.fixture(scope="session")
def made() -> ClipsAndLabels:
    return made_clips()


@pytest.fixture(scope="session")
def made_graph(made: ClipsAndLabels) -> MotionGraph:
    return build_graph(made[0], labels=made[1])


@pytest.fixture(scope="session")
def real(capture: Path) -> ClipsAndLabels:
    """The clips of real avoidance and their labels."""
    folder = capture / "avoidance"
    clips, _ = load_clips(folder, exclude=["bvh_converted/*"])
    return clips, load_labels(folder / "labels.json", clips, folder)


@pytest.fixture(scope="session")
def real_graph(real: ClipsAndLabels) -> MotionGraph:
    """The graph of all real avoidance clips at default settings."""
    return build_graph(real[0], labels=real[1])
