"""USD files, as OpenUSD itself reads them."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from mgjax.core.errors import ConfigError, OutputError
from mgjax.core.kinematics import global_positions
from mgjax.io.save import save_motion
from mgjax.io.usd.write import save_usd
from tests.io.skeletons import CASES

pytest.importorskip("pxr")


def places(path, frames: int) -> np.ndarray:
    """[F,J,3] where UsdSkel puts the joints."""
    from pxr import Usd, UsdSkel

    stage = Usd.Stage.Open(str(path))
    cache = UsdSkel.Cache()
    cache.Populate(UsdSkel.Root.Get(stage, "/Body"), Usd.PrimDefaultPredicate)
    query = cache.GetSkelQuery(UsdSkel.Skeleton.Get(stage, "/Body/Skeleton"))
    matrices = [np.array(query.ComputeJointSkelTransforms(frame)) for frame in range(frames)]
    return np.stack(matrices)[:, :, 3, :3]


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd"])
@pytest.mark.parametrize("name", CASES)
def test_joints_are_where_they_should_be(tmp_path, name, suffix):
    skeleton, motion = CASES[name]()
    path = tmp_path / f"x{suffix}"
    save_motion(path, skeleton, motion)
    assert path.read_bytes().startswith(b"#usda" if suffix == ".usda" else b"PXR-USDC")
    want = global_positions(skeleton, motion)
    np.testing.assert_allclose(places(path, motion.num_frames), want, atol=1e-5)


def test_stage_and_skinning(tmp_path):
    from pxr import Usd, UsdGeom, UsdSkel

    skeleton, motion = CASES["clip"]()
    save_usd(tmp_path / "x.usda", skeleton, motion)
    stage = Usd.Stage.Open(str(tmp_path / "x.usda"))
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert stage.GetTimeCodesPerSecond() == 30
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0, 99)
    assert str(stage.GetDefaultPrim().GetPath()) == "/Body"
    bones = UsdSkel.Skeleton.Get(stage, "/Body/Skeleton")
    assert list(bones.GetJointNamesAttr().Get()) == list(skeleton.names)
    # Skinned by UsdSkel, the surface stands around the joints.
    cache = UsdSkel.Cache()
    cache.Populate(UsdSkel.Root.Get(stage, "/Body"), Usd.PrimDefaultPredicate)
    skinning = cache.GetSkinningQuery(stage.GetPrimAtPath("/Body/Surface"))
    points = UsdGeom.Mesh.Get(stage, "/Body/Surface").GetPointsAttr().Get()
    skel = cache.GetSkelQuery(bones)
    assert skinning.ComputeSkinnedPoints(skel.ComputeSkinningTransforms(50), points, 50)
    skinned = np.array(points)
    joints = global_positions(skeleton, motion)[50]
    assert (skinned.min(axis=0) > joints.min(axis=0) - 0.15).all()
    assert (skinned.max(axis=0) < joints.max(axis=0) + 0.15).all()
    assert np.ptp(skinned[:, 1]) > 1.4


@pytest.mark.parametrize("name", CASES)
def test_the_validator_finds_nothing(tmp_path, name):
    from pxr import Usd, UsdValidation

    save_usd(tmp_path / "x.usdc", *CASES[name]())
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    stage = Usd.Stage.Open(str(tmp_path / "x.usdc"))
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert len(validators) > 10
    assert [error.GetMessage() for error in errors] == []


def test_without_usd_it_says_how_to_get_it(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(ConfigError, match=r"mgjax\[usd\]"):
        save_usd(tmp_path / "x.usd", *CASES["random"]())
    assert not list(tmp_path.iterdir())


def test_nothing_half_written_is_left(tmp_path):
    with pytest.raises(OutputError, match="cannot be written"):
        save_usd(tmp_path / "no" / "x.usda", *CASES["random"]())
    assert not list(tmp_path.iterdir())
