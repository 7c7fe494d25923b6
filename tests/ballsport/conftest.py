"""The clip set is built once for all tests of the room."""

from __future__ import annotations

from pathlib import Path

import pytest

from mgjax.ballsport.clipset.build import ClipSet, build_clip_set
from mgjax.ballsport.config import ClipSetConfig
from mgjax.clips.folder import load_clips

SMALL = ClipSetConfig(frame_rate=30.0)


@pytest.fixture(scope="package")
def made_set() -> ClipSet:
    """The embedded clips alone, at 30 Hz."""
    return build_clip_set(config=SMALL)


@pytest.fixture(scope="package")
def real_set(capture: Path) -> ClipSet:
    """With the captured kicks and their mirror images, at 30 Hz."""
    exclude = ("bvh_converted/*", "cmu135_bvh/*")
    clips, _ = load_clips(capture / "ball", exclude=exclude)
    return build_clip_set(clips, config=SMALL)
