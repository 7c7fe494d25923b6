"""fairmotion: a motion graph of a clip, every third frame a node."""

from __future__ import annotations

import logging
import tempfile
from pathlib import Path
from typing import Any

from experiments.benchmarks.beside.calls import Calls

WEIGHTS = {
    **{f"w_{part}_pos": 50.0 for part in ("joint", "root", "ee")},
    **{f"w_{part}_vel": 0.01 for part in ("joint", "root", "ee")},
}


def set_up(bvh: str, frame_rate: float) -> Calls:
    """Reads the clip; each call builds its graph in this process."""
    from fairmotion.core.velocity import (  # pyright: ignore[reportMissingImports]
        MotionWithVelocity,
    )
    from fairmotion.data import bvh as reader  # pyright: ignore[reportMissingImports]
    from fairmotion.tasks.motion_graph import (  # pyright: ignore[reportMissingImports]
        motion_graph,
    )

    logging.disable(logging.CRITICAL)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "clip.bvh").write_text(bvh, encoding="utf-8")
        motion = MotionWithVelocity.from_motion(reader.load(str(Path(folder, "clip.bvh"))))

    def call(_: int) -> Any:
        made = motion_graph.MotionGraph(
            motions=[motion],
            motion_files=[],
            skel=motion.skel,
            fps=frame_rate,
            base_length=2.0,
            stride_length=3 / frame_rate,
            compare_length=0.2,
            blend_length=0.2,
        )
        made.construct(w_trajectory=1.0, diff_threshold=5.0, num_workers=1, **WEIGHTS)
        return made

    return Calls(count=1, call=call, miss=lambda _, made: 0.0)
