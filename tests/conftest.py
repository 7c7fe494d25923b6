"""Every test runs with shapes and types checked, strict promotion and a persistent cache.

Memory is bounded after each test, and the graph of real capture is built once in a process.
"""

# ruff: noqa: E402  (the hook must be installed before the imports)

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")  # before anything imports jax

if "mgjax" in sys.modules:
    raise RuntimeError("mgjax was imported before its import hook: shapes would go unchecked")
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from tests import hook

hook.install()

import hypothesis
import jax
import numpy as np
import pytest

from mgjax.clips.folder import load_clips
from mgjax.clips.labels import load_labels
from mgjax.clips.types import Clip, Label
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.compilation import enable_cache
from mgjax.graph.build import build_graph
from mgjax.graph.types import MotionGraph
from tests import memory

enable_cache()
memory.collect_seldom()
jax.config.update("jax_numpy_rank_promotion", "raise")
jax.config.update("jax_numpy_dtype_promotion", "strict")

hypothesis.settings.register_profile(
    "local",
    deadline=None,
    max_examples=20,
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)
hypothesis.settings.register_profile(
    "ci", parent=hypothesis.settings.get_profile("local"), derandomize=True, database=None
)
hypothesis.settings.load_profile("ci" if os.environ.get("CI") else "local")

ROOT = Path(__file__).resolve().parent.parent


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup() -> None:
    hook.begin_test()


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown() -> None:
    memory.bound()


@pytest.fixture(scope="session")
def capture() -> Path:
    """The folder of real capture with its MANIFEST.csv.

    ``MGJAX_CAPTURE`` names it, relative to the repository. Without it the test is skipped, or
    fails where ``MGJAX_REQUIRE_CAPTURE=1`` says that it must run.
    """
    folder = (ROOT / os.environ.get("MGJAX_CAPTURE", "../shared/data")).resolve()
    if (folder / "MANIFEST.csv").is_file():
        return folder
    reason = f"no MANIFEST.csv in {folder}; set MGJAX_CAPTURE to the folder of real capture"
    if os.environ.get("MGJAX_REQUIRE_CAPTURE") == "1":
        pytest.fail(reason)
    print(reason)
    pytest.skip(reason)


@pytest.fixture(scope="session")
def real(capture: Path) -> tuple[list[Clip], dict[str, tuple[Label, ...]]]:
    """The clips of real avoidance and their labels."""
    folder = capture / "avoidance"
    clips, _ = load_clips(folder, exclude=["bvh_converted/*"])
    return clips, load_labels(folder / "labels.json", clips, folder)


@pytest.fixture(scope="session")
def real_graph(real: tuple[list[Clip], dict[str, tuple[Label, ...]]]) -> MotionGraph:
    """The graph of all real avoidance clips at default settings."""
    return build_graph(real[0], labels=real[1])


def make_skeleton() -> Skeleton:
    """A symmetric body of 15 joints, 1.6 m tall, with names that have roles; two are end joints."""
    table = [
        ("root", -1, (0.0, 0.0, 0.0)),
        ("thorax", 0, (0.0, 0.30, 0.02)),
        ("head", 1, (0.0, 0.25, 0.0)),
        ("lfemur", 0, (0.1, -0.05, 0.0)),
        ("ltibia", 3, (0.0, -0.45, 0.0)),
        ("lfoot", 4, (0.0, -0.45, 0.0)),
        ("ltoes", 5, (0.0, -0.05, 0.15)),
        ("rfemur", 0, (-0.1, -0.05, 0.0)),
        ("rtibia", 7, (0.0, -0.45, 0.0)),
        ("rfoot", 8, (0.0, -0.45, 0.0)),
        ("rtoes", 9, (0.0, -0.05, 0.15)),
        ("lhumerus", 1, (0.2, 0.1, 0.0)),
        ("lhumerus_end", 11, (0.3, 0.0, 0.0)),
        ("rhumerus", 1, (-0.2, 0.1, 0.0)),
        ("rhumerus_end", 13, (-0.3, 0.0, 0.0)),
    ]
    return Skeleton(
        names=tuple(name for name, _, _ in table),
        parents=tuple(parent for _, parent, _ in table),
        offsets=np.array([offset for _, _, offset in table], np.float32),
        end_joints=(12, 14),
    )


def make_motion(
    skeleton: Skeleton, frames: int = 8, *, seed: int = 0, frame_rate: float = 120.0
) -> Motion:
    """Uniformly random rotations and root places within 2 m; end joints have the identity."""
    rng = np.random.default_rng(seed)
    rotations = rng.normal(size=(frames, skeleton.num_joints, 4))
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    rotations[:, list(skeleton.end_joints)] = (1, 0, 0, 0)
    return Motion(
        root_translation=rng.uniform(-2, 2, size=(frames, 3)).astype(np.float32),
        local_rotations=rotations.astype(np.float32),
        frame_rate=frame_rate,
    )


@pytest.fixture(scope="session")
def body() -> Skeleton:
    """A small symmetric body; see :func:`make_skeleton`."""
    return make_skeleton()


@pytest.fixture(scope="session")
def random_motion() -> Callable[..., Motion]:
    """``random_motion(skeleton, frames=8, *, seed=0, frame_rate=120.0)``."""
    return make_motion
