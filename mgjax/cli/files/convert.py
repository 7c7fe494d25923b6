"""``mgjax convert``."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

from mgjax.cli.arguments import Convert
from mgjax.cli.files.reading import files_of, read_as_of
from mgjax.cli.report import emit
from mgjax.clips.clips_toml import over
from mgjax.core.errors import ConfigError, FileFormatError, printable
from mgjax.core.motion import resample
from mgjax.io.amass.read import is_amass
from mgjax.io.load import load_motion
from mgjax.io.output import output_folder
from mgjax.io.reading.read_as import ReadAs
from mgjax.io.save import check_suffix, save_motion
from mgjax.stage.html import save_html

PAGE = ".html"
"""A page that plays the motion."""


def run(command: Convert) -> None:
    """Reads a motion, or all in a folder, and writes it in the format that the suffix says."""
    rate, model = command.frame_rate, command.body_model
    if rate is not None and not 0 < rate <= 10000:
        raise ConfigError(got=f"--frame-rate {rate:g}", expected="more than 0, at most 10000")
    if command.file.is_dir():
        _convert_folder(command)
        return
    if command.to is not None:
        expected = "a folder to read where --to is given"
        raise ConfigError(got=f"--to {command.to} and no folder", expected=expected)
    _suffix(command.out)
    if model is not None and not is_amass(command.file):
        expected = "a file of AMASS where --body-model is given"
        raise FileFormatError(command.file, None, "another kind of file", expected)
    ((path, known),) = files_of((command.file,))
    result = _convert(command, path, known, command.out)
    emit(result | {"out": str(command.out)}, [_line(result, command.out)], as_json=command.json)


def _convert_folder(command: Convert) -> None:
    """All files or, if one cannot be converted, none; the folders below stay as they are."""
    place = printable(command.file)
    if command.to is None:
        expected = "the suffix to write, such as --to .glb"
        raise ConfigError(got="a folder without --to", expected=expected, place=place)
    suffix = _suffix(f"motion.{command.to.removeprefix('.')}")
    targets: dict[Path, tuple[Path, ReadAs]] = {}
    for path, known in files_of((command.file,)):
        target = command.out / path.relative_to(command.file).with_suffix(suffix)
        if target in targets:
            names = f"{targets[target][0].name} and {path.name}"
            got = f"{names}, which would both become {target.name}"
            raise ConfigError(got=got, expected="files of different names", place=place)
        targets[target] = path, known
    files: list[dict[str, Any]] = []
    with ExitStack() as stack:
        stages: dict[Path, Path] = {}
        for target, (path, known) in targets.items():
            if target.parent not in stages:
                stages[target.parent] = stack.enter_context(output_folder(target.parent))
            result = _convert(command, path, known, stages[target.parent] / target.name)
            files.append(result | {"out": str(target)})
    emit({"files": files}, [_line(file, file["out"]) for file in files], as_json=command.json)


def _suffix(path: str | Path) -> str:
    """The suffix of a file to be written, if it can be."""
    suffix = Path(path).suffix.lower()
    return suffix if suffix == PAGE else check_suffix(path)


def _convert(command: Convert, source: Path, known: ReadAs, target: Path) -> dict[str, Any]:
    """Converts one file; returns what is told of it."""
    rate = command.frame_rate
    read_as = over(
        known, replace(read_as_of(command, command.roles), body_model=command.body_model)
    )
    if rate is not None and source.suffix.lower() in (".glb", ".vrma"):
        read_as = replace(read_as, frame_rate=rate)  # it has curves over time, not frames
    skeleton, motion = load_motion(source, read_as=read_as)
    if rate is not None:
        motion = resample(motion, rate)
    if _suffix(target) == PAGE:
        save_html(target, (skeleton, motion), title=source.name)
    else:
        save_motion(target, skeleton, motion)
    return {
        "file": str(source),
        "format": target.suffix.lower().removeprefix("."),
        "joints": skeleton.num_joints,
        "frames": motion.num_frames,
        "fps": motion.frame_rate,
        "seconds": round(motion.seconds, 4),
    }


def _line(result: dict[str, Any], out: object) -> str:
    return (
        f"{out}: {result['joints']} joints, {result['frames']} frames at {result['fps']:g} fps"
        f" = {result['seconds']:.2f} s, from {result['file']}"
    )
