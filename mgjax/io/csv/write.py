"""Writing where joints are, frame by frame, as comma-separated values (RFC 4180)."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, validate_skeleton
from mgjax.io.output import replace_file


def save_csv(path: str | Path, skeleton: Skeleton, motion: Motion) -> None:
    """Writes a header and one row for each frame: places of all joints in the world, m, y up.

    Columns are ``frame`` (from 0), ``time`` (s) and, for each joint, ``<name>_x``, ``<name>_y``
    and ``<name>_z`` with 6 decimals. Rotations are not in it, so it cannot be read back.

    Raises:
        SkeletonError: the skeleton is not valid.
        MotionError: the motion does not fit the skeleton or is not finite.
        OutputError: the file cannot be written.
    """
    validate_skeleton(skeleton)
    validate_motion(skeleton, motion)
    places = np.asarray(global_positions(skeleton, motion), np.float64) + 0.0
    places[np.abs(places) < 5e-7] = 0  # no "-0.000000"
    text = io.StringIO()
    columns = [f"{name}_{axis}" for name in skeleton.names for axis in "xyz"]
    csv.writer(text, lineterminator="\n").writerow(["frame", "time", *columns])
    form = ",".join(["%d", "%.6f", *["%.6f"] * len(columns)])
    for frame, row in enumerate(places.reshape(len(places), -1).tolist()):
        text.write(form % (frame, frame / motion.frame_rate, *row) + "\n")
    replace_file(path, text.getvalue())
