from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.core import quaternion
from mgjax.core.skeleton import Skeleton, rest_positions
from mgjax.io.skin.bones import body_capsules
from mgjax.io.skin.mesh import body_mesh
from tests.io.skeletons import CASES


@pytest.mark.parametrize("name", CASES)
def test_every_surface_is_closed_and_faces_outward(name):
    skeleton, _ = CASES[name]()
    body = body_mesh(skeleton)
    np.testing.assert_allclose(np.linalg.norm(body.normals, axis=1), 1, atol=1e-5)
    edges = np.concatenate([body.triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    forward = {tuple(edge) for edge in edges.tolist()}
    assert len(forward) == len(edges)  # each edge once in each direction: closed, oriented
    assert {(b, a) for a, b in forward} == forward
    corners = body.vertices[body.triangles].astype(np.float64)
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = body.normals[body.triangles].sum(axis=1)
    assert (np.sum(faces * outward, axis=1) >= -1e-12).all()
    assert 0 <= body.joints.min() <= body.joints.max() < skeleton.num_joints


def test_a_tapered_capsule_worked_by_hand():
    # Without a role a bone of 0.5 m has radii 0.16 · 0.5 and 0.8 of that, and ends in half balls.
    skeleton = Skeleton(
        names=("a", "b"), parents=(-1, 0), offsets=np.array([[0, 0, 0], [0, 0.5, 0]], np.float32)
    )
    (capsule,) = body_capsules(skeleton)
    np.testing.assert_allclose(capsule.radii, [0.08, 0.064])
    body = body_mesh(skeleton)
    assert body.vertices[:, 1].min() == pytest.approx(-0.08)
    assert body.vertices[:, 1].max() == pytest.approx(0.564)
    # All points lie on one of the balls; those between touch both tangents.
    low = np.linalg.norm(body.vertices, axis=1)
    high = np.linalg.norm(body.vertices - [0, 0.5, 0], axis=1)
    assert np.minimum(np.abs(low - 0.08), np.abs(high - 0.064)).max() < 1e-6
    assert (body.joints == 0).all()


def test_the_body_is_as_large_as_a_person():
    skeleton, _ = CASES["clip"]()
    body = body_mesh(skeleton)
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    joints = rest_positions(skeleton)
    height = joints[:, 1].max() - joints[:, 1].min()
    assert height < high[1] - low[1] < height + 0.1
    waist = body.vertices[np.abs(body.vertices[:, 1] - 0.15) < 0.04]
    assert 0.22 < np.ptp(waist[:, 0]) < 0.36  # wider than deep
    assert 0.14 < np.ptp(waist[:, 2]) < 0.24
    # Left and right are alike.
    mirrored = body.vertices * np.float32([-1, 1, 1])
    nearest = [np.abs(body.vertices - v).sum(axis=1).min() for v in mirrored[::37]]
    assert max(nearest) < 0.02


def test_a_rest_pose_with_all_bones_along_one_axis_gives_the_same_body():
    skeleton, _ = CASES["clip"]()
    flat, turns = _flat(skeleton)
    # In the flat rest pose joint j is turned by turns[j] from the usual one: turn its part back.
    want, got = body_mesh(skeleton), body_mesh(flat)
    places, lying = rest_positions(skeleton), rest_positions(flat)
    back = quaternion.conjugate(turns)[got.joints]
    vertices = places[got.joints] + quaternion.rotate(back, got.vertices - lying[got.joints])
    np.testing.assert_array_equal(got.joints, want.joints)
    trunk = np.isin(got.joints, [skeleton.index(n) for n in ("lowerback", "head")])
    for axis in range(3):
        a, b = vertices[trunk][:, axis], want.vertices[trunk][:, axis]
        np.testing.assert_allclose([a.min(), a.max()], [b.min(), b.max()], atol=0.03)


def _flat(skeleton: Skeleton) -> tuple[Skeleton, np.ndarray]:
    """The skeleton with its bones along x, and the rotation of each joint that lays it so."""
    turns = np.tile([1.0, 0, 0, 0], (skeleton.num_joints, 1))
    offsets = np.array(skeleton.offsets, np.float64)
    for joint in range(skeleton.num_joints):
        below = [c for c, p in enumerate(skeleton.parents) if p == joint]
        bones = [offsets[c] for c in below if np.linalg.norm(offsets[c]) > 1e-6]
        if len(below) == 1 and bones:
            turns[joint] = quaternion.from_two_vectors(bones[0], np.array([1.0, 0, 0]))
        elif joint:
            turns[joint] = turns[skeleton.parents[joint]]
    parents = np.maximum(np.array(skeleton.parents), 0)
    laid = np.asarray(quaternion.rotate(turns[parents], offsets))
    return replace(skeleton, offsets=laid.astype(np.float32)), turns


def test_a_child_has_thinner_limbs():
    skeleton, _ = CASES["clip"]()
    small = Skeleton(
        names=skeleton.names,
        parents=skeleton.parents,
        offsets=np.asarray(skeleton.offsets) * np.float32(0.5),
        end_joints=skeleton.end_joints,
    )
    for a, b in zip(body_capsules(skeleton), body_capsules(small), strict=True):
        np.testing.assert_allclose(b.radii, np.array(a.radii) / 2, rtol=1e-5)
