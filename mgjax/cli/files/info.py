"""``mgjax info``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from tqdm import tqdm

from mgjax.cli.arguments import Info
from mgjax.cli.files.reading import files_of, read_as_of
from mgjax.cli.report import emit, to_json
from mgjax.clips.clips_toml import over
from mgjax.clips.description import describe, description_lines
from mgjax.clips.folder import all_of
from mgjax.core.errors import ConfigError, MgjaxError
from mgjax.io.load import read_capture
from mgjax.io.output import output_folder
from mgjax.io.reading.capture import Capture
from mgjax.stage.html import save_html


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
    played: list[tuple[Path, Capture]] = []
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
        lines += description_lines(row, show_roles=show_roles)
        if show_roles:
            captures.append((path, capture))
        if command.html:
            played.append((path, capture))
    if len(bad) == len(files):
        raise all_of(bad, len(files))
    result = {"files": files}
    if command.html and command.out is None:
        raise ConfigError(got="--html without --out", expected="--out DIR for the pages")
    if command.out is not None:
        with output_folder(command.out) as folder:
            (folder / "info.json").write_text(to_json(result) + "\n")
            for number, (path, capture) in enumerate(captures):
                from mgjax.pictures.body import draw_body

                name = path.stem if len(captures) == 1 else f"{number:03d}_{path.stem}"
                draw_body(folder / f"{name}_body.png", capture.skeleton, capture.motion)
            for name, (path, capture) in _named(played).items():
                thing = (capture.skeleton, capture.motion)
                save_html(folder / name, thing, title=path.name)
    emit(result, lines, as_json=command.json)
    if bad:
        raise all_of(bad, len(files))


def _named(played: list[tuple[Path, Capture]]) -> dict[str, tuple[Path, Capture]]:
    """Pages by their names: ``index.html`` where there is one file."""
    if len(played) == 1:
        return {"index.html": played[0]}
    return {f"{i:03d}_{path.stem}.html": (path, x) for i, (path, x) in enumerate(played)}


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
