from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mgjax.avoidance.body.spheres import PRESET_HEIGHT_M, preset_spheres, sphere_centres
from mgjax.clips.synthetic import synthetic_skeleton
from mgjax.core.body.height import body_height
from mgjax.core.body.mirrored import mirror_joints
from mgjax.core.errors import SkeletonError
from mgjax.core.skeleton import Skeleton, rest_positions
from mgjax.io.load import load_motion
from tests.reference import avoidance as reference

CAPTURES = [
    "avoidance/cmu14/14_02.amc",
    "avoidance/cmu127/127_29.amc",
    "avoidance/cmu49/49_02.amc",
    "avoidance/bvh_converted/14_02.bvh",
    "avoidance/bvh_converted/127_29.bvh",
    "ball/cmu10/10_03.amc",
    "ball/cmu135/135_04.amc",
    "ball/bvh_converted/10_03.bvh",
    "ball/cmu135_bvh/135_04.bvh",
    "locomotion/cmu16/16_17.amc",
    "locomotion/cmu131_bvh/131_01.bvh",
]
LOOSE = ("thumb", "finger", "index", "middle", "ring", "pinky", "hand", "_end", "palm", "buttock")
"""Joints of hands, and ends of bones, which need not be covered."""


def check_preset(skeleton: Skeleton) -> None:
    spheres = preset_spheres(skeleton)
    assert len(spheres.names) == len(set(spheres.names)) == len(spheres.radii) == 30
    assert (spheres.radii > 0.02).all()
    assert (spheres.radii < 0.25).all()
    assert (spheres.share >= 0).all()
    beyond = [n for n, share in zip(spheres.names, spheres.share, strict=True) if share > 1]
    assert all("head_end" in name or "hand" in name for name in beyond)
    places = rest_positions(skeleton)
    centres = np.asarray(sphere_centres(spheres, places))
    np.testing.assert_allclose(
        centres, reference.sphere_places(spheres.first, spheres.second, spheres.share, places)
    )
    # Each joint of the body lies in a sphere or at most 12 cm beside one.
    for joint, name in enumerate(skeleton.names):
        if joint in skeleton.end_joints or any(word in name.lower() for word in LOOSE):
            continue
        gap = np.linalg.norm(centres - places[joint], axis=1) - spheres.radii
        assert gap.min() < 0.12, (name, gap.min())
    # From head to foot without a gap through which a ball of 12 cm would go.
    for height in np.linspace(places[:, 1].min() + 0.05, places[:, 1].max() - 0.05, 60):
        assert (np.abs(centres[:, 1] - height) < spheres.radii + 0.12).any(), height


@pytest.mark.parametrize("name", CAPTURES)
def test_captured_skeletons(capture: Path, name: str) -> None:
    check_preset(load_motion(capture / name)[0])


def test_made_skeleton() -> None:
    check_preset(synthetic_skeleton())


def test_symmetric() -> None:
    skeleton = synthetic_skeleton()
    spheres = preset_spheres(skeleton)
    twins = mirror_joints(skeleton)
    found = {
        (a, b, round(float(share), 6), round(float(radius), 6))
        for a, b, share, radius in zip(
            spheres.first.tolist(),
            spheres.second.tolist(),
            spheres.share,
            spheres.radii,
            strict=True,
        )
    }
    assert found == {(twins[a], twins[b], share, radius) for a, b, share, radius in found}
    centres = np.asarray(sphere_centres(spheres, rest_positions(skeleton)))
    mirrored = sorted((centres * (-1, 1, 1)).round(5).tolist())
    np.testing.assert_allclose(mirrored, sorted(centres.round(5).tolist()), atol=2e-5)


def test_scales_with_the_body() -> None:
    skeleton = synthetic_skeleton()
    large = replace(skeleton, offsets=np.asarray(skeleton.offsets) * np.float32(1.5))
    a, b = preset_spheres(skeleton), preset_spheres(large)
    np.testing.assert_allclose(b.radii, 1.5 * a.radii, rtol=1e-5)
    np.testing.assert_array_equal(b.share, a.share)
    height = body_height(skeleton)
    assert height == pytest.approx(1.7, abs=0.08)
    head = a.radii[a.names.index("head-head_end 0.50")]
    np.testing.assert_allclose(head, 0.115 * height / PRESET_HEIGHT_M, rtol=1e-5)


def test_a_head_without_an_end_is_above_its_joint() -> None:
    skeleton = synthetic_skeleton()
    spheres = preset_spheres(skeleton)
    shorter = np.array(skeleton.offsets)
    shorter[skeleton.index("head_end")] = 0
    without = preset_spheres(replace(skeleton, offsets=shorter))
    top = spheres.names.index("head-head_end 0.50")
    places = rest_positions(skeleton)
    with_end = np.asarray(sphere_centres(spheres, places))[top]
    centre = np.asarray(sphere_centres(without, places))[top]
    head = places[skeleton.index("head")]
    assert centre[1] - head[1] == pytest.approx(0.09, abs=0.01)  # half a head of 18 cm
    assert np.linalg.norm(centre - with_end) < 0.04


def test_missing_roles_are_named(body: Skeleton) -> None:
    with pytest.raises(SkeletonError, match=r"neck|elbow|wrist") as caught:
        preset_spheres(body)
    assert "\n" not in str(caught.value)
    legless = Skeleton(names=body.names[:3], parents=body.parents[:3], offsets=body.offsets[:3])
    with pytest.raises(SkeletonError, match="left_hip"):
        preset_spheres(legless)


def test_a_rest_pose_that_lies_changes_nothing() -> None:
    skeleton = synthetic_skeleton()
    flat = np.zeros_like(skeleton.offsets)
    flat[:, 0] = np.linalg.norm(skeleton.offsets, axis=1)  # all bones along x
    np.testing.assert_allclose(
        preset_spheres(replace(skeleton, offsets=flat)).radii,
        preset_spheres(skeleton).radii,
        rtol=1e-5,
    )


def test_batches_of_poses() -> None:
    skeleton = synthetic_skeleton()
    spheres = preset_spheres(skeleton)
    places = np.random.default_rng(0).normal(size=(2, 3, skeleton.num_joints, 3))
    batch = np.asarray(sphere_centres(spheres, places.astype(np.float32)))
    assert batch.shape == (2, 3, 30, 3)
    one = reference.sphere_places(spheres.first, spheres.second, spheres.share, places[1, 2])
    np.testing.assert_allclose(batch[1, 2], one, atol=1e-5)
