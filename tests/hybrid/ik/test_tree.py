from __future__ import annotations

import jax
import numpy as np
import pytest

from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core import kinematics, quaternion
from mgjax.core.body.joint_limits import clamp, joint_limits, random_rotations
from mgjax.core.errors import SkeletonError
from mgjax.core.skeleton import Skeleton
from mgjax.hybrid import LIMBS, NOT_CONVERGED, REACHED, UNREACHABLE_FAR, find_limb, reach_pose
from mgjax.hybrid.ik.limbs import steady_joints
from mgjax.hybrid.ik.pose import moved_joints
from mgjax.hybrid.ik.rotations import chain_rotations
from mgjax.hybrid.ik.tree import fabrik_tree
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import load_motion

FRAMES = 16


@pytest.fixture(scope="module")
def skeleton() -> Skeleton:
    return synthetic_skeleton()


@pytest.fixture(scope="module")
def poses(skeleton) -> tuple[np.ndarray, np.ndarray]:
    """Poses near the rest pose, anywhere."""
    rng = np.random.default_rng(0)
    axes = rng.normal(size=(FRAMES, skeleton.num_joints, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    local = quaternion.from_axis_angle(axes, rng.normal(scale=0.3, size=axes.shape[:2]))
    local[:, list(skeleton.end_joints)] = (1, 0, 0, 0)
    return rng.uniform(-2, 2, (FRAMES, 3)).astype(np.float32), local.astype(np.float32)


def limbs_of(skeleton: Skeleton, *names: str):
    return tuple(find_limb(skeleton, name) for name in names)


def places(skeleton, roots, local):
    return kinematics.forward(skeleton, roots, np.asarray(local))


def near(skeleton, poses, limbs, spread: float = 0.1) -> np.ndarray:
    """Targets nearer to the base than the ends are now."""
    joints, _ = places(skeleton, *poses)
    rng = np.random.default_rng(1)
    base = joints[:, limbs[0].joints[0]]
    found = []
    for limb in limbs:
        moved = joints[:, limb.joints[-1]] + rng.normal(scale=spread, size=(FRAMES, 3))
        way = moved - base
        now = np.linalg.norm(way, axis=-1, keepdims=True)
        found.append(base + way * np.minimum(1, 0.9 * limb.reach_m / now))
    return np.stack(found, axis=1).astype(np.float32)


def test_limbs(skeleton) -> None:
    limb = find_limb(skeleton, "right_hand")
    names = [skeleton.names[j] for j in limb.joints]
    assert names[:3] == ["lowerback", "upperback", "thorax"]
    assert names[-1] == "rfingers"
    assert len(names) == 9
    lengths = np.linalg.norm(np.asarray(skeleton.offsets)[list(limb.joints[1:])], axis=-1)
    assert limb.reach_m == pytest.approx(lengths.sum())
    steady = steady_joints(skeleton, (limb,))
    assert [skeleton.names[j] for j in steady] == ["lowerneck", "lclavicle"]
    with pytest.raises(SkeletonError, match="'tail', expected one of right_hand"):
        find_limb(skeleton, "tail")
    bare = Skeleton(names=("a", "b"), parents=(-1, 0), offsets=np.zeros((2, 3), np.float32))
    with pytest.raises(SkeletonError, match="found no joint for 'head'"):
        find_limb(bare, "head")


@pytest.mark.parametrize("name", LIMBS)
def test_one_limb_reaches_and_the_rest_stays(skeleton, poses, name) -> None:
    (limb,) = limbs_of(skeleton, name)
    targets = near(skeleton, poses, (limb,))
    local, status = reach_pose(skeleton, *poses, targets, limbs=(limb,))
    assert (np.asarray(status) == REACHED).all()
    old, old_turns = places(skeleton, *poses)
    new, new_turns = places(skeleton, poses[0], local)
    np.testing.assert_allclose(new[:, limb.joints[-1]], targets[:, 0], atol=1.5e-3)
    lengths = np.linalg.norm(np.asarray(skeleton.offsets), axis=-1)[1:]
    parents = list(skeleton.parents[1:])
    np.testing.assert_allclose(
        np.linalg.norm(new[:, 1:] - new[:, parents], axis=-1), lengths[None].repeat(FRAMES, 0),
        atol=1e-5,
    )  # fmt: skip
    legs = [j for j, n in enumerate(skeleton.names) if n[1:] in ("femur", "tibia", "foot", "toes")]
    np.testing.assert_array_equal(new[:, legs], old[:, legs])
    for joint in steady_joints(skeleton, (limb,)):
        turned = quaternion.angle_between(old_turns[:, joint], new_turns[:, joint])
        assert turned.max() < 2e-3
    np.testing.assert_allclose(np.linalg.norm(local, axis=-1), 1, atol=1e-5)


def test_twist_is_kept(skeleton, poses) -> None:
    # A bone's turn in the world is a swing: its axis is square to the old bone.
    (limb,) = limbs_of(skeleton, "left_hand")
    local, _ = reach_pose(skeleton, *poses, near(skeleton, poses, (limb,)), limbs=(limb,))
    old, old_turns = places(skeleton, *poses)
    _, new_turns = places(skeleton, poses[0], local)
    for joint, child in zip(limb.joints[1:], limb.joints[2:], strict=False):
        bone = old[:, child] - old[:, joint]
        bone = bone / np.maximum(np.linalg.norm(bone, axis=-1, keepdims=True), 1e-9)
        back = quaternion.conjugate(old_turns[:, joint])
        turn = quaternion.multiply(new_turns[:, joint], back)
        if np.linalg.norm(np.asarray(skeleton.offsets)[child]) > 0:
            assert np.abs(np.sum(turn[:, 1:] * bone, axis=-1)).max() < 1e-3


def test_chain_rotations_by_hand(body) -> None:
    # thorax → left upper arm → its end: the arm points to +x and is to point up.
    chain = (1, 11, 12)
    rest = np.zeros((15, 4), np.float32)
    rest[:, 0] = 1
    root = np.zeros(3, np.float32)
    joints, _ = kinematics.forward(body, root, rest)
    wanted = joints[list(chain)]
    wanted[2] = wanted[1] + [0, 0.3, 0]
    local = chain_rotations(body, root, rest, chain, wanted)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(local[11], [half, 0, 0, half], atol=1e-6)
    others = np.delete(np.asarray(local), 11, axis=0)
    np.testing.assert_allclose(others, np.delete(rest, 11, axis=0), atol=1e-6)
    on_device = chain_rotations(body, *map(jax.numpy.asarray, (root, rest)), chain, wanted)
    np.testing.assert_allclose(on_device, local, atol=1e-6)


def test_both_hands_and_the_head_at_once(skeleton, poses) -> None:
    # Where the ends are in other poses, so that all can be met at once.
    limbs = limbs_of(skeleton, *LIMBS)
    other = np.roll(poses[1], 1, axis=0)
    other[:, 0] = poses[1][:, 0]
    targets = places(skeleton, poses[0], other)[0][:, [limb.joints[-1] for limb in limbs]]
    local, status = reach_pose(skeleton, *poses, targets, limbs=limbs)
    new, _ = places(skeleton, poses[0], local)
    ends = new[:, [limb.joints[-1] for limb in limbs]]
    met = np.linalg.norm(ends - targets, axis=-1) < 1.5e-3
    reached = np.asarray(status) == REACHED
    assert met[reached].all()
    assert reached.all(axis=1).mean() > 0.9
    one, one_status = reach_pose(skeleton, poses[0][3], poses[1][3], targets[3], limbs=limbs)
    np.testing.assert_allclose(one, local[3], atol=1e-4)
    assert one_status.shape == (3,)


def test_a_target_too_far_does_not_spoil_the_others(skeleton, poses) -> None:
    limbs = limbs_of(skeleton, *LIMBS)
    targets = near(skeleton, poses, limbs, spread=0.02)
    targets[:, 0] = poses[0] + np.array([-5, 0, 0], np.float32)
    _, status = reach_pose(skeleton, *poses, targets, limbs=limbs)
    status = np.asarray(status)
    assert (status[:, 0] == UNREACHABLE_FAR).all()
    assert (status[:, 1:] == REACHED).all()


def test_limbs_that_are_no_tree(skeleton, poses) -> None:
    hand = find_limb(skeleton, "left_hand")
    targets = np.zeros((FRAMES, 2, 3), np.float32)
    with pytest.raises(SkeletonError, match="each once"):
        reach_pose(skeleton, *poses, targets, limbs=(hand, hand))


@pytest.fixture(scope="module")
def arm() -> tuple:
    """Six joints along x: a ball, hinges and balls, the last one the end."""
    offsets = np.zeros((6, 3), np.float32)
    offsets[1:, 0] = (0.2, 0.25, 0.3, 0.25, 0.1)
    bones = np.repeat([[1.0, 0, 0]], 6, axis=0)
    ball = [-0.6, 0.8, -0.5, 0.9]
    limits = joint_limits(
        bones,
        swing=[ball, ball, [0, 2.2, 0, 0], ball, [-0.9, 0.9, 0, 0], [-3, 3, -3, 3]],
        twist=[[-0.3, 0.3], [-0.7, 0.7], [0, 0], [-0.5, 0.5], [0, 0], [-3, 3]],
        across=[[0, 0, 1.0]] * 6,
    )
    return offsets, limits, {"parents": (-1, 0, 1, 2, 3, 4), "ends": (5,)}


def ends_of(offsets: np.ndarray, local: np.ndarray) -> np.ndarray:
    count = len(offsets)
    chain = Skeleton(
        names=tuple("abcdef"[:count]), parents=tuple(range(-1, count - 1)), offsets=offsets
    )
    return kinematics.forward(chain, np.zeros((len(local), 3), np.float32), local)[0][:, -1]


def test_limits_are_kept_and_targets_inside_them_reached(arm) -> None:
    offsets, limits, tree = arm
    rng = np.random.default_rng(0)
    goal = ends_of(offsets, random_rotations(rng, 128, limits))[:, None]
    start = random_rotations(rng, 128, limits)
    base = np.zeros((128, 3), np.float32)
    found, status = fabrik_tree(offsets, base, start, goal, limits=limits, **tree)
    reached = np.asarray(status)[:, 0] == REACHED
    assert reached.all()
    found = np.asarray(found)
    np.testing.assert_allclose(ends_of(offsets, found)[reached], goal[reached, 0], atol=1.5e-3)
    moved = quaternion.angle_between(clamp(found, limits)[:, :-1], found[:, :-1])
    assert moved.max() < 2e-3
    # Straight back is within the length of the chain, but not within its limits.
    behind = np.repeat(np.array([[[-0.9, 0, 0]]], np.float32), 128, axis=0)
    _, status = fabrik_tree(offsets, base, start, behind, limits=limits, **tree)
    assert (np.asarray(status) == NOT_CONVERGED).all()


def hinges(*offsets: float, swing: list[list[float]]) -> tuple:
    """Bones along y that turn about z only, within ``swing``."""
    count = len(offsets)
    along = np.zeros((count, 3), np.float32)
    along[:, 1] = offsets
    limits = joint_limits(
        np.repeat([[0, 1.0, 0]], count, axis=0),
        swing=[[*row, 0, 0] for row in swing],
        twist=[[0, 0]] * count,
        across=[[0, 0, 1.0]] * count,
    )
    tree = {"parents": tuple(range(-1, count - 1)), "ends": (count - 1,)}
    return along, limits, tree


def identity(count: int, joints: int) -> np.ndarray:
    local = np.zeros((count, joints, 4), np.float32)
    local[..., 0] = 1
    return local


def test_a_straight_elbow_that_bends_to_one_side_by_hand() -> None:
    """Upper arm 0.6 m, forearm 0.8 m. From the straight arm that points at the target no step
    bends the elbow, which may only turn by positive angles.

    A shoulder at −s and an elbow at e put the hand at (0.6 sin s + 0.8 sin(s − e),
    0.6 cos s + 0.8 cos(s − e)).
    """
    offsets, limits, tree = hinges(0, 0.6, 0.8, swing=[[-np.pi / 2, np.pi / 2], [0, 2.356], [0, 0]])
    shoulder, elbow = np.radians(88), np.radians(49)
    goal = [0.6 * np.sin(shoulder) + 0.8 * np.sin(shoulder - elbow)]
    goal += [0.6 * np.cos(shoulder) + 0.8 * np.cos(shoulder - elbow), 0.0]
    goal = np.array([[goal]], np.float32)
    base = np.zeros((1, 3), np.float32)
    options = {"limits": limits, **tree}
    _, status = fabrik_tree(offsets, base, identity(1, 3), goal, max_starts=1, **options)
    assert np.asarray(status).tolist() == [[NOT_CONVERGED]]
    found, status = fabrik_tree(offsets, base, identity(1, 3), goal, **options)
    assert np.asarray(status).tolist() == [[REACHED]]
    turned = 2 * np.arctan2(np.asarray(found)[0, :2, 3], np.asarray(found)[0, :2, 0])
    np.testing.assert_allclose(turned, [-shoulder, elbow], atol=5e-3)


@pytest.mark.parametrize("joints", [3, 5])
def test_whatever_one_sided_limits_allow_is_reached(joints: int) -> None:
    """Half of the targets are ends of straight arms: there all bones lie at their limits."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        bones = [0.0, *rng.uniform(0.2, 0.8, joints - 1)]
        high = rng.uniform(0.7, 2.4, (joints, 1)) * [[0, 1]]
        offsets, limits, tree = hinges(*bones, swing=high.tolist())
        goal = ends_of(offsets, random_rotations(rng, 200, limits))[:, None]
        base = np.zeros((200, 3), np.float32)
        found, status = fabrik_tree(
            offsets, base, identity(200, joints), goal, limits=limits, **tree
        )
        assert (np.asarray(status) == REACHED).all()
        miss = np.linalg.norm(ends_of(offsets, np.asarray(found)) - goal[:, 0], axis=-1)
        assert miss.max() < 1.001e-3


@pytest.fixture(scope="module")
def two_arms() -> tuple:
    """A trunk of 0.5 m, and two arms of 0.3 and 0.25 m on it: joints 5 and 8 are the hands."""
    offsets = np.zeros((9, 3), np.float32)
    offsets[1:3, 1] = (0.3, 0.2)
    offsets[3:6, 0], offsets[6:9, 0] = (0.2, 0.3, 0.25), (-0.2, -0.3, -0.25)
    along = np.repeat([[1.0, 0, 0]], 9, axis=0)
    along[:3] = (0, 1, 0)
    along[6:] = (-1, 0, 0)
    trunk, arm, elbow = [-0.3, 0.3, -0.2, 0.4], [-1.2, 1.2, -0.9, 1.4], [-0.1, 2.3, 0, 0]
    limits = joint_limits(
        along,
        swing=[trunk, trunk, [-0.1, 0.1, -0.1, 0.1], arm, elbow, [0] * 4, arm, elbow, [0] * 4],
        twist=[[-0.3, 0.3]] * 3 + [[-0.8, 0.8], [0, 0], [0, 0]] * 2,
    )
    return offsets, limits, {"parents": (-1, 0, 1, 2, 3, 4, 2, 6, 7), "ends": (5, 8)}


def hands(offsets: np.ndarray, tree: dict, local: np.ndarray) -> np.ndarray:
    body = Skeleton(names=tuple("abcdefghi"), parents=tree["parents"], offsets=offsets)
    base = np.zeros((len(local), 3), np.float32)
    return np.asarray(kinematics.forward(body, base, local)[0][:, [5, 8]])


@pytest.mark.parametrize("limited", [True, False])
def test_of_two_targets_the_one_within_reach_is_reached(two_arms, limited: bool) -> None:
    offsets, limits, tree = two_arms
    rng = np.random.default_rng(2)
    goal = hands(offsets, tree, random_rotations(rng, 64, limits))
    base = np.zeros((64, 3), np.float32)
    use = limits if limited else None
    for out in (0, 1):
        targets = goal.copy()
        way = targets[:, out] / np.linalg.norm(targets[:, out], axis=-1, keepdims=True)
        targets[:, out] = 2.0 * way
        found, status = fabrik_tree(offsets, base, identity(64, 9), targets, limits=use, **tree)
        ends, status = hands(offsets, tree, np.asarray(found)), np.asarray(status)
        assert (status[:, out] == UNREACHABLE_FAR).all()
        assert (status[:, 1 - out] == REACHED).all()
        miss = np.linalg.norm(ends - targets, axis=-1)
        assert miss[:, 1 - out].max() < 1.001e-3
        # The other hand is stretched towards its target, as far as that allows.
        assert (miss[:, out] < 2.0 if limited else miss[:, out] < 1.3).all()


def test_of_two_targets_that_exclude_each_other_the_first_is_reached() -> None:
    """Two bones of 0.4 m on one of 0.5 m: both ends cannot be 1.8 m apart, but either at ±0.9."""
    offsets = np.array([[0, 0, 0], [0, 0.5, 0], [0.4, 0, 0], [-0.4, 0, 0]], np.float32)
    targets = np.array([[[0.85, 0, 0], [-0.85, 0, 0]]], np.float32)
    tree = {"parents": (-1, 0, 1, 1), "ends": (2, 3)}
    base = np.zeros((1, 3), np.float32)
    for swap in (slice(None), slice(None, None, -1)):
        _, status = fabrik_tree(offsets, base, identity(1, 4), targets[:, swap], **tree)
        assert np.asarray(status).tolist() == [[REACHED, NOT_CONVERGED]]


def test_more_starts_alone_and_in_a_batch_come_to_the_same(two_arms) -> None:
    offsets, limits, tree = two_arms
    rng = np.random.default_rng(3)
    goal = hands(offsets, tree, random_rotations(rng, 3, limits))
    goal[1, 0] = (3.0, 0, 0)

    def solve(base, local, targets):
        return fabrik_tree(offsets, base, local, targets, limits=limits, **tree)

    arrays = np.zeros((3, 3), np.float32), identity(3, 9), goal.astype(np.float32)
    together, statuses = solve(*arrays)
    mapped, mapped_statuses = jax.vmap(solve)(*arrays)
    np.testing.assert_allclose(mapped, together, atol=1e-4)
    for row in range(3):
        alone, status = solve(*(x[row] for x in arrays))
        np.testing.assert_allclose(alone, together[row], atol=1e-4)
        assert (status == statuses[row]).all()
        assert (mapped_statuses[row] == status).all()


def test_stages_alone_reach_without_limits(arm) -> None:
    offsets, limits, tree = arm
    rng = np.random.default_rng(1)
    goal = 0.8 * ends_of(offsets, random_rotations(rng, 128, limits))[:, None]
    start = random_rotations(rng, 128, limits)
    base = np.zeros((128, 3), np.float32)
    _, status = fabrik_tree(offsets, base, start, goal, max_iterations=64, max_steps=0, **tree)
    assert (np.asarray(status) == REACHED).mean() > 0.95


def test_the_result_is_written_and_read(skeleton, poses, tmp_path) -> None:
    from mgjax.core.motion import Motion

    (limb,) = limbs_of(skeleton, "right_hand")
    targets = near(skeleton, poses, (limb,))
    local, _ = reach_pose(skeleton, *poses, targets, limbs=(limb,))
    motion = Motion(root_translation=poses[0], local_rotations=np.asarray(local), frame_rate=30.0)
    save_bvh(tmp_path / "reach.bvh", skeleton, motion)
    again, read = load_motion(tmp_path / "reach.bvh")
    joints = kinematics.global_positions(again, read)
    end = again.index(skeleton.names[limb.joints[-1]])
    np.testing.assert_allclose(joints[:, end], targets[:, 0], atol=2e-3)


CAPTURED = (
    "locomotion/cmu16/16_08.amc",
    "locomotion/cmu131_bvh/131_01.bvh",
    "ball/cmu135_bvh/135_04.bvh",
)


@pytest.mark.parametrize(
    ("file", "name"),
    [
        # Each limb on one skeleton; every pair is a program of its own.
        pytest.param(file, name, marks=() if i == j else pytest.mark.long)
        for i, file in enumerate(CAPTURED)
        for j, name in enumerate(LIMBS)
    ],
)
def test_captured_skeletons(capture, file, name) -> None:
    skeleton, motion = load_motion(capture / file)
    roots = np.asarray(motion.root_translation[:FRAMES], np.float32)
    local = np.asarray(motion.local_rotations[:FRAMES], np.float32)
    for each in LIMBS:
        limb = find_limb(skeleton, each)
        assert moved_joints((limb,)) == limb.joints
    limb = find_limb(skeleton, name)
    targets = near(skeleton, (roots, local), (limb,))
    found, status = reach_pose(skeleton, roots, local, targets, limbs=(limb,))
    assert (np.asarray(status) == REACHED).all()
    joints, _ = places(skeleton, roots, found)
    np.testing.assert_allclose(joints[:, limb.joints[-1]], targets[:, 0], atol=1.5e-3)


@pytest.mark.long
def test_ends_follow_their_targets_forwards_and_backwards(skeleton, poses) -> None:
    # Where the ends are met, they move as the targets do, whatever the search did; a pose that
    # needs no search follows what it is given.
    limbs = limbs_of(skeleton, "left_hand", "right_hand")
    targets = near(skeleton, poses, limbs, 0.05)[0]
    root, local = poses[0][0], poses[1][0]

    def ends(targets, local):
        solved, status = reach_pose(skeleton, root, local, targets, limbs=limbs)
        joints, _ = kinematics.forward(skeleton, root, solved)
        return joints[np.array([limb.joints[-1] for limb in limbs])], status

    slopes, status = jax.jit(jax.jacrev(ends, argnums=(0, 1), has_aux=True))(targets, local)
    assert status.tolist() == [REACHED, REACHED]
    eye = np.eye(6).reshape(2, 3, 2, 3)
    np.testing.assert_allclose(slopes[0], eye, atol=1e-3)
    assert np.isfinite(slopes[1]).all()
    _, forwards, _ = jax.jit(
        lambda way: jax.jvp(lambda t: ends(t, local), (targets,), (way,), has_aux=True)
    )(np.ones_like(targets))
    np.testing.assert_allclose(forwards, np.ones((2, 3)), atol=1e-3)
    # Of several poses at once: each has the slopes of its own.
    batch = np.stack([targets, targets + np.float32(0.01)])
    many = jax.jit(jax.vmap(jax.grad(lambda t: ends(t, local)[0].sum())))(batch)
    np.testing.assert_allclose(many, np.ones((2, 2, 3)), atol=1e-3)


@pytest.mark.long
def test_slopes_are_finite_where_limits_and_length_stop_the_arms(skeleton, poses) -> None:
    limbs = limbs_of(skeleton, "left_hand", "right_hand")
    moved = moved_joints(limbs)
    bones = np.asarray(skeleton.offsets)[list(moved)]
    swing, twist = [(-0.5, 0.5, -0.5, 0.5)] * len(moved), [(-0.3, 0.3)] * len(moved)
    limits = joint_limits(bones, swing=swing, twist=twist)
    targets = near(skeleton, poses, limbs, 0.05)[0]
    root, local = poses[0][0], poses[1][0]

    def total(targets):
        solved, _ = reach_pose(skeleton, root, local, targets, limbs=limbs, limits=limits)
        joints, _ = kinematics.forward(skeleton, root, solved)
        return joints[np.array([limb.joints[-1] for limb in limbs])].sum()

    slope = jax.jit(jax.grad(total))
    for wanted in (targets, targets + 10, np.stack([root, root])):
        found = np.asarray(slope(wanted.astype(np.float32)))
        assert np.isfinite(found).all()
        assert (np.abs(found) < 10).all()
