from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.core.body.mirrored import mirror_joints
from mgjax.core.body.roles import find_role, require_roles
from mgjax.core.errors import MgjaxError, SkeletonError
from mgjax.core.skeleton import (
    MAX_DEPTH,
    Skeleton,
    depth_levels,
    first_difference,
    rest_positions,
    validate_skeleton,
)


def named(*names: str, parents: tuple[int, ...] | None = None) -> Skeleton:
    return Skeleton(
        names=names,
        parents=parents or (-1, *range(len(names) - 1)),
        offsets=np.full((len(names), 3), 0.1, np.float32),
    )


def unchecked(skeleton: Skeleton, **changes) -> Skeleton:
    result = object.__new__(Skeleton)
    for name, value in {**skeleton.__dict__, **changes}.items():
        object.__setattr__(result, name, value)
    return result


def test_rest_pose_worked_by_hand():
    skeleton = Skeleton(
        names=("root", "a", "b", "c"),
        parents=(-1, 0, 1, 0),
        offsets=np.array([[5.0, 5, 5], [0, 1, 0], [0, 1, 1], [0, -0.5, 0]]),
    )
    # The root stands at the origin whatever its offset.
    np.testing.assert_allclose(
        rest_positions(skeleton), [[0] * 3, [0, 1, 0], [0, 2, 1], [0, -0.5, 0]]
    )


def test_depth_levels():
    assert depth_levels((-1, 0, 1, 0, 3, 2)) == ((0,), (1, 3), (2, 4), (5,))
    assert depth_levels((-1,)) == ((0,),)
    chain = (-1, *range(20_000))
    assert len(depth_levels(chain)) == 20_001  # in linear time


def test_index(body):
    assert body.names[body.index("lfoot")] == "lfoot"
    with pytest.raises(SkeletonError, match="no joint 'tail'; joints are root, thorax"):
        body.index("tail")


def test_validate(body):
    validate_skeleton(body)
    far, nan = body.offsets.copy(), body.offsets.copy()
    far[3, 1], nan[4, 2] = -10.5, np.nan
    deep = named(*(f"j{j}" for j in range(MAX_DEPTH + 1)))
    cases = [
        (replace(body, names=("lfoot", *body.names[1:])), "two joints are called 'lfoot'"),
        (unchecked(body, offsets=body.offsets[:5]), "15 names, 15 parents and offsets of shape"),
        (unchecked(body, parents=body.parents[:5]), "15 names, 5 parents"),
        (replace(body, parents=(0, *body.parents[1:])), "first joint must be the root"),
        (replace(body, parents=(-1, 2, 0, *body.parents[3:])), "'thorax' has parent 2"),
        (replace(body, parents=(-1, -1, *body.parents[2:])), "'thorax' has parent -1"),
        (replace(body, offsets=far), "'lfemur' has offset .* at most 10 m"),
        (replace(body, offsets=nan), "'ltibia' has offset"),
        (deep, "nested more than 256 deep"),
    ]
    for wrong, message in cases:
        with pytest.raises(SkeletonError, match=message) as error:
            validate_skeleton(wrong)
        assert "\n" not in str(error.value)
        assert isinstance(error.value, MgjaxError)


def test_first_difference(body):
    assert first_difference(body, body) is None
    longer = replace(body, offsets=body.offsets * 2)
    assert first_difference(body, longer) is None
    renamed = replace(body, names=(*body.names[:4], "shank", *body.names[5:]))
    assert "'shank' where the reference has 'ltibia'" in str(first_difference(body, renamed))
    moved = replace(body, parents=(*body.parents[:7], 1, *body.parents[8:]))
    assert "hangs on 'thorax'" in str(first_difference(body, moved))
    shorter = Skeleton(names=body.names[:12], parents=body.parents[:12], offsets=body.offsets[:12])
    assert "only the reference has joint 'lhumerus_end'" in str(first_difference(body, shorter))
    assert "the reference lacks joint 'lhumerus_end'" in str(first_difference(shorter, body))


@pytest.mark.parametrize(
    ("role", "names"),
    [
        ("left_hip", ["lfemur", "lThigh", "LeftUpLeg", "mixamorig:LeftUpLeg", "LeftHip"]),
        ("left_knee", ["ltibia", "lShin", "LeftLeg", "Left_Knee"]),
        ("right_ankle", ["rfoot", "rFoot", "RightFoot", "RightAnkle"]),
        ("right_toe", ["rtoes", "RightToeBase", "RightToe"]),
        ("left_elbow", ["lradius", "lForeArm", "LeftForeArm"]),
        ("head", ["head", "Head", "mixamorig:Head"]),
    ],
)
def test_roles_by_name(role, names):
    for name in names:
        assert find_role(named("hips", "other", name), role) == 2


def test_roles(body):
    assert find_role(body, "root") == 0
    assert find_role(body, "left_elbow") is None
    assert require_roles(body, ("left_knee", "right_toe")) == (4, 10)
    with pytest.raises(SkeletonError, match="'right_hand'"):
        require_roles(body, ("left_knee", "right_hand"))
    with pytest.raises(KeyError):
        find_role(body, "left_wing")


def test_twins(body):
    twins = mirror_joints(body)
    pairs = {body.names[a]: body.names[b] for a, b in enumerate(twins)}
    assert pairs["lfemur"] == "rfemur"
    assert pairs["rhumerus_end"] == "lhumerus_end"
    assert pairs["root"] == "root"
    assert [twins[t] for t in twins] == list(range(body.num_joints))
    others = named("Hips", "LeftArm", "RightArm", "lowerback", "rtail", "mixamorig:LeftLeg")
    assert mirror_joints(others) == (0, 2, 1, 3, 4, 5)
