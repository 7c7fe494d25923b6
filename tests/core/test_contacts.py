from __future__ import annotations

import jax
import numpy as np
import pytest

from mgjax.core.contacts import foot_joints, planted
from mgjax.core.errors import SkeletonError
from mgjax.core.skeleton import Skeleton


def test_planted_worked_by_hand():
    # 100 frames a second. Point 0 stands still on the floor, moves 0.1 m in one frame, stands
    # again; point 1 stands still, but 6 cm up.
    x = np.array([0, 0, 0, 0.1, 0.1, 0.1])
    positions = np.zeros((6, 2, 3))
    positions[:, 0, 0] = x
    positions[:, 1, 1] = 0.06
    # Central differences: frames 2 and 3 see the jump.
    want = np.array([True, True, False, False, True, True])
    got = planted(positions, 100.0)
    np.testing.assert_array_equal(got[:, 0], want)
    assert not got[:, 1].any()
    assert planted(positions, 100.0, height=0.07)[:, 1].all()
    assert planted(positions, 100.0, speed=10.1)[:, 0].all()


def test_the_bounds_are_5_cm_and_20_cm_a_second():
    positions = np.zeros((3, 2, 3))
    positions[:, 0, 0] = np.arange(3) * 0.00199  # 0.199 m/s
    positions[:, 1, 0] = np.arange(3) * 0.00201
    np.testing.assert_array_equal(planted(positions, 100.0), [[True, False]] * 3)
    positions = np.zeros((1, 2, 3))
    positions[0, :, 1] = 0.0499, 0.0501
    np.testing.assert_array_equal(planted(positions, 100.0), [[True, False]])


def test_jit_agrees():
    positions = np.random.default_rng(0).normal(size=(20, 3, 3)).astype(np.float32) * 0.01
    got = jax.jit(lambda p: planted(p, 30.0))(positions)
    np.testing.assert_array_equal(got, planted(positions, 30.0))


def test_foot_joints(body):
    assert foot_joints(body) == (body.index("ltoes"), body.index("rtoes"))
    trunk = Skeleton(names=body.names[:3], parents=body.parents[:3], offsets=body.offsets[:3])
    with pytest.raises(SkeletonError, match="left_ankle"):
        foot_joints(trunk)
