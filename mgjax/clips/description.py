"""What a file of motion holds, and what is strange about it, for a reader."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mgjax.clips.oddities import find_oddities
from mgjax.core.body.roles import find_roles
from mgjax.io.reading.capture import Capture

SURE = 0.9
"""A unit less likely than this is said to be a guess."""


def describe(path: Path, capture: Capture) -> dict[str, Any]:
    """One file, ready for JSON."""
    skeleton, motion = capture.skeleton, capture.motion
    oddities = find_oddities(skeleton, motion)
    roles = {role: skeleton.names[joint] for role, joint in find_roles(skeleton).items()}
    return {
        "file": str(path),
        "joints": skeleton.num_joints,
        "end_joints": len(skeleton.end_joints),
        "names": list(skeleton.names),
        "parents": list(skeleton.parents),
        "frames": motion.num_frames,
        "fps": motion.frame_rate,
        "seconds": round(motion.seconds, 4),
        **capture.reading.as_dict(),
        "roles": roles,
        "oddities": [
            *({"kind": n.kind, "frame": None, "text": n.text} for n in capture.reading.notes),
            *({"kind": o.kind, "frame": o.frame, "text": o.text} for o in oddities),
        ],
    }


def description_lines(row: dict[str, Any], *, show_roles: bool = False) -> list[str]:
    """For people: what was found in the first line, then roles where asked for, then oddities."""
    tall = row["height_m"]
    body = "no body on two legs" if tall is None else f"a body of {tall:.2f} m"
    guess = "" if row["unit_sure"] >= SURE else " (a guess; --units says it)"
    front = f", looks along {row['front']}" if row["front"] else ""
    lines = [
        f"{row['file']}: {row['joints']} joints ({row['end_joints']} ends), {body},"
        f" {row['frames']} frames at {row['fps']:g} fps = {row['seconds']:.2f} s,"
        f" unit: {row['unit']}{guess}, up: {row['up']}{front}"
    ]
    if show_roles:
        lines += [f"  {role}: {name}" for role, name in row["roles"].items()]
    return lines + [f"  {oddity['text']}" for oddity in row["oddities"]]
