"""``mgjax info``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from tqdm import tqdm

from mgjax.cli.arguments import Info
from mgjax.cli.reading import files_of, read_as_of
from mgjax.cli.report import emit, to_json
from mgjax.clips.clips_toml import over
from mgjax.clips.folder import all_of
from mgjax.clips.oddities import find_oddities
from mgjax.core.body.roles import find_roles
from mgjax.core.errors import ConfigError, MgjaxError
from mgjax.io.load import read_capture
from mgjax.io.output import output_folder
from mgjax.io.reading.capture import Capture

SURE = 0.9
"""A unit less likely than this is said to be a guess."""


def run(command: Info) -> None:
    """Describes each file, and goes on after a bad one.

    Raises:
        MgjaxError: files were bad; all others have been described.
    """
    show_roles = command.roles is not None
    files_said, roles_said = _told_apart(command)
    said = read_as_of(command, roles_said)
    files: list[dict[str, Any]] = []
    lines: list[str] = []
    bad: list[MgjaxError] = []
    captures: list[tuple[Path, Capture]] = []
    found = files_of(files_said)
    hidden = not (sys.stderr.isatty() and len(found) > 20)
    for path, known in tqdm(found, desc="reading", unit="clip", disable=hidden, leave=False):
        try:
            capture = read_capture(path, over(known, said))
        except MgjaxError as error:
            bad.append(error)
            files.append({"file": str(path), "error": str(error)})
            lines.append(f"{path}: not read")
            continue
        row = describe(path, capture)
        files.append(row)
        lines += _lines(row, show_roles=show_roles)
        if show_roles:
            captures.append((path, capture))
    if len(bad) == len(files):
        raise all_of(bad, len(files))
    result = {"files": files}
    if command.out is not None:
        with output_folder(command.out) as folder:
            (folder / "info.json").write_text(to_json(result) + "\n")
            for number, (path, capture) in enumerate(captures):
                from mgjax.pictures.body import draw_body

                name = path.stem if len(captures) == 1 else f"{number:03d}_{path.stem}"
                draw_body(folder / f"{name}_body.png", capture.skeleton, capture.motion)
    emit(result, lines, as_json=command.json)
    if bad:
        raise all_of(bad, len(files))


def _told_apart(command: Info) -> tuple[tuple[Path, ...], Path | None]:
    """Motion files, and the TOML file of roles: ``--roles`` takes all that follows it."""
    after = command.roles or ()
    tables = [path for path in after if path.suffix.lower() == ".toml"]
    files = (*command.files, *(path for path in after if path not in tables))
    if len(tables) > 1:
        raise ConfigError(f"got {len(tables)} files of roles, expected one")
    if not files:
        raise ConfigError("got no motion file, expected at least one")
    return files, tables[0] if tables else None


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


def _lines(row: dict[str, Any], *, show_roles: bool) -> list[str]:
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
