import numpy as np

from mgjax.core.motion import resample
from mgjax.stage.packet import pack, unpack
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.motion import motion_show
from mgjax.stage.show.types import Frames, show_value
from tests.conftest import make_motion, make_skeleton
from tests.io.skeletons import CASES


def played(frames: Frames) -> np.ndarray:
    """Rotations as the page reads them."""
    rotations = frames.rotations
    if frames.delta:
        rotations = np.cumsum(rotations, axis=0, dtype=np.int16)
    return rotations.astype(np.float64) / 32767


def test_poses_come_back_up_to_rounding():
    motion = make_motion(make_skeleton(), frames=40, frame_rate=120.0)
    kept = resample(motion, 30.0)
    frames = frames_of(motion)
    assert frames.rate == 30.0
    back = played(frames)
    off = np.minimum(
        np.abs(back - kept.local_rotations).max(axis=-1),
        np.abs(back + kept.local_rotations).max(axis=-1),
    )
    assert off.max() < 2e-4
    np.testing.assert_allclose(frames.root, kept.root_translation, atol=1e-4)


def test_signs_do_not_jump_between_frames():
    motion = make_motion(make_skeleton(), frames=40)
    flipped = np.array(motion.local_rotations)
    flipped[::2] *= -1
    back = played(frames_of(type(motion)(
        root_translation=motion.root_translation, local_rotations=flipped, frame_rate=30.0
    )))  # fmt: skip
    assert (np.einsum("fjx,fjx->fj", back[1:], back[:-1]) >= -1e-3).all()


def test_differences_say_the_same():
    motion = make_motion(make_skeleton(), frames=25)
    np.testing.assert_array_equal(played(frames_of(motion)), played(frames_of(motion, delta=False)))


def test_every_kind_of_skeleton_can_be_packed():
    for make in CASES.values():
        show = motion_show(*make())
        value = unpack(pack(show_value(show)))
        assert value["kind"] == "show"
        np.testing.assert_array_equal(
            value["actors"][0]["frames"]["rotations"], show.actors[0].frames.rotations
        )
