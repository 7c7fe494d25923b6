"""What programs outside of Python make of files: three.js and Khronos' glTF validator, in node.

They are looked for in the folder ``node_modules`` that ``MGJAX_NODE_MODULES`` names, or in the
repository's own: ``npm install --no-save three gltf-validator`` makes one. Where node or a package
is missing, tests are skipped with that reason, or fail if ``MGJAX_REQUIRE_NODE=1``.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]


def modules(*packages: str) -> Path:
    """The folder of node packages that has all of these."""
    folder = (ROOT / os.environ.get("MGJAX_NODE_MODULES", "node_modules")).resolve()
    missing = [package for package in packages if not (folder / package / "package.json").is_file()]
    if shutil.which("node") is not None and not missing:
        return folder
    reason = f"no {', '.join(missing)} in {folder} (MGJAX_NODE_MODULES)" if missing else "no node"
    if os.environ.get("MGJAX_REQUIRE_NODE") == "1":
        pytest.fail(reason)
    pytest.skip(reason)


def node(script: str, *arguments: str | Path) -> Any:
    """Runs a script beside this file; what it prints is JSON."""
    done = subprocess.run(
        ["node", str(HERE / script), *map(str, arguments)],
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout)


def seen_by_three(file: Path, names: Sequence[str], frames: int, frame_rate: float) -> np.ndarray:
    """[frames, names, 3] places of joints in the world."""
    folder = modules("three")
    listed = file.with_name(f"{file.name}.names.json")
    listed.write_text(json.dumps(list(names)))
    return np.array(node("positions.mjs", folder, file, str(frames), repr(frame_rate), listed))


def issues(file: Path) -> dict[str, Any]:
    """What the validator reports: ``numErrors``, ``numWarnings``, ``messages`` …"""
    return node("validate.mjs", modules("gltf-validator"), file)
