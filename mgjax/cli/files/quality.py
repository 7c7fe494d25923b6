"""``mgjax quality``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mgjax.cli.arguments import Quality as Command
from mgjax.cli.files.reading import files_of, read_as_of
from mgjax.cli.report import emit, to_json
from mgjax.clips.clips_toml import over
from mgjax.core.errors import ConfigError, FileFormatError, MgjaxError
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.load import load_motion
from mgjax.io.output import output_folder
from mgjax.quality.known import Captured, captured
from mgjax.quality.measuring import measure
from mgjax.quality.result import FIGURES, Quality
from mgjax.quality.seams import seams_of


@dataclass(frozen=True, kw_only=True)
class _File:
    path: Path
    skeleton: Skeleton
    motion: Motion
    seams: tuple[tuple[float, float], ...]


def run(command: Command) -> None:
    """Measures each file, beside the capture where one is given."""
    if not command.files:
        raise ConfigError(got="no motion file", expected="at least one")
    files = _read(command, command.files)
    known = _capture(_read(command, command.against)) if command.against else None
    found = [(file, _measured(file, known)) for file in files]
    result = {"files": [_json(file, quality) for file, quality in found]}
    lines = [line for file, quality in found for line in _table(file, quality)]
    if command.out is not None:
        from mgjax.pictures.quality import quality_picture

        with output_folder(command.out) as folder:
            (folder / "quality.json").write_text(to_json(result) + "\n")
            for number, file in enumerate(files):
                name = file.path.stem if len(files) == 1 else f"{number:03d}_{file.path.stem}"
                quality_picture(
                    folder / f"{name}.png",
                    file.skeleton,
                    file.motion,
                    against=known,
                    seams=file.seams,
                    title=file.path.name,
                )
        lines.append(f"written to {command.out}")
    emit(result, lines, as_json=command.json)


def _read(command: Command, paths: tuple[Path, ...]) -> list[_File]:
    said = read_as_of(command, command.roles)
    found: list[_File] = []
    for path, known in files_of(paths):
        skeleton, motion = load_motion(path, read_as=over(known, said))
        seams = seams_of(path)
        found.append(_File(path=path, skeleton=skeleton, motion=motion, seams=seams))
    return found


def _capture(files: list[_File]) -> Captured:
    """What the capture does; an error names its first file, which all others must resemble."""
    try:
        return captured([(file.skeleton, file.motion) for file in files])
    except MgjaxError as error:
        place = f"--against {files[0].path} …" if len(files) > 1 else f"--against {files[0].path}"
        raise type(error)(got=error.got, expected=error.expected, place=place) from None


def _measured(file: _File, known: Captured | None) -> Quality:
    try:
        return measure(file.skeleton, file.motion, against=known, seams=file.seams)
    except MgjaxError as error:
        if not error.got:
            raise
        raise FileFormatError(file.path, None, error.got, error.expected) from None


def _json(file: _File, quality: Quality) -> dict[str, Any]:
    """Figures as numbers, or null where there is none."""
    return {
        "file": str(file.path),
        "seconds": round(quality.seconds, 4),
        "seams": [{"start_s": start, "end_s": end} for start, end in file.seams],
        "figures": {key: _number(value) for key, value in quality.figures.items()},
        "at_seams": {key: _number(value) for key, value in quality.at_seams.items()},
        "capture": {
            key: {"p50": _number(middle), "p95": _number(high)}
            for key, (middle, high) in quality.beside.items()
        },
        "faults": list(quality.faults),
        "notes": list(quality.notes),
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _table(file: _File, quality: Quality) -> list[str]:
    """A line for each figure: of the file, of its seams, and of the capture."""
    heads = ["file"] + ["at seams"] * bool(quality.at_seams)
    heads += ["capture p50", "p95"] * bool(quality.beside)
    lines = [f"{file.path}: {quality.seconds:.2f} s, {len(file.seams)} seams"]
    lines += [f"  note: {note}" for note in quality.notes]
    lines.append(f"  {'':48}" + "".join(f"{head:>13}" for head in heads))
    for name, (words, unit) in FIGURES.items():
        values = [quality.figures[name]]
        values += [quality.at_seams.get(name, math.nan)] * bool(quality.at_seams)
        values += quality.beside.get(name, (math.nan, math.nan)) if quality.beside else ()
        mark = "!" if name in quality.faults else " "
        text = f"{words}, {unit}" if unit else words
        lines.append(f"{mark} {text:48}" + "".join(f"{_word(value):>13}" for value in values))
    return lines


def _word(value: float) -> str:
    if not math.isfinite(value):
        return "–"
    return f"{value:.4f}" if abs(value) < 10 else f"{value:.1f}"
