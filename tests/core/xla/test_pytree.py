"""jax rebuilds pytrees from placeholders; the type checker must not see them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Float, TypeCheckError

from mgjax.core.arrays import Array
from mgjax.core.kinematics import forward, global_positions
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.pytree import register


@pytest.fixture(scope="module")
def pair(body, random_motion) -> tuple[Skeleton, Motion]:
    return jax.tree.map(jnp.asarray, (body, random_motion(body, 4)))


def test_the_hook_is_on(body):
    with pytest.raises(TypeCheckError):
        Skeleton(names=("a",), parents=(-1,), offsets=np.zeros((1, 2)))
    with pytest.raises(TypeCheckError):
        replace(body, names=list(body.names))


def test_static_and_traced_fields(pair):
    skeleton, motion = pair
    leaves, tree = jax.tree.flatten(skeleton)
    assert len(leaves) == 1
    again = jax.tree.unflatten(tree, leaves)
    assert (again.names, again.parents, again.end_joints) == (
        skeleton.names,
        skeleton.parents,
        skeleton.end_joints,
    )
    assert len(jax.tree.leaves(motion)) == 2
    assert jax.tree.structure(motion) != jax.tree.structure(replace(motion, frame_rate=30.0))
    paths = [jax.tree_util.keystr(p) for p, _ in jax.tree_util.tree_leaves_with_path(motion)]
    assert paths == [".root_translation", ".local_rotations"]


def test_placeholders_pass():
    tree = jax.tree.structure(
        Skeleton(names=("a",), parents=(-1,), offsets=np.zeros((1, 3), np.float32))
    )
    for placeholder in (None, object(), 3, "text"):
        assert jax.tree.unflatten(tree, [placeholder]).offsets is placeholder


def test_vmap_over_motions(pair):
    skeleton, motion = pair
    batch = jax.tree.map(lambda a: jnp.stack([a, a + 0]), motion)
    got = jax.jit(jax.vmap(global_positions, in_axes=(None, 0)))(skeleton, batch)
    np.testing.assert_allclose(got[1], global_positions(skeleton, motion), atol=1e-5)


def test_vmap_over_skeletons(pair):
    skeleton, motion = pair
    sizes = jnp.asarray([1.0, 2.0])
    skeletons = jax.vmap(lambda s: replace(skeleton, offsets=skeleton.offsets * s))(sizes)
    got = jax.jit(jax.vmap(global_positions, in_axes=(0, None)))(skeletons, motion)
    local = got - motion.root_translation[None, :, None]
    np.testing.assert_allclose(local[1], 2 * local[0], atol=1e-5)


def test_scan_carries_and_stacks(pair):
    skeleton, motion = pair

    def step(carry, frame):
        root, local = frame
        return replace(carry, offsets=carry.offsets * 1.0), forward(carry, root, local)[0]

    last, positions = jax.jit(
        lambda s, m: jax.lax.scan(step, s, (m.root_translation, m.local_rotations))
    )(skeleton, motion)
    np.testing.assert_allclose(positions, global_positions(skeleton, motion), atol=1e-5)
    assert last.names == skeleton.names


def test_eval_shape_and_cond(pair):
    skeleton, motion = pair
    shape = jax.eval_shape(global_positions, skeleton, motion)
    assert shape.shape == (4, skeleton.num_joints, 3)
    same = jax.eval_shape(lambda m: m, motion)
    assert same.local_rotations.shape == motion.local_rotations.shape
    chosen = jax.lax.cond(
        jnp.asarray(True),
        lambda m: m,
        lambda m: replace(m, root_translation=m.root_translation * 0),
        motion,
    )
    np.testing.assert_array_equal(chosen.root_translation, motion.root_translation)


def test_derivatives_with_respect_to_a_skeleton(pair):
    skeleton, motion = pair

    def last_joint(s):
        return global_positions(s, motion)[0, -1]

    forwards = jax.jit(jax.jacfwd(last_joint))(skeleton)
    backwards = jax.jit(jax.jacrev(last_joint))(skeleton)
    assert isinstance(forwards, Skeleton)
    np.testing.assert_allclose(forwards.offsets, backwards.offsets, atol=1e-5)
    # The hand moves with its own offset as the world rotation of its parent turns it.
    parent = skeleton.parents[-1]
    turn = forward(skeleton, motion.root_translation, motion.local_rotations)[1][0, parent]
    w, x, y, z = np.asarray(turn, np.float64)
    want = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]
    np.testing.assert_allclose(forwards.offsets[0, -1], want, atol=1e-5)


def test_register_keeps_the_order_of_static_fields():
    @register("label", "size")
    @dataclass(frozen=True, kw_only=True)
    class Thing:
        size: int
        values: Float[Array, " n"]
        label: str

    thing = Thing(size=3, values=np.zeros(2), label="x")
    again = jax.tree.map(lambda a: a + 1, thing)
    assert (again.size, again.label) == (3, "x")
    np.testing.assert_array_equal(again.values, [1, 1])
