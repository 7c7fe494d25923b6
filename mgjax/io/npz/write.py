"""Writing a motion as named arrays; see :mod:`mgjax.io.npz` for the keys."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, validate_skeleton
from mgjax.io.npz import VERSION
from mgjax.io.output import replace_file


def save_npz(path: str | Path, skeleton: Skeleton, motion: Motion) -> None:
    """Writes an .npz file of plain arrays; reading it back gives the very same numbers.

    Raises:
        SkeletonError: the skeleton is not valid.
        MotionError: the motion does not fit the skeleton or is not finite.
        OutputError: the file cannot be written.
    """
    validate_skeleton(skeleton)
    validate_motion(skeleton, motion)
    arrays = {
        "version": np.array(VERSION, np.int32),
        "names": np.array(skeleton.names, np.str_),
        "parents": np.array(skeleton.parents, np.int32),
        "offsets": np.asarray(skeleton.offsets, np.float32),
        "end_joints": np.array(skeleton.end_joints, np.int32),
        "quaternions": np.asarray(motion.local_rotations, np.float32),
        "root": np.asarray(motion.root_translation, np.float32),
        "fps": np.array(motion.frame_rate, np.float64),
    }
    if motion.joint_offsets is not None:
        arrays["joint_offsets"] = np.asarray(motion.joint_offsets, np.float32)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    replace_file(path, buffer.getvalue())
