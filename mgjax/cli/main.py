"""Which command was asked for; its work is imported only then, so that ``--help`` is quick."""

from __future__ import annotations

import dataclasses
import importlib
import sys
from pathlib import Path
from typing import Annotated, Any

import tyro

from mgjax.cli.arguments import (
    Avoid,
    Bench,
    Build,
    Convert,
    Coverage,
    Demo,
    Fetch,
    Info,
    Quality,
    Runs,
    Scene,
    Sensor,
    Study,
    View,
    Walk,
)

MODULES: dict[type, str] = {
    Info: "files.info",
    Convert: "files.convert",
    Quality: "files.quality",
    Fetch: "files.fetch",
    Build: "build",
    Avoid: "avoid",
    Walk: "walk",
    Coverage: "coverage",
    Scene: "scene",
    Demo: "demo",
    Bench: "bench",
    Sensor: "sensor",
    Study: "study",
    Runs: "runs",
    View: "view",
}
"""Below this folder, the module of each command; its ``run`` takes the arguments."""

Command = (
    Annotated[Info, tyro.conf.subcommand("info")]
    | Annotated[Convert, tyro.conf.subcommand("convert")]
    | Annotated[Quality, tyro.conf.subcommand("quality")]
    | Annotated[Fetch, tyro.conf.subcommand("fetch")]
    | Annotated[Build, tyro.conf.subcommand("build")]
    | Annotated[Avoid, tyro.conf.subcommand("avoid")]
    | Annotated[Walk, tyro.conf.subcommand("walk")]
    | Annotated[Coverage, tyro.conf.subcommand("coverage")]
    | Annotated[Scene, tyro.conf.subcommand("scene")]
    | Annotated[Demo, tyro.conf.subcommand("demo")]
    | Annotated[Bench, tyro.conf.subcommand("bench")]
    | Annotated[Sensor, tyro.conf.subcommand("sensor")]
    | Annotated[Study, tyro.conf.subcommand("study")]
    | Annotated[Runs, tyro.conf.subcommand("runs")]
    | Annotated[View, tyro.conf.subcommand("view")]
)


def main(arguments: list[str] | None = None) -> int:
    """Runs one command; returns its exit status: 0, or 2 for bad input with one line on stderr."""
    command = tyro.cli(
        Command,  # pyright: ignore[reportArgumentType]
        prog="mgjax",
        description="Motion graphs for characters that react.",
        args=arguments,
        config=(tyro.conf.FlagCreatePairsOff, tyro.conf.HelptextFromCommentsOff),
    )
    from mgjax.core.errors import MgjaxError

    if not isinstance(command, View | Fetch | Runs):  # they compute nothing here, and begin at once
        from mgjax.core.xla.compilation import enable_cache

        enable_cache()
    try:
        command = with_user_paths(command)
        importlib.import_module(f"mgjax.cli.{MODULES[type(command)]}").run(command)
    except MgjaxError as error:
        print("mgjax: " + " ".join(str(error).split("\n")), file=sys.stderr)
        return 2
    except BrokenPipeError:
        return 0
    except KeyboardInterrupt:
        print("mgjax: interrupted; nothing was written", file=sys.stderr)
        return 130
    return 0


def with_user_paths(value: Any) -> Any:
    """Arguments, in tuples and commands too, whose paths have ``~`` replaced by a home folder."""
    from mgjax.io.user_path import user_path

    if isinstance(value, Path):
        return user_path(value)
    if isinstance(value, tuple):
        return tuple(map(with_user_paths, value))
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {
            f.name: with_user_paths(getattr(value, f.name)) for f in dataclasses.fields(value)
        }
        return type(value)(**fields)
    return value
