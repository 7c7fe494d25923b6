"""Files of AMASS: made here, and compared with the model's own equations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mgjax.core.errors import FileFormatError
from mgjax.core.kinematics import global_positions
from mgjax.core.skeleton import rest_positions
from mgjax.io.amass.hierarchy import NAMES, OFFSETS, PARENTS
from mgjax.io.amass.read import read_amass
from mgjax.io.load import load_motion
from mgjax.io.reading.read_as import ReadAs

Z_TO_Y_UP = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])


def save(path, width: int = 156, frames: int = 6, **more):
    """A file of random poses; returns its arrays."""
    rng = np.random.default_rng(width)
    arrays = {
        "poses": rng.normal(0, 0.7, (frames, width)),
        "trans": rng.normal(0, 1, (frames, 3)),
        "mocap_framerate": np.array(100.0),
        "betas": rng.normal(size=16),
        "gender": np.array("female"),
    }
    arrays = {k: v for k, v in (arrays | more).items() if v is not None}
    np.savez(path, **arrays)
    return arrays


def model_places(arrays: dict, joints: np.ndarray) -> np.ndarray:
    """[F,J,3] by 4×4 matrices as in SMPL's eq. 4, in AMASS' axes, then turned to y up."""
    count = len(joints)
    result = np.zeros((len(arrays["poses"]), count, 3))
    for f, pose in enumerate(arrays["poses"]):
        turns = Rotation.from_rotvec(pose[: 3 * count].reshape(-1, 3)).as_matrix()
        world = []
        for j in range(count):
            local = np.eye(4)
            local[:3, :3] = turns[j]
            local[:3, 3] = joints[j] - (joints[PARENTS[j]] if j else 0)
            world.append(world[PARENTS[j]] @ local if j else local)
            result[f, j] = world[j][:3, 3] + arrays["trans"][f]
    return result @ Z_TO_Y_UP.T


def rough_joints(count: int) -> np.ndarray:
    places = np.zeros((count, 3))
    for j in range(count):
        places[j] = OFFSETS[j] + (places[PARENTS[j]] if j else 0)
    return places


@pytest.mark.parametrize(("width", "joints"), [(66, 22), (72, 24), (156, 22), (165, 22)])
def test_places_are_those_of_the_model(tmp_path, width, joints):
    arrays = save(tmp_path / "x.npz", width)
    skeleton, motion = load_motion(tmp_path / "x.npz")
    assert skeleton.names == NAMES[:joints]
    assert motion.frame_rate == 100
    want = model_places(arrays, rough_joints(joints))
    np.testing.assert_allclose(global_positions(skeleton, motion), want, atol=1e-5)


def test_the_rest_pose_stands_upright(tmp_path):
    # AMASS turns the pelvis by 90° about x to stand a body up whose axes are y up.
    poses = np.zeros((1, 72))
    poses[0, 0] = np.pi / 2
    save(tmp_path / "x.npz", poses=poses, trans=np.array([[0.0, 0.0, 1.0]]))
    skeleton, motion = load_motion(tmp_path / "x.npz")
    np.testing.assert_allclose(motion.local_rotations[0], [[1, 0, 0, 0]] * 24, atol=1e-6)
    places = global_positions(skeleton, motion)[0]
    assert places[skeleton.index("head"), 1] - places[skeleton.index("left_foot"), 1] > 1.4
    assert places[skeleton.index("left_hand"), 0] > 0.5
    assert places[skeleton.index("left_foot"), 2] > places[skeleton.index("left_ankle"), 2]


def test_the_rough_adult_is_symmetric_and_of_usual_height():
    for j, name in enumerate(NAMES):
        if name.startswith("left"):
            twin = NAMES.index(name.replace("left", "right"))
            np.testing.assert_array_equal(OFFSETS[twin], OFFSETS[j] * [-1, 1, 1])
    heights = rough_joints(24)[:, 1]
    assert 1.4 < heights.max() - heights.min() < 1.65  # from the ball of the foot to the skull


def body(path, joints: int = 52, seed: int = 5, **more) -> dict:
    rng = np.random.default_rng(seed)
    parents = [2**32 - 1, *PARENTS[1:22], *range(20, 20 + joints - 22)]
    arrays = {
        "v_template": rng.normal(0, 0.5, (200, 3)),
        "J_regressor": rng.dirichlet(np.ones(200), joints),
        "shapedirs": rng.normal(0, 0.01, (200, 3, 10)),
        "kintree_table": np.array([parents, range(joints)], np.uint32),
        "dtype": np.array([{}], object),  # never looked at
    }
    arrays = {k: v for k, v in (arrays | more).items() if v is not None}
    path.parent.mkdir(exist_ok=True)
    np.savez(path, **arrays)
    return arrays


@pytest.mark.parametrize("shaped", [True, False])
def test_a_body_model_gives_the_lengths(tmp_path, shaped):
    arrays = save(tmp_path / "x.npz", betas=None if not shaped else np.arange(16) / 4)
    model = body(tmp_path / "body.npz")
    skeleton, motion = load_motion(
        tmp_path / "x.npz", read_as=ReadAs(body_model=tmp_path / "body.npz")
    )
    vertices = model["v_template"].copy()
    if shaped:
        vertices += np.einsum("vcb,b->vc", model["shapedirs"], np.arange(10) / 4)
    joints = (model["J_regressor"] @ vertices)[:22]
    np.testing.assert_allclose(rest_positions(skeleton), joints - joints[0], atol=1e-6)
    want = model_places(arrays, joints)
    np.testing.assert_allclose(global_positions(skeleton, motion), want, atol=1e-5)


def test_a_body_model_may_be_joints_alone(tmp_path):
    save(tmp_path / "x.npz")
    joints = rough_joints(24) * 1.1
    body(
        tmp_path / "body.npz", J_regressor=None, J=np.concatenate([joints[:22], np.zeros((30, 3))])
    )
    skeleton, _ = read_amass(tmp_path / "x.npz", body_model=tmp_path / "body.npz")
    np.testing.assert_allclose(skeleton.offsets[1:], OFFSETS[1:22] * 1.1, atol=1e-6)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"mocap_framerate": None}, "no array 'mocap_framerate'"),
        ({"poses": np.zeros((6, 100))}, "width 100, expected one of 66, 72, 156, 165"),
        ({"poses": np.zeros((6, 52, 3))}, r"\[6, 52, 3\]"),
        ({"trans": np.zeros((5, 3))}, r"'trans' of shape \[5, 3\]"),
        ({"trans": np.full((6, 3), np.nan)}, "NaN"),
        ({"trans": np.full((6, 3), 1e9)}, "too far"),
        ({"poses": np.zeros((0, 66)), "trans": np.zeros((0, 3))}, "no frames"),
        ({"mocap_framerate": np.array(-1.0)}, "frame rate is -1"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, more, words):
    save(tmp_path / "x.npz", **more)
    with pytest.raises(FileFormatError, match=words):
        load_motion(tmp_path / "x.npz")


def test_the_other_key_of_the_rate_and_a_stated_one(tmp_path):
    save(tmp_path / "x.npz", mocap_framerate=None, mocap_frame_rate=np.array(59.94))
    assert load_motion(tmp_path / "x.npz")[1].frame_rate == pytest.approx(59.94)
    assert load_motion(tmp_path / "x.npz", frame_rate=30)[1].frame_rate == 30
    save(tmp_path / "x.npz", mocap_framerate=None)
    assert load_motion(tmp_path / "x.npz", frame_rate=30)[1].frame_rate == 30


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"kintree_table": np.zeros((2, 52))}, "parents 0, 0.*expected those of SMPL"),
        ({"v_template": np.zeros((7, 3))}, r"v_template.*\[7, 3\]"),
        ({"J_regressor": np.array([{}], object)}, "pickle"),
        ({"J_regressor": None}, "no array 'J'"),
        ({"J_regressor": np.zeros((5, 200))}, "5 joints"),
    ],
)
def test_what_is_wrong_with_a_model_is_said(tmp_path, more, words):
    save(tmp_path / "x.npz")
    body(tmp_path / "body.npz", **more)
    with pytest.raises(FileFormatError, match=words):
        load_motion(tmp_path / "x.npz", read_as=ReadAs(body_model=tmp_path / "body.npz"))
