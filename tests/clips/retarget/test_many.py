from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from mgjax.clips.prepare import prepare_clips
from mgjax.clips.retarget.body import make_body
from mgjax.clips.retarget.clip import Retargeted
from mgjax.clips.retarget.legs import PLANT_HEIGHT_M
from mgjax.clips.retarget.many import Retargeter, notes_on
from mgjax.clips.retarget.measure import foot_slide, outside_limits, path_error
from mgjax.clips.retarget.same import difference, same_build
from mgjax.clips.synthetic import synthetic_clips
from mgjax.clips.types import Clip, Label
from mgjax.core import quaternion
from mgjax.core.body.rest import standing_rest
from mgjax.core.errors import SkeletonError
from mgjax.core.kinematics import forward, global_positions
from mgjax.core.skeleton import Skeleton
from tests.clips.retarget.bodies import mixamo, turned_rest, xsens
from tests.sized import clips_of_size

MADE = {clip.name: clip for clip in synthetic_clips()[0]}
WALK = MADE["walk"]


def prepared(clips: list[Clip], labels=None, *, skeleton=WALK.skeleton, retarget=True):
    return prepare_clips(
        clips, labels or {}, skeleton=skeleton, frame_rate=30.0, mirrored=True, retarget=retarget
    )


def test_clips_of_four_skeletons_become_those_of_one():
    (small,) = clips_of_size([replace(MADE["duck"], name="small")], 0.8)
    other = [replace(mixamo(WALK), name="m"), replace(xsens(WALK), name="x"), small]
    labels = {"m": (Label(start_s=1.0, end_s=2.0, kind="step", direction="left"),)}
    made, notes = prepared([WALK, *other], labels)
    assert [c.name for c in made][:4] == ["walk", "m", "x", "small"]
    assert all(c.motion.local_rotations.shape[1] == WALK.skeleton.num_joints for c in made)
    np.testing.assert_array_equal(made[0].motion.local_rotations, WALK.motion.local_rotations)
    rows = [c.retargeted for c in made]
    assert [row.clip for row in rows if row] == ["m", "x", "small"]
    assert rows[0] is None
    assert rows[4:] == [None] * 4  # mirrored copies are not reported again
    assert rows[3] is not None
    assert rows[3].scale == pytest.approx(1.25, abs=0.01)
    assert [n.split(":")[0] for n in notes[:3]] == ["m", "x", "small"]
    assert "27 joints, scale 0.89; planted feet travel" in notes[0]
    np.testing.assert_array_equal(made[1].label_frames, [[30, 60]])
    # The planted foot of each walk is on the floor of its own.
    for clip in made[:3]:
        feet = [WALK.skeleton.index(n) for n in ("ltoes", "rtoes")]
        p = forward(WALK.skeleton, clip.motion.root_translation, clip.motion.local_rotations)[0]
        low = float(np.quantile(np.asarray(p)[:, feet, 1].min(axis=1), 0.05))
        assert abs(low - 0.02) < PLANT_HEIGHT_M / 3


def scaled(skeleton: Skeleton, factor: float) -> Skeleton:
    return replace(skeleton, offsets=np.asarray(skeleton.offsets) * np.float32(factor))


def test_without_retargeting_they_are_refused():
    with pytest.raises(SkeletonError, match=r"walk: got joint 'Pelvis' where .*'root'.*--retarget"):
        prepared([xsens(WALK)], retarget=False)
    # One hierarchy, but arms that hang in the rest pose.
    skeleton, motion = turned_rest(WALK.skeleton, WALK.motion, np.pi / 2)
    assert difference(WALK.skeleton, WALK.skeleton) is None
    turned = replace(WALK, name="t", skeleton=skeleton, motion=motion)
    hanging = hang(WALK.skeleton)
    assert difference(WALK.skeleton, hanging) == (
        "joint 'lradius' 90° away in the rest pose, seen from 'lhumerus', from where the reference"
        " has it"
    )
    with pytest.raises(SkeletonError, match=r"t: got joint 'lradius' 90° away .*--retarget"):
        prepared([replace(turned, skeleton=hanging, motion=WALK.motion)], retarget=False)


def hang(skeleton: Skeleton) -> Skeleton:
    offsets = np.array(skeleton.offsets)
    for side in "lr":
        for name in ("radius", "wrist"):
            joint = skeleton.index(side + name)
            offsets[joint] = [0, -np.linalg.norm(offsets[joint]), 0]
    return replace(skeleton, offsets=offsets)


def test_what_has_no_legs_is_refused():
    stump = Skeleton(names=("root", "head"), parents=(-1, 0), offsets=np.ones((2, 3), np.float32))
    motion = replace(WALK.motion, local_rotations=WALK.motion.local_rotations[:, :2])
    with pytest.raises(
        SkeletonError, match=r"stump: got .*no joint for 'left_hip'.*, expected legs"
    ):
        prepared([WALK, Clip(name="stump", skeleton=stump, motion=motion)])


def test_one_build():
    assert same_build(WALK.skeleton, scaled(WALK.skeleton, 1.0005))
    assert not same_build(WALK.skeleton, scaled(WALK.skeleton, 1.01))
    assert not same_build(WALK.skeleton, xsens(WALK).skeleton)
    ends = np.array(WALK.skeleton.offsets)
    ends[list(WALK.skeleton.end_joints)] *= 3
    assert same_build(WALK.skeleton, replace(WALK.skeleton, offsets=ends))


def test_clips_of_a_skeleton_are_treated_alike():
    """A clip that shows no feet on the floor takes what others of its skeleton show."""
    walk, still = xsens(WALK), xsens(MADE["duck"])
    still = replace(
        still,
        name="up",
        motion=replace(
            still.motion,
            root_translation=still.motion.root_translation + np.array([0, 0.5, 0], np.float32),
        ),
    )
    together = Retargeter(WALK.skeleton, [walk, still, WALK], 30.0)
    moved, row = together(still, still.motion, "up")
    assert row is not None
    assert row.frames == moved.num_frames
    assert together(WALK, WALK.motion, "walk") == (WALK.motion, None)
    alone = Retargeter(WALK.skeleton, [walk, WALK], 30.0)
    roots = [go(walk, walk.motion, "walk")[0].root_translation for go in (alone, together)]
    heights = [np.asarray(root)[:, 1].mean() for root in roots]
    # One height of the sole for both clips, the one between what each shows alone.
    assert heights[0] - heights[1] == pytest.approx(0.25 * row.scale, abs=0.02)


ROW = Retargeted(
    clip="a",
    joints=20,
    scale=0.9,
    frames=100,
    foot_slide_before_m=0.002,
    foot_slide_after_m=0.001,
    limits_before=1,
    limits_after=0,
    end_error_m=0.05,
    pelvis_lowered_m=0.0,
)


def test_notes():
    (note,) = notes_on([ROW])
    assert note == (
        "a: put on the skeleton from one of 20 joints, scale 0.90; planted feet travel 2.00 mm per"
        " frame as captured, 1.00 mm now; joints are beyond limits in 1 frames as captured, 0 now;"
        " hands, feet and head are 5.0 cm off on average"
    )
    assert len(notes_on([ROW] * 10)) == 10
    longer = replace(ROW, joints=30, scale=1.1, frames=300, end_error_m=0.09)
    (note,) = notes_on([ROW] * 10 + [longer] * 10)
    assert note.startswith("20 clips put on the skeleton from one of 20 … 30 joints, scale 0.90 … ")
    assert note.endswith(
        "in 20 frames as captured, 0 now; hands, feet and head are 8.0 cm off on average"
    )
    assert notes_on([]) == []
    assert asdict(ROW)["scale"] == 0.9


def test_measures_by_hand():
    feet = np.zeros((4, 2, 3))
    feet[:, 0, 0] = [0.0, 0.03, 0.03, 0.07]
    on = np.array([[True, False], [True, False], [True, True], [False, True]])
    assert foot_slide(feet, on) == pytest.approx(0.03 / 3)
    assert path_error(np.zeros((2, 1, 3)), np.array([[[3.0, 4.0, 0]], [[0, 0, 1.0]]])) == 3.0


@pytest.mark.parametrize(
    ("name", "axis", "degrees", "outside"),
    [
        ("ltibia", 0, 20.0, False),
        ("ltibia", 0, -5.0, False),
        ("ltibia", 0, -20.0, True),
        ("rtibia", 0, 150.0, False),
        ("rtibia", 0, 165.0, True),
        ("lradius", 1, -150.0, False),
        ("lradius", 1, -170.0, True),
        ("head", 1, 90.0, False),
        ("head", 1, 110.0, True),
        ("thorax", 0, 100.0, False),
        ("thorax", 0, 130.0, True),
    ],
)
def test_limits_by_hand(name, axis, degrees, outside):
    skeleton = WALK.skeleton
    local = np.zeros((1, skeleton.num_joints, 4))
    local[..., 0] = 1.0
    local[0, skeleton.index(name)] = quaternion.from_axis_angle(
        np.eye(3)[axis], np.array(np.radians(degrees))
    )
    body = make_body(skeleton)
    places, turns = (np.asarray(x) for x in forward(skeleton, np.zeros((1, 3)), local))
    assert outside_limits(body, places, turns).tolist() == [outside]


def test_an_example_shows_how_the_target_moves():
    """Bones along one axis: only motion tells how a foot stands and where a knee bends."""
    target = mixamo(WALK)
    rest = standing_rest(target.skeleton)
    assert rest is not None
    alone = Retargeter(rest.skeleton, [WALK], 30.0)
    shown = Retargeter(rest.skeleton, [WALK], 30.0, example=rest.motion(target.motion))
    want = np.asarray(global_positions(target.skeleton, target.motion))
    off = []
    for put in (alone, shown):
        moved, _ = put(WALK, WALK.motion, "walk")
        got = np.asarray(global_positions(rest.skeleton, moved))
        toes = [j for j, name in enumerate(target.skeleton.names) if "Toe" in name]
        off.append(np.linalg.norm(got - want, axis=-1)[:, toes].mean())
    assert off[1] < 0.004
    assert off[0] > 3 * off[1]
