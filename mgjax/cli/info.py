"""``mgjax info``."""

from __future__ import annotations

from typing import Any

from mgjax.cli.arguments import Info
from mgjax.cli.report import emit, to_json
from mgjax.clips.oddities import find_oddities
from mgjax.io.load import read_capture
from mgjax.io.output import output_folder


def run(command: Info) -> None:
    """Describes each file."""
    files: list[dict[str, Any]] = []
    lines: list[str] = []
    for path in command.files:
        capture = read_capture(path)
        skeleton, motion = capture.skeleton, capture.motion
        oddities = find_oddities(skeleton, motion)
        files.append(
            {
                "file": str(path),
                "joints": skeleton.num_joints,
                "end_joints": len(skeleton.end_joints),
                "names": list(skeleton.names),
                "parents": list(skeleton.parents),
                "rest_height_m": round(skeleton.rest_height(), 4),
                "frames": motion.num_frames,
                "fps": motion.frame_rate,
                "seconds": round(motion.seconds, 4),
                "unit": capture.unit.name,
                "metres_per_unit": capture.unit.metres,
                "oddities": [{"kind": o.kind, "frame": o.frame, "text": o.text} for o in oddities],
            }
        )
        lines.append(
            f"{path}: {skeleton.num_joints} joints ({len(skeleton.end_joints)} ends), rest pose"
            f" {skeleton.rest_height():.2f} m tall, {motion.num_frames} frames at"
            f" {motion.frame_rate:g} fps = {motion.seconds:.2f} s, unit: {capture.unit.name}"
        )
        lines += [f"  {o.text}" for o in oddities]
    result = {"files": files}
    if command.out is not None:
        with output_folder(command.out) as folder:
            (folder / "info.json").write_text(to_json(result) + "\n")
    emit(result, lines, as_json=command.json)
