from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core import quaternion
from mgjax.core.errors import SkeletonError
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton
from mgjax.graph.feet.blended import close_gaps, held_places, keep_plants, slide_per_frame
from mgjax.graph.feet.legs import foot_chains
from tests.conftest import make_motion
from tests.graph.made import BODY, bend, march

CHAINS = foot_chains(BODY)
LEFT, RIGHT = CHAINS.balls
clean = jax.jit(keep_plants, static_argnames=("chains",))


def path(*xz: tuple[float, float]) -> jnp.ndarray:
    """Places on the floor; the height tells the frame."""
    return jnp.array([[x, 0.01 * i, z] for i, (x, z) in enumerate(xz)], jnp.float32)


def line(count: int, step: float = 1.0) -> jnp.ndarray:
    return path(*((step * i, 0.0) for i in range(count)))


def held(ball: jnp.ndarray, planted: str) -> np.ndarray:
    return np.asarray(held_places(ball, jnp.array([c == "1" for c in planted])))


def ease(t: float) -> float:
    return 3 * t**2 - 2 * t**3


def test_nothing_planted_nothing_moves():
    ball = line(6)
    np.testing.assert_array_equal(held(ball, "000000"), ball)


def test_a_plant_from_the_beginning_stays_where_it_began():
    got = held(line(6), "111000")
    # Frames 1 and 2 go back to x = 0; then the shift of −2 m fades to none in the last frame.
    want = [0, 0, 0, 3 - 2 * (1 - ease(1 / 3)), 4 - 2 * (1 - ease(2 / 3)), 5]
    np.testing.assert_allclose(got[:, 0], want, atol=1e-6)


def test_a_plant_to_the_end_stands_where_it_ends():
    got = held(line(6), "000111")
    want = [0, 1 + 2 * ease(1 / 3), 2 + 2 * ease(2 / 3), 5, 5, 5]
    np.testing.assert_allclose(got[:, 0], want, atol=1e-6)


def test_a_plant_in_between_stands_in_its_middle():
    got = held(line(7), "0011100")
    want = [0, 1 + 1 * ease(0.5), 3, 3, 3, 5 - 1 * (1 - ease(0.5)), 6]
    np.testing.assert_allclose(got[:, 0], want, atol=1e-6)


def test_a_plant_throughout_goes_from_the_one_place_to_the_other():
    got = held(path((0, 0), (9, 9), (-4, 2), (7, 1), (4, 8)), "11111")
    share = np.array([ease(t) for t in (0, 0.25, 0.5, 0.75, 1)])
    np.testing.assert_allclose(got[:, 0], 4 * share, atol=1e-6)
    np.testing.assert_allclose(got[:, 2], 8 * share, atol=1e-6)


def test_two_plants():
    got = held(line(9), "110011100")
    # The first at 0 with shift −1 in frame 1, the second at 5 with shift +1 in frame 4, −1 in 6.
    want = [0, 0, 2 - 1 + 2 * ease(1 / 3), 3 - 1 + 2 * ease(2 / 3), 5, 5, 5, 7 - ease(0.5), 8]
    np.testing.assert_allclose(got[:, 0], want, atol=1e-6)


@pytest.mark.parametrize(
    ("planted", "longest", "want"),
    [
        ("110111", 1, "111111"),
        ("1001001", 1, "1001001"),
        ("1001001", 2, "1111111"),
        ("0110001", 1, "1110001"),
        ("0010000", 2, "1110000"),
        ("0000", 9, "0000"),
        ("1110", 0, "1110"),
        ("1000110", 1, "1000111"),
    ],
)
def test_short_gaps_are_closed(planted, longest, want):
    got = close_gaps(jnp.array([c == "1" for c in planted]), longest)
    assert "".join("01"[int(x)] for x in got) == want


def test_a_foot_does_not_jump_through_a_short_gap():
    # Twelve frames on a line, planted all the time but for the first frame, or one in the middle:
    # held at their means the plants would be metres apart from one frame to the next.
    for planted in ("011111111111", "111110111111", "111111111110", "011111011110"):
        steps = np.diff(held(line(12), planted)[:, 0])
        assert steps.max() < 1.7
        assert steps.min() >= 0


@given(st.integers(0, 10**6), st.lists(st.booleans(), min_size=12, max_size=12))
def test_plants_stand_ends_are_fixed_and_heights_kept(seed, planted):
    ball = np.random.default_rng(seed).normal(size=(12, 3)).astype(np.float32)
    got = np.asarray(held_places(jnp.asarray(ball), jnp.array(planted)))
    np.testing.assert_array_equal(got[[0, -1]], ball[[0, -1]])
    np.testing.assert_array_equal(got[:, 1], ball[:, 1])
    if not np.asarray(close_gaps(jnp.array(planted), 2)).all():
        for f in range(11):
            if planted[f] and planted[f + 1]:
                np.testing.assert_allclose(got[f, [0, 2]], got[f + 1, [0, 2]], atol=1e-5)


def test_slide_worked_by_hand():
    ball = path((0, 0), (3, 4), (3, 4), (4, 4))
    for planted, want in (("1111", 6), ("1100", 5), ("0011", 1), ("1010", 0), ("0000", 0)):
        got = slide_per_frame(ball, jnp.array([c == "1" for c in planted]))
        assert float(got) == pytest.approx(want / 3, abs=1e-6)


def slide(frames: int = 11, *, step: float = 0.01, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A body with bent knees that glides ahead as a whole: its feet slide by ``step`` a frame."""
    motion = march(frames, swing=0.0, seed=seed, noise=0.005)
    root, rotations = motion.root_translation.copy(), motion.local_rotations.copy()
    root[:, 2] += step * np.arange(frames)
    sway = 0.03 * np.sin(np.arange(frames) + seed)
    for side, more in (("l", 0.1), ("r", -0.1)):
        bend(rotations, f"{side}femur", -0.5 - more + sway)
        bend(rotations, f"{side}tibia", 1.0 + 2 * more - sway)
    return root, rotations


def run(root, rotations, left: str, right: str, skeleton: Skeleton = BODY):
    """Cleans all frames but the first, which is the one before the blend."""
    positions, _ = forward(skeleton, root, rotations)
    planted = jnp.array([[a == "1", b == "1"] for a, b in zip(left, right, strict=True)])
    new, metres = clean(
        skeleton,
        root=jnp.asarray(root[1:]),
        rotations=jnp.asarray(rotations[1:]),
        planted=planted,
        before=jnp.asarray(positions[0]),
        chains=foot_chains(skeleton),
    )
    after, _ = forward(skeleton, root[1:], np.asarray(new))
    return positions, np.concatenate([positions[:1], after]), np.asarray(new), np.asarray(metres)


def travelled(places: np.ndarray, planted: str) -> float:
    """Over the floor, between frames that are both planted, per step."""
    steps = np.linalg.norm(np.diff(places[:, [0, 2]], axis=0), axis=1)
    on = [a == b == "1" for a, b in zip(planted, planted[1:], strict=False)]
    return float(steps[on].sum() / len(steps))


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("11111100000", "00000111111"),
        ("00011110000", "11100000111"),
        ("11111110000", "11111110000"),
        ("00000000000", "00111111100"),
    ],
)
def test_planted_feet_slide_less(left, right):
    before, after, _, metres = run(*slide(), left, right)
    want = sum(travelled(before[:, ball], on) for ball, on in ((LEFT, left), (RIGHT, right)))
    left_over = sum(travelled(after[:, ball], on) for ball, on in ((LEFT, left), (RIGHT, right)))
    np.testing.assert_allclose(metres, [want, left_over], atol=1e-5)
    assert want > 0.004
    assert left_over < 0.02 * want
    # Heights of the balls and whatever is not a leg stay.
    np.testing.assert_allclose(after[:, [LEFT, RIGHT], 1], before[:, [LEFT, RIGHT], 1], atol=2e-4)
    legs = [j for j, name in enumerate(BODY.names) if name[1:] in ("tibia", "foot", "toes")]
    rest = [j for j in range(BODY.num_joints) if j not in legs]
    np.testing.assert_allclose(after[:, rest], before[:, rest], atol=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_bones_keep_their_lengths_and_feet_their_tilt(seed):
    root, rotations = slide(seed=seed)
    before, after, new, _ = run(root, rotations, "11111000111", "00011111000")
    assert np.abs(after - before).max() > 0.01
    for joint, parent in enumerate(BODY.parents):
        if parent >= 0:
            bone = np.linalg.norm(after[:, joint] - after[:, parent], axis=-1)
            np.testing.assert_allclose(bone, np.linalg.norm(BODY.offsets[joint]), atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(new, axis=-1), 1.0, atol=1e-5)
    foot = before[:, LEFT] - before[:, CHAINS.ankles[0]]
    np.testing.assert_allclose(after[:, LEFT] - after[:, CHAINS.ankles[0]], foot, atol=1e-5)


def test_the_pose_of_arrival_is_not_touched():
    root, rotations = slide()
    for planted in ("11111111111", "00000011111", "11111100000"):
        before, after, new, _ = run(root, rotations, planted, planted)
        np.testing.assert_array_equal(new[-1], rotations[-1])
        np.testing.assert_array_equal(after[-1], before[-1])
        # Nor does a foot jump anywhere: no step is longer than twice the longest of the slide.
        longest = np.linalg.norm(np.diff(before[:, [LEFT, RIGHT]], axis=0), axis=-1).max()
        steps = np.linalg.norm(np.diff(after[:, [LEFT, RIGHT]], axis=0), axis=-1)
        assert steps.max() < 2.5 * longest


def test_nothing_planted_changes_nothing():
    root, rotations = slide()
    _, _, new, metres = run(root, rotations, "0" * 11, "0" * 11)
    np.testing.assert_array_equal(new, rotations[1:])
    np.testing.assert_array_equal(metres, 0)


def test_a_single_planted_frame_has_nothing_to_slide():
    root, rotations = slide()
    _, _, new, metres = run(root, rotations, "00000100000", "0" * 11)
    np.testing.assert_array_equal(new, rotations[1:])
    np.testing.assert_array_equal(metres, 0)


@given(st.integers(0, 10**6))
def test_anything_stays_finite(seed):
    motion = make_motion(BODY, 11, seed=seed)
    rng = np.random.default_rng(seed)
    left, right = ("".join(map(str, rng.integers(0, 2, 11))) for _ in range(2))
    _, after, new, metres = run(motion.root_translation, motion.local_rotations, left, right)
    assert np.isfinite(after).all()
    assert np.isfinite(metres).all()
    np.testing.assert_allclose(np.linalg.norm(new, axis=-1), 1.0, atol=1e-4)


def test_chains():
    assert CHAINS.hips == (BODY.index("lfemur"), BODY.index("rfemur"))
    assert CHAINS.knees == (BODY.index("ltibia"), BODY.index("rtibia"))
    assert CHAINS.ankles == (BODY.index("lfoot"), BODY.index("rfoot"))
    assert CHAINS.balls == (BODY.index("ltoes"), BODY.index("rtoes"))
    whole = synthetic_skeleton()
    nameless = replace(whole, names=tuple(f"j{j}" for j in range(whole.num_joints)))
    assert foot_chains(nameless) == foot_chains(whole)
    trunk = Skeleton(names=("root", "spine"), parents=(-1, 0), offsets=BODY.offsets[:2])
    with pytest.raises(SkeletonError, match="left_hip"):
        foot_chains(trunk)


def with_a_joint_in_each_bone(skeleton: Skeleton) -> Skeleton:
    """A twist bone in the middle of each thigh and each shin."""
    names: list[str] = []
    parents: list[int] = []
    offsets: list[np.ndarray] = []
    for name, parent, offset in zip(
        skeleton.names, skeleton.parents, np.asarray(skeleton.offsets), strict=True
    ):
        above = names.index(skeleton.names[parent]) if parent >= 0 else -1
        if name[1:] in ("tibia", "foot"):
            names.append(f"{name}_twist")
            parents.append(above)
            offsets.append(offset / 2)
            above, offset = len(names) - 1, offset / 2
        names.append(name)
        parents.append(above)
        offsets.append(offset)
    return Skeleton(
        names=tuple(names),
        parents=tuple(parents),
        offsets=np.array(offsets, np.float32),
        end_joints=tuple(names.index(skeleton.names[j]) for j in skeleton.end_joints),
    )


@pytest.mark.parametrize("twisted", [False, True])
def test_joints_between_hip_knee_and_ankle(twisted):
    skeleton = with_a_joint_in_each_bone(BODY)
    chains = foot_chains(skeleton)
    same = [skeleton.index(name) for name in BODY.names]
    assert chains.knees == (skeleton.index("ltibia"), skeleton.index("rtibia"))
    root, rotations = slide()
    more = np.tile(np.float32([1, 0, 0, 0]), (len(rotations), skeleton.num_joints, 1))
    more[:, same] = rotations
    twists = [j for j, name in enumerate(skeleton.names) if name.endswith("_twist")]
    if twisted:  # about the bone: the joints below turn back
        for name in ("ltibia", "rtibia", "lfoot", "rfoot"):
            turn = np.float32([np.cos(0.3), 0, np.sin(0.3), 0])
            back = turn * np.float32([1, -1, -1, -1])
            more[:, skeleton.index(f"{name}_twist")] = turn
            joint = skeleton.index(name)
            more[:, joint] = quaternion.multiply(back, more[:, joint])
    want_before, want_after, _, want = run(root, rotations, "11111000111", "00011111000")
    before, after, new, metres = run(root, more, "11111000111", "00011111000", skeleton)
    np.testing.assert_allclose(before[:, same], want_before, atol=1e-5)
    np.testing.assert_allclose(after[:, same], want_after, atol=3e-4)
    np.testing.assert_allclose(metres, want, atol=1e-4)
    np.testing.assert_array_equal(new[:, twists], more[1:, twists])
