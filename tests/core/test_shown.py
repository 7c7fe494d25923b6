import pickle
from dataclasses import replace

import jax
import numpy as np

from mgjax.core.motion import cut, mirror, resample, sample
from mgjax.core.shown import like, made_of, origin_of
from tests.conftest import make_motion, make_skeleton


def known():
    skeleton = make_skeleton()
    return skeleton, made_of(make_motion(skeleton, frames=20), skeleton)


def test_a_motion_remembers_its_skeleton():
    skeleton, motion = known()
    assert origin_of(motion) == (skeleton,)
    assert origin_of(make_motion(skeleton, frames=2)) is None


def test_what_keeps_the_skeleton_passes_it_on():
    skeleton, motion = known()
    for other in (
        cut(motion, 2, 9),
        resample(motion, 15.0),
        resample(motion, 17.0),
        sample(motion, np.array([0.5])),
        mirror(skeleton, motion),
    ):
        assert origin_of(other) == (skeleton,)


def test_it_is_no_part_of_the_pytree():
    skeleton, motion = known()
    plain = make_motion(skeleton, frames=20)
    assert jax.tree.structure(motion) == jax.tree.structure(plain)
    traces = []

    @jax.jit
    def shift(value):
        traces.append(1)
        return replace(value, root_translation=value.root_translation + 1)

    shift(motion)
    shift(plain)
    assert len(traces) == 1


def test_it_is_not_pickled_and_not_replaced():
    _, motion = known()
    assert origin_of(pickle.loads(pickle.dumps(motion))) is None
    assert origin_of(replace(motion, frame_rate=12.0)) is None
    back = pickle.loads(pickle.dumps(motion))
    np.testing.assert_array_equal(back.local_rotations, motion.local_rotations)
    assert back.frame_rate == motion.frame_rate


def test_like_something_unknown_is_unknown():
    skeleton, motion = known()
    plain = make_motion(skeleton, frames=2)
    assert origin_of(like(make_motion(skeleton, frames=3), plain)) is None
    assert origin_of(like(plain, motion)) == (skeleton,)
