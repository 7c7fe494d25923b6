"""Through Blender: our GLB to FBX and back to a GLB, whose bones have rest rotations.

``MGJAX_BLENDER`` names a Python that has Blender as a module (``pip install bpy``).
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from mgjax.core.kinematics import global_positions
from mgjax.io.gltf.write import save_glb
from mgjax.io.load import load_motion
from tests.io.skeletons import CASES
from tests.io.three import seen_by_three

SCRIPT = Path(__file__).resolve().parents[3] / "docs" / "blender_fbx.py"


@pytest.mark.parametrize("name", ["clip", "random"])
def test_through_fbx_and_back(tmp_path, name):
    python = os.environ.get("MGJAX_BLENDER")
    if not python:
        pytest.skip("MGJAX_BLENDER names no Python that has bpy")
    skeleton, motion = CASES[name]()
    save_glb(tmp_path / "a.glb", skeleton, motion)
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    for source, target in (("a.glb", "a.fbx"), ("a.fbx", "b.glb")):
        words = [python, str(SCRIPT), str(tmp_path / source), str(tmp_path / target)]
        done = subprocess.run(words, capture_output=True, text=True, env=environment, check=False)
        assert done.returncode == 0, done.stderr[-2000:]
    bones, moves = load_motion(tmp_path / "b.glb")
    assert set(skeleton.names) <= set(bones.names)
    assert (moves.num_frames, moves.frame_rate) == (motion.num_frames, motion.frame_rate)
    assert moves.joint_offsets is None
    want = global_positions(skeleton, motion)
    got = global_positions(bones, moves)
    order = [bones.index(joint) for joint in skeleton.names]
    np.testing.assert_allclose(got[:, order], want, atol=1e-4)
    seen = seen_by_three(tmp_path / "b.glb", bones.names, moves.num_frames, moves.frame_rate)
    np.testing.assert_allclose(got, seen, atol=1e-3)
