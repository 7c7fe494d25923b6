"""Writing USD (OpenUSD's UsdSkel schema): a skeleton, its animation and a body bound to it."""

from __future__ import annotations

import tempfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from mgjax.core.errors import ConfigError
from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, rest_positions, validate_skeleton
from mgjax.io.output import replace_file
from mgjax.io.skin.mesh import COLOUR, body_mesh


def save_usd(path: str | Path, skeleton: Skeleton, motion: Motion) -> None:
    """Writes ``.usda`` (text), ``.usdc`` or ``.usd`` (binary): metres, y up, one time code a frame.

    The stage's default prim is the SkelRoot ``/Body`` with ``Skeleton``, ``Animation`` and the
    skinned mesh ``Surface``. Joints have identity rest rotations, as ours do; USD's joint tokens
    are paths of identifiers, and ``jointNames`` holds the names as they are.

    Raises:
        ConfigError: usd-core is not installed.
        SkeletonError: the skeleton is not valid.
        MotionError: the motion does not fit the skeleton or is not finite.
        OutputError: the file cannot be written.
    """
    validate_skeleton(skeleton)
    validate_motion(skeleton, motion)
    pxr = _pxr()
    with tempfile.TemporaryDirectory() as folder:
        draft = Path(folder) / f"motion{Path(path).suffix.lower()}"
        stage = pxr.Usd.Stage.CreateNew(str(draft))
        pxr.UsdGeom.SetStageUpAxis(stage, pxr.UsdGeom.Tokens.y)
        pxr.UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        stage.SetTimeCodesPerSecond(motion.frame_rate)
        stage.SetFramesPerSecond(motion.frame_rate)
        stage.SetStartTimeCode(0)
        stage.SetEndTimeCode(motion.num_frames - 1)
        root = pxr.UsdSkel.Root.Define(stage, "/Body")
        stage.SetDefaultPrim(root.GetPrim())
        bones = _add_skeleton(pxr, stage, skeleton)
        animation = _add_animation(pxr, stage, skeleton, motion)
        binding = pxr.UsdSkel.BindingAPI.Apply(bones.GetPrim())
        binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
        _add_body(pxr, stage, skeleton, bones)
        stage.Save()
        replace_file(path, draft.read_bytes())


def _pxr() -> SimpleNamespace:
    """The modules of usd-core; :class:`ConfigError` says how to get it."""
    try:
        from pxr import Gf, Tf, Usd, UsdGeom, UsdSkel, Vt
    except ImportError:
        raise ConfigError(
            "got no usd-core, with which USD is written, expected it to be installed:"
            " pip install 'mgjax[usd]'"
        ) from None
    return SimpleNamespace(Gf=Gf, Tf=Tf, Usd=Usd, UsdGeom=UsdGeom, UsdSkel=UsdSkel, Vt=Vt)


def joint_paths(pxr: SimpleNamespace, skeleton: Skeleton) -> list[str]:
    """A path of identifiers for each joint, such as ``Hips/Spine``; unique."""
    paths: list[str] = []
    taken: set[str] = set()
    for name, parent in zip(skeleton.names, skeleton.parents, strict=True):
        above = f"{paths[parent]}/" if parent >= 0 else ""
        plain = above + pxr.Tf.MakeValidIdentifier(name)
        path, number = plain, 1
        while path in taken:
            number += 1
            path = f"{plain}_{number}"
        taken.add(path)
        paths.append(path)
    return paths


def _add_skeleton(pxr: SimpleNamespace, stage: Any, skeleton: Skeleton) -> Any:
    bones = pxr.UsdSkel.Skeleton.Define(stage, "/Body/Skeleton")
    bones.CreateJointsAttr(joint_paths(pxr, skeleton))
    bones.CreateJointNamesAttr(list(skeleton.names))
    bones.CreateBindTransformsAttr(_translations(pxr, rest_positions(skeleton)))
    offsets = np.asarray(skeleton.offsets, np.float64)
    bones.CreateRestTransformsAttr(_translations(pxr, offsets))
    return bones


def _translations(pxr: SimpleNamespace, places: np.ndarray) -> Any:
    matrices = np.tile(np.eye(4), (len(places), 1, 1))
    matrices[:, 3, :3] = places  # row vectors
    return pxr.Vt.Matrix4dArray.FromNumpy(matrices)


def _add_animation(pxr: SimpleNamespace, stage: Any, skeleton: Skeleton, motion: Motion) -> Any:
    animation = pxr.UsdSkel.Animation.Define(stage, "/Body/Animation")
    animation.CreateJointsAttr(joint_paths(pxr, skeleton))
    scales = np.ones((skeleton.num_joints, 3), np.float16)
    animation.CreateScalesAttr(pxr.Vt.Vec3hArray.FromNumpy(scales))
    offsets = np.asarray(skeleton.offsets, np.float32)
    rotations = np.asarray(motion.local_rotations, np.float32)
    moves, turns = animation.CreateTranslationsAttr(), animation.CreateRotationsAttr()
    for frame in range(motion.num_frames):
        places = offsets if motion.joint_offsets is None else motion.joint_offsets[frame]
        places = np.array(places, np.float32)
        places[0] = motion.root_translation[frame]
        moves.Set(pxr.Vt.Vec3fArray.FromNumpy(places), frame)
        quaternions = [pxr.Gf.Quatf(*q) for q in rotations[frame].tolist()]
        turns.Set(pxr.Vt.QuatfArray(quaternions), frame)
    return animation


def _add_body(pxr: SimpleNamespace, stage: Any, skeleton: Skeleton, bones: Any) -> None:
    body = body_mesh(skeleton)
    mesh = pxr.UsdGeom.Mesh.Define(stage, "/Body/Surface")
    mesh.CreatePointsAttr(pxr.Vt.Vec3fArray.FromNumpy(body.vertices))
    mesh.CreateNormalsAttr(pxr.Vt.Vec3fArray.FromNumpy(body.normals))
    mesh.SetNormalsInterpolation(pxr.UsdGeom.Tokens.vertex)
    mesh.CreateFaceVertexCountsAttr([3] * len(body.triangles))
    mesh.CreateFaceVertexIndicesAttr(body.triangles.reshape(-1).tolist())
    mesh.CreateSubdivisionSchemeAttr(pxr.UsdGeom.Tokens.none)
    mesh.CreateExtentAttr(
        pxr.Vt.Vec3fArray.FromNumpy(
            np.stack([body.vertices.min(axis=0), body.vertices.max(axis=0)])
        )
    )
    mesh.CreateDisplayColorAttr([pxr.Gf.Vec3f(*COLOUR)])
    binding = pxr.UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([bones.GetPath()])
    binding.CreateJointIndicesPrimvar(False, 1).Set(body.joints.tolist())
    binding.CreateJointWeightsPrimvar(False, 1).Set([1.0] * len(body.joints))
    binding.CreateGeomBindTransformAttr(pxr.Gf.Matrix4d(1))
