"""What the command line says of how clips are to be read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mgjax.cli.arguments import Reading
from mgjax.clips.clips_toml import ClipsToml, read_as_from
from mgjax.clips.folder import clip_files
from mgjax.core.errors import ConfigError
from mgjax.io.reading.read_as import ReadAs
from mgjax.io.toml_file import read_toml


def read_as_of(command: Reading, roles: Path | None) -> ReadAs:
    """The settings that a command gives, all others open.

    Raises:
        ConfigError: one of them means nothing.
    """
    said: dict[str, Any] = {
        "units": command.units,
        "up": command.up,
        "front": command.front,
        "frame_rate": command.fps,
        "floor": None if command.floor is None else _floor(command.floor),
        "asf": None if command.asf is None else command.asf.resolve(),
    }
    said = {key: value for key, value in said.items() if value is not None}
    if roles is not None:
        said["roles"] = read_toml(roles)[1]
    return read_as_from(said, roles or Path("command line"))


def files_of(paths: tuple[Path, ...]) -> list[tuple[Path, ReadAs]]:
    """The files, and those in folders; with what a ``clips.toml`` beside them says."""
    found: list[tuple[Path, ReadAs]] = []
    for path in paths:
        if path.is_dir():
            known = ClipsToml(path)
            found += [(path / name, known.of(path / name)) for name in clip_files(path)]
        else:
            known = ClipsToml(path.parent) if (path.parent / "clips.toml").is_file() else None
            found.append((path, known.of(path) if known else ReadAs()))
    return found


def _floor(text: str) -> float | str:
    if text == "keep":
        return text
    try:
        return float(text)
    except ValueError:
        raise ConfigError(f"floor {text!r}, expected a height in metres or 'keep'") from None
