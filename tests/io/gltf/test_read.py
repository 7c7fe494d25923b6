"""GLB files of other programs, against three.js and against cases worked by hand."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.core.errors import FileFormatError
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import validate_motion
from mgjax.core.skeleton import validate_skeleton
from mgjax.io.load import load_motion
from tests.io.gltf.made import Glb, armature, quaternions
from tests.io.three import seen_by_three

HALF = np.sqrt(0.5)


@pytest.fixture
def read(tmp_path):
    """Reads a made file; ``file.path`` is where it lies."""

    def run(file: Glb, **options):
        path = tmp_path / "made.glb"
        path.write_bytes(file.bytes())
        skeleton, motion = load_motion(path, **options)
        validate_skeleton(skeleton)
        validate_motion(skeleton, motion)
        return skeleton, motion

    return run


def same_as_three(path, skeleton, motion, *, tolerance=1e-3) -> None:
    got = global_positions(skeleton, motion)
    want = seen_by_three(path, skeleton.names, motion.num_frames, motion.frame_rate)
    np.testing.assert_allclose(got, want, atol=tolerance)


# --- worked by hand -------------------------------------------------------------------------


def two_bones(**root) -> Glb:
    """A root with a child 2 above it in the root's own frame, which turns about z by 90° in 1 s."""
    file = Glb()
    file.node("child", translation=np.array([0.0, 2.0, 0.0]))
    file.node("root", [0], **root)
    times = file.accessor([0.0, 1.0])
    turns = file.accessor([[0, 0, 0, 1], [0, 0, HALF, HALF]])
    file.animate((1, "rotation", times, turns, "LINEAR"))
    file.skin([1, 0])
    return file


def test_half_way_of_a_quarter_turn(read):
    file = two_bones()
    file.scene(1)
    skeleton, motion = read(file, frame_rate=2)
    assert (skeleton.names, skeleton.parents, skeleton.end_joints) == (
        ("root", "child"),
        (-1, 0),
        (1,),
    )
    assert (motion.num_frames, motion.frame_rate) == (3, 2.0)
    places = global_positions(skeleton, motion)[:, 1]
    # Turned by 0°, 45° and 90° towards −x.
    want = [[0, 2, 0], [-2 * HALF, 2 * HALF, 0], [-2, 0, 0]]
    np.testing.assert_allclose(places, want, atol=1e-6)


def test_an_armature_that_is_small_and_lies_is_folded_into_the_root(read):
    file = two_bones(translation=np.array([0.0, 0.0, 100.0]))
    # −90° about x turns +y into −z and +z into +y; lengths become hundredths.
    turn = np.array([-HALF, 0, 0, HALF])
    file.scene(file.node("Armature", [1], rotation=turn, scale=np.full(3, 0.01)))
    skeleton, motion = read(file, frame_rate=1)
    np.testing.assert_allclose(motion.root_translation, [[0, 1, 0]] * 2, atol=1e-6)
    np.testing.assert_allclose(skeleton.offsets, [[0, 1, 0], [0, 0, -0.02]], atol=1e-7)
    assert motion.joint_offsets is None
    np.testing.assert_allclose(motion.local_rotations[0], [[1, 0, 0, 0]] * 2, atol=1e-6)
    # In the armature's frame the child ends at −x, which the armature leaves where it is.
    places = global_positions(skeleton, motion)
    np.testing.assert_allclose(places[1, 1], [-0.02, 1, 0], atol=1e-6)


def test_rest_rotations_become_directions_of_offsets(read):
    # The root rests turned by 90° about z: its child lies at −x of it. Animated to the identity,
    # the child is above: in our terms the root has turned by −90°.
    file = two_bones(rotation=np.array([0, 0, HALF, HALF]))
    file.scene(1)
    skeleton, motion = read(file, frame_rate=1)
    np.testing.assert_allclose(skeleton.offsets[1], [-2, 0, 0], atol=1e-6)
    np.testing.assert_allclose(motion.local_rotations[0, 0], [HALF, 0, 0, -HALF], atol=1e-6)
    np.testing.assert_allclose(motion.local_rotations[1, 0], [1, 0, 0, 0], atol=1e-6)
    places = global_positions(skeleton, motion)[:, 1]
    np.testing.assert_allclose(places, [[0, 2, 0], [-2, 0, 0]], atol=1e-6)


def test_a_file_in_centimetres_needs_its_unit(read):
    file = two_bones(translation=np.array([0.0, 100.0, 0.0]))
    file.json["nodes"][0]["translation"] = [0.0, 50.0, 0.0]
    file.scene(1)
    skeleton, motion = read(file, frame_rate=1, units="cm")
    np.testing.assert_allclose(skeleton.offsets[1], [0, 0.5, 0], atol=1e-7)
    np.testing.assert_allclose(motion.root_translation, [[0, 1, 0]] * 2, atol=1e-7)
    with pytest.raises(FileFormatError, match="offset of 50 m"):
        read(file)


def moved(file: Glb, values, kind: str, times=(0.0, 1.0, 2.0)) -> Glb:
    """A single joint whose place has these keys."""
    node = file.node("only")
    file.animate((node, "translation", file.accessor(times), file.accessor(values), kind))
    file.skin([node])
    file.scene(node)
    return file


def test_steps_hold(read):
    _, motion = read(moved(Glb(), [[0, 0, 0], [1, 0, 0], [5, 0, 0]], "STEP"), frame_rate=2)
    np.testing.assert_array_equal(motion.root_translation[:, 0], [0, 0, 1, 1, 5])


def test_splines_take_their_tangents(read):
    # From 0 to 1 in 2 s, leaving with 3/s and arriving with 0: at the middle, h = 1/2, the Hermite
    # weights are 1/2, 1/8 · 2 s, 1/2: 0.5·0 + 0.125·2·3 + 0.5·1 = 1.25.
    keys = [[[0, 0, 0], [0, 0, 0], [3, 0, 0]], [[0, 0, 0], [1, 0, 0], [0, 0, 0]]]
    file = moved(Glb(), np.reshape(keys, (6, 3)), "CUBICSPLINE", (0.0, 2.0))
    _, motion = read(file, frame_rate=1)
    np.testing.assert_allclose(motion.root_translation[:, 0], [0, 1.25, 1], atol=1e-6)


def test_before_the_first_key_the_first_value_holds(read):
    file = moved(Glb(), [[1, 0, 0], [2, 0, 0], [3, 0, 0]], "LINEAR", (1.0, 2.0, 3.0))
    _, motion = read(file, frame_rate=1)
    np.testing.assert_allclose(motion.root_translation[:, 0], [1, 1, 2, 3])


def test_sparse_values_replace_some(read):
    file = moved(Glb(), np.zeros((3, 3)), "LINEAR")
    where, what = np.array([1], "<u2"), np.array([[7, 8, 9]], "<f4")
    file.json["accessors"][1]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": file.view(where), "componentType": 5123},
        "values": {"bufferView": file.view(what)},
    }
    _, motion = read(file, frame_rate=1)
    np.testing.assert_array_equal(motion.root_translation, [[0, 0, 0], [7, 8, 9], [0, 0, 0]])
    del file.json["accessors"][1]["bufferView"]  # then all others are zero
    _, motion = read(file, frame_rate=1)
    np.testing.assert_array_equal(motion.root_translation, [[0, 0, 0], [7, 8, 9], [0, 0, 0]])


@pytest.mark.parametrize("kind", ["i1", "u1", "i2", "u2"])
def test_normalised_integers_are_divided(read, kind):
    file = Glb()
    node = file.node("only")
    most = np.iinfo(kind).max
    turns = file.accessor([[0, 0, 0, most], [most, 0, 0, 0]], kind, normalized=True)
    file.animate((node, "rotation", file.accessor([0.0, 1.0]), turns, "LINEAR"))
    file.skin([node])
    file.scene(node)
    _, motion = read(file, frame_rate=1)
    np.testing.assert_allclose(
        motion.local_rotations[:, 0], [[1, 0, 0, 0], [0, 1, 0, 0]], atol=1e-7
    )


def test_strided_values(read):
    file = moved(Glb(), np.zeros((3, 3)), "LINEAR")
    rows = np.arange(18, dtype="<f4").reshape(3, 6)
    view = file.view(rows, byteStride=24)
    file.json["accessors"][1] |= {"bufferView": view, "byteOffset": 4}
    _, motion = read(file, frame_rate=1)
    np.testing.assert_array_equal(motion.root_translation, rows[:, 1:4])


# --- rates ----------------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [24.0, 25.0, 30.0, 29.97, 60.0, 120.0, 23.976])
def test_keys_on_a_grid_tell_the_rate(read, rate):
    times = np.delete(np.arange(900), [3, 4, 5, 700]) / rate  # programs leave keys out
    values = np.random.default_rng(0).normal(size=(len(times), 3))
    _, motion = read(moved(Glb(), values, "LINEAR", times))
    assert motion.frame_rate == pytest.approx(rate, rel=1e-5)
    assert motion.frame_rate == rate or rate in (29.97, 23.976)
    assert motion.num_frames == 900
    np.testing.assert_allclose(motion.root_translation[6:700], values[3:697], atol=1e-6)


@pytest.mark.parametrize("times", [(0.0, 1.0, 2.0), (0.0, 0.5123, 2.0), (0.0, 0.0007, 2.0)])
def test_other_keys_are_sampled_at_30(read, times):
    _, motion = read(moved(Glb(), np.eye(3), "LINEAR", times))
    assert (motion.frame_rate, motion.num_frames) == (30, 61)


# --- what three.js sees ---------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_an_armature_as_three_sees_it(read, tmp_path, seed):
    skeleton, motion = read(armature(seed))
    assert skeleton.names[0] == "mixamorig:Hips"
    assert "Surface" not in skeleton.names
    assert skeleton.end_joints == (skeleton.index("mixamorig:HeadTop_End"),)
    assert (motion.frame_rate, motion.num_frames) == (24, 20)
    same_as_three(tmp_path / "made.glb", skeleton, motion)
    skeleton, motion = read(armature(seed), frame_rate=50)
    same_as_three(tmp_path / "made.glb", skeleton, motion)


@pytest.mark.parametrize("change", ["matrices", "uneven", "moving", "growing", "mirrored"])
def test_any_transforms_as_three_sees_them(read, tmp_path, change):
    rng = np.random.default_rng(7)
    file = armature(5)
    nodes = file.json["nodes"]
    armature_node = next(n for n in nodes if n["name"] == "Armature")
    if change == "matrices":
        for node in nodes[-1:]:  # an animated node may not have one
            matrix = np.diag([0.02, 0.02, 0.02, 1.0])
            matrix[:3, :3] = matrix[:3, :3] @ [[0, 0, 1], [1, 0, 0], [0, 1, 0]]
            matrix[:3, 3] = 1, 2, 3
            for key in ("translation", "rotation", "scale"):
                del node[key]
            node["matrix"] = matrix.T.reshape(-1).tolist()
    elif change == "uneven":
        armature_node["scale"] = [0.01, 0.02, 0.015]
        nodes[1]["scale"] = [1.0, 1.5, 0.5]
    elif change == "mirrored":
        armature_node["scale"] = [-0.01, 0.01, 0.01]
    else:
        path = "translation" if change == "moving" else "scale"
        values = rng.uniform(0.5, 2, size=(20, 3))
        times = file.accessor(np.arange(20) / 24)
        animation = file.json["animations"][0]
        for node in (1, len(nodes) - 1):
            animation["samplers"].append({"input": times, "output": file.accessor(values)})
            sampler = len(animation["samplers"]) - 1
            target = {"node": node, "path": path}
            animation["channels"].append({"sampler": sampler, "target": target})
    skeleton, motion = read(file)
    assert (motion.joint_offsets is None) == (change == "matrices")
    same_as_three(tmp_path / "made.glb", skeleton, motion)


def test_splines_as_three_sees_them(read, tmp_path):
    rng = np.random.default_rng(3)
    file = Glb()
    file.node("tip", translation=np.array([0.0, 1.0, 0.0]), rotation=quaternions(rng))
    file.node("base", [0], rotation=quaternions(rng))
    times = file.accessor([0.0, 0.3, 1.1, 2.0])
    turns = rng.normal(size=(12, 4))
    turns[1::3] = quaternions(rng, 4)
    file.animate(
        (1, "rotation", times, file.accessor(turns), "CUBICSPLINE"),
        (1, "translation", times, file.accessor(rng.normal(size=(12, 3))), "CUBICSPLINE"),
    )
    file.skin([1, 0])
    file.scene(1)
    same_as_three(tmp_path / "made.glb", *read(file))


# --- which nodes are a skeleton -------------------------------------------------------------


def test_an_avatar_with_hair_and_several_meshes(read, tmp_path):
    """As VRM's: two skins, the smaller of hair; bones that no skin has; meshes beside them."""
    file = armature(2)
    nodes = file.json["nodes"]
    hair = file.node("hair", [file.node("hair_tip", translation=np.array([0.0, -9.0, 0.0]))])
    hat = file.node("hat", mesh=0)
    eye = file.node("eye")
    nodes[2]["children"] += [hair, hat, eye]
    corners = file.accessor(np.eye(3), min=[0.0] * 3, max=[1.0] * 3)
    file.json["meshes"] = [{"primitives": [{"attributes": {"POSITION": corners}}]}]
    file.skin([hair, hair - 1])
    file.json["extensionsUsed"] = ["VRMC_vrm"]
    file.json["extensions"] = {"VRMC_vrm": {"specVersion": "1.0"}}
    skeleton, motion = read(file)
    assert {"hair", "hair_tip", "eye"} < set(skeleton.names)
    assert not {"hat", "Surface", "Armature"} & set(skeleton.names)
    same_as_three(tmp_path / "made.glb", skeleton, motion)


def test_a_target_beside_the_skeleton_is_left_out(read):
    file = armature(0)
    target = file.node("ik_target")
    file.json["nodes"][-2]["children"].append(target)
    file.json["skins"][0]["joints"].append(target)
    skeleton, _ = read(file)
    assert skeleton.names[0] == "mixamorig:Hips"
    assert "ik_target" not in skeleton.names


def test_without_a_skin_the_animated_nodes_count(read, tmp_path):
    file = armature(1)
    del file.json["skins"]
    skeleton, motion = read(file)
    assert skeleton.num_joints == 6
    same_as_three(tmp_path / "made.glb", skeleton, motion)


def test_without_an_animation_it_rests(read):
    file = armature(1)
    del file.json["animations"]
    skeleton, motion = read(file)
    assert (motion.num_frames, motion.frame_rate, skeleton.end_joints) == (1, 30, ())
    np.testing.assert_allclose(motion.local_rotations[0], [[1, 0, 0, 0]] * 6, atol=1e-6)


def test_the_first_animation_that_moves_the_skeleton_counts(read):
    file = armature(1)
    prop = file.node("prop")
    times = file.accessor([0.0, 9.0])
    animation = file.json["animations"].pop()
    file.animate((prop, "translation", times, file.accessor(np.ones((2, 3))), "LINEAR"))
    file.json["animations"].append(animation)
    assert read(file)[1].num_frames == 20


def test_names_are_made_unique(read):
    file = Glb()
    tips = [file.node(name) for name in ("a", "a", None)]
    root = file.node("a", tips)
    file.skin([root, *tips])
    file.scene(root)
    assert read(file)[0].names == ("a", "a_2", "a_3", "node_2")
