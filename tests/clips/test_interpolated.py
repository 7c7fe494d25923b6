"""Clips between two clips, against poses that are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.clips.interpolated import AROUND_S, interpolated
from mgjax.clips.prepare import PreparedClip
from mgjax.clips.types import Label
from mgjax.core import planar
from mgjax.core.kinematics import forward, planar_frames
from mgjax.core.motion import Motion
from tests.conftest import make_skeleton

BODY = make_skeleton()
RATE = 30.0
SHOULDER = BODY.index("lhumerus")


def raised(angle: float, start: int, length: int, frames: int = 120) -> PreparedClip:
    """An arm that turns by an angle from ``start`` on within ``length`` frames, labelled there."""
    turn = 0.5 * angle * np.clip((np.arange(frames) - start) / length, 0, 1)
    rotations = np.tile(np.array([1, 0, 0, 0], np.float32), (frames, BODY.num_joints, 1))
    rotations[:, SHOULDER] = np.stack([np.cos(turn), 0 * turn, 0 * turn, np.sin(turn)], axis=1)
    root = np.tile(np.array([0, 1, 0], np.float32), (frames, 1))
    return PreparedClip(
        name=f"arm{angle}",
        motion=Motion(root_translation=root, local_rotations=rotations, frame_rate=RATE),
        label_frames=np.array([[start, start + length]]),
        labels=(Label(start_s=start / RATE, end_s=(start + length) / RATE, kind="duck"),),
    )


def elsewhere(clip: PreparedClip, place: tuple[float, float, float]) -> PreparedClip:
    """The same clip turned by an angle, rad, and moved over the floor."""
    rotations = np.array(clip.motion.local_rotations)
    root, rotations[:, 0] = planar.apply_pose(
        np.array(place), clip.motion.root_translation, rotations[:, 0]
    )
    root = np.asarray(root, np.float32)
    motion = replace(clip.motion, root_translation=root, local_rotations=rotations)
    return replace(clip, motion=motion, name=f"{clip.name} elsewhere")


def test_halfway_in_pose_and_in_time() -> None:
    parts = [raised(0.4, 40, 20), raised(0.8, 50, 28)]
    (found,) = interpolated(BODY, parts, most_m=0.5)
    around = round(AROUND_S * RATE)
    assert found.label_frames.tolist() == [[around, around + 24]]
    assert found.labels[0].kind == "duck"
    assert found.motion.num_frames == 2 * around + 24
    assert all(part.name in found.name for part in parts)
    half = 2 * np.arctan2(*found.motion.local_rotations[:, SHOULDER, [3, 0]].T)
    np.testing.assert_allclose(half[:around], 0.0, atol=1e-6)
    np.testing.assert_allclose(half[around + 12], 0.3, atol=1e-5)  # half of the way of each
    np.testing.assert_allclose(half[around + 24 :], 0.6, atol=1e-5)


def test_where_the_clips_were_captured_does_not_matter() -> None:
    first, second = raised(0.4, 40, 20), raised(0.8, 50, 28)
    (here,) = interpolated(BODY, [first, second], most_m=0.5)
    (there,) = interpolated(BODY, [first, elsewhere(second, (1.3, 4.0, -2.0))], most_m=0.5)
    for name in ("root_translation", "local_rotations"):
        values = getattr(here.motion, name), getattr(there.motion, name)
        np.testing.assert_allclose(*values, atol=1e-5)
    places, _ = forward(BODY, here.motion.root_translation, here.motion.local_rotations)
    middle = int(here.label_frames.mean())
    np.testing.assert_allclose(planar_frames(BODY, np.asarray(places)[middle]), 0.0, atol=1e-5)


@pytest.mark.parametrize(
    "other",
    [
        {"kind": "jump"},
        {"direction": "left"},
        {"genuine": False},
    ],
)
def test_only_parts_that_do_the_same(other: dict[str, object]) -> None:
    first, second = raised(0.4, 40, 20), raised(0.8, 50, 28)
    second = replace(second, labels=(replace(second.labels[0], **other),))
    assert interpolated(BODY, [first, second], most_m=0.5) == []


def test_only_parts_that_are_alike_each_with_the_nearest() -> None:
    parts = [raised(angle, 40, 20) for angle in (0.2, 0.3, 0.8)]
    found = interpolated(BODY, parts, most_m=0.5)
    pairs = [("arm0.2", "arm0.3"), ("arm0.3", "arm0.8")]
    assert [tuple(part.split("@")[0] for part in clip.name.split("~")) for clip in found] == pairs
    assert interpolated(BODY, parts, most_m=1e-4) == []
    longer = [raised(0.4, 40, 20), raised(0.4, 40, 31)]
    assert interpolated(BODY, longer, most_m=0.5) == []
