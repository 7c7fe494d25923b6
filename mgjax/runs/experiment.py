"""One way to run an experiment: settings in, a folder with the results and their origin out.

A script ``experiments/<room>/<name>.py`` defines a frozen dataclass ``Config`` whose fields all
have defaults, with a class method ``smoke()`` that returns the settings of a tiny version, and
``run(config) -> Results`` or, for sweeps that can go on after an interruption,
``run(config, points) -> Results`` (see :class:`mgjax.runs.points.Points`). It ends with

    if __name__ == "__main__":
        experiment(run, Config)

and is run by

    python -m experiments.<room>.<name> --config FILE --set key=value --smoke --out DIR
"""

from __future__ import annotations

import argparse
import inspect
import json
import signal
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NoReturn, TypeVar, get_args

import numpy as np
from matplotlib.figure import Figure

from mgjax.core.errors import ConfigError, MgjaxError, printable
from mgjax.core.parallel.executors import Name, executor
from mgjax.core.xla.compilation import enable_cache
from mgjax.io.output import output_folder
from mgjax.io.toml_file import to_toml
from mgjax.io.user_path import user_path
from mgjax.runs.identity import fingerprint, inputs_of, settings_of, sources_of
from mgjax.runs.kept import keep_record, kept_record
from mgjax.runs.points import Points
from mgjax.runs.record import (
    CompileTimes,
    append_line,
    check_appendable,
    compile_times,
    flat,
    load_average,
    machine,
    plain,
    revision,
    versions,
)
from mgjax.runs.settings import describe, resolve

T = TypeVar("T")
PARTIAL = "partial.jsonl"
"""In the folder of the results while a sweep is not over; then ``points.jsonl`` has its points."""
DPI = 120


@dataclass(frozen=True, kw_only=True)
class Results:
    """What an experiment found.

    Attributes:
        metrics: JSON values (NumPy's numbers and arrays too) that are the same for the same config
            on the same machine.
        timings: JSON values that are not, such as seconds measured.
        arrays: for ``arrays.npz``.
        figures: by name, a figure or a function that draws one; each becomes ``<name>.png``.
        lines: what is printed for people.
    """

    metrics: dict[str, Any]
    timings: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, np.ndarray] = field(default_factory=dict)
    figures: dict[str, Figure | Callable[[], Figure]] = field(default_factory=dict)
    lines: tuple[str, ...] = ()


def experiment(run: Callable[..., Results], kind: type) -> NoReturn:
    """Runs the experiment as the command line asks, and exits."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # a scheduler's end is an interrupt
    enable_cache()
    sys.exit(execute(run, kind, sys.argv[1:]))


def execute(run: Callable[..., Results], kind: type, arguments: Sequence[str]) -> int:
    """Runs an experiment in this process.

    Returns:
        The exit status: 0; 2 for bad input, with one line on stderr; 130 when interrupted.
    """
    label = "/".join(_names(run))
    try:
        command = _parser(run, kind).parse_args(arguments)
        config = resolve(kind, command.config, smoke=command.smoke, settings=command.settings)
        out = command.out or Path("out", *_names(run))
        if command.record is not None:
            known = kept_record(command.record)
            if (
                known is not None
                and known["fingerprint"] == identity_of(run, config)["fingerprint"]
            ):
                text = f"{printable(command.record)}: a record of this very run; not run again"
                print(json.dumps(known) if command.json else text, flush=True)
                return 0
        with executor(command.executor, command.workers, command.address) as made:
            record, results = perform(
                run, config, out, smoke=command.smoke, runs=command.runs, executor=made
            )
        if command.record is not None:
            keep_record(command.record, record)
    except MgjaxError as error:
        print(f"{label}: " + " ".join(str(error).split("\n")), file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        text = "interrupted; nothing was written but the finished points of a sweep"
        print(f"{label}: {text}", file=sys.stderr)
        return 130
    seconds = record["seconds"]
    lines = [
        *results.lines,
        f"{seconds['wall']:.1f} s, {seconds['compile']:.1f} s of them compiling; written to {out}",
    ]
    print(json.dumps(record) if command.json else "\n".join(lines), flush=True)
    return 0


def perform(
    run: Callable[..., Results],
    config: Any,
    out: str | Path,
    *,
    smoke: bool = False,
    runs: str | Path | None = None,
    executor: Executor | None = None,
) -> tuple[dict[str, Any], Results]:
    """Runs an experiment and writes what came of it, all files together and only on success.

    Args:
        run: of one argument, the config, or two, the config and the points of a sweep.
        config: resolved.
        out: folder for ``config.toml``, ``metrics.json``, ``arrays.npz``, ``points.jsonl`` and the
            figures. Until the end it holds only ``partial.jsonl`` with the finished points.
        smoke: noted in the record.
        runs: file to which one line with the settings and numbers of this run is added.
        executor: of the points of a sweep; by default this process.

    Returns:
        What ``metrics.json`` has, and what ``run`` returned.
    """
    toml = to_toml(config)
    commit, dirty = revision(Path(inspect.getfile(run)).parent)
    if runs is not None:
        check_appendable(runs)
    with output_folder(out) as folder:
        identity = identity_of(run, config)
        points = Points(Path(out) / PARTIAL, identity, executor)
        if points.differs:
            what = ", ".join(key for key in points.differs if key != "fingerprint")
            print(f"{PARTIAL} is of another run ({what} differ): begun anew", file=sys.stderr)
        start, busy, load = time.perf_counter(), time.process_time(), load_average()
        with compile_times() as compiling:
            results = measured(run, config, points)
        wall, cpu = time.perf_counter() - start, time.process_time() - busy
        record = {
            "smoke": smoke,
            "seed": getattr(config, "seed", None),
            "finished": datetime.now(UTC).isoformat(timespec="seconds"),
            "git_revision": commit,
            "git_dirty": dirty,
            **identity,
            "machine": machine(),
            "seconds": _seconds(wall, cpu, compiling),
            "load_average": [load, load_average()],
            "points": {"measured": points.measured, "resumed": points.resumed},
            "metrics": plain(results.metrics),
            "timings": plain(results.timings, "timings"),
        }
        (folder / "config.toml").write_text(toml, encoding="utf-8")
        _write_results(folder, results, points)
        record["files"] = sorted([*(item.name for item in folder.iterdir()), "metrics.json"])
        text = json.dumps(record, indent=1, allow_nan=False)
        (folder / "metrics.json").write_text(text + "\n", encoding="utf-8")
    points.discard()
    if runs is not None:
        append_line(runs, flat(record | {"config": settings_of(config)}))
    return record, results


def identity_of(run: Callable[..., Results], config: Any) -> dict[str, Any]:
    """What a run's figures depend on: settings, files that are read, programs, versions.

    Returns:
        ``experiment``, ``config`` (of paths the last part), ``inputs`` and ``sources`` (hashes),
        ``versions``, and ``fingerprint``, the hash of all these.
    """
    label = "/".join(_names(run))
    settings = plain(settings_of(config), "config")
    known = {"inputs": inputs_of(config), "sources": sources_of(run), "versions": versions()}
    return {
        "experiment": label,
        "config": settings,
        **known,
        "fingerprint": fingerprint(label, settings, known),
    }


def measured(run: Callable[..., Results], config: Any, points: Points | None = None) -> Results:
    """What an experiment returns; without points those of a sweep are kept nowhere."""
    wanted = len(inspect.signature(run).parameters)
    results = run(config, points or Points()) if wanted > 1 else run(config)
    if not isinstance(results, Results):
        raise TypeError(f"{run.__name__} returned {type(results).__name__}, expected Results")
    return results


def _seconds(wall: float, cpu: float, compiling: CompileTimes) -> dict[str, Any]:
    """``wall`` is the whole of ``run``; ``compile`` is part of it, ``load`` part of ``compile``.

    ``cpu`` is the processor time of all threads of this process.
    """
    return {
        "wall": round(wall, 4),
        "cpu": round(cpu, 4),
        "compile": round(compiling.seconds, 4),
        "load": round(compiling.load_s, 4),
        "programs": compiling.programs,
        "programs_loaded": compiling.loaded,
    }


def _write_results(folder: Path, results: Results, points: Points) -> None:
    if results.arrays:
        np.savez_compressed(folder / "arrays.npz", **results.arrays)  # pyright: ignore[reportArgumentType]
    if points.measured + points.resumed:
        (folder / "points.jsonl").write_text(points.lines(), encoding="utf-8")
    for name, drawn in results.figures.items():
        figure = drawn if isinstance(drawn, Figure) else drawn()
        figure.savefig(folder / f"{name}.png", dpi=DPI)


def _names(run: Callable[..., Any]) -> tuple[str, str]:
    """Room and name of an experiment, from the place of its script."""
    file = Path(inspect.getfile(run))
    return file.parent.name, file.stem


class _Parser(argparse.ArgumentParser):
    """Bad arguments are bad input: one line."""

    def error(self, message: str) -> NoReturn:
        raise ConfigError(f"{message}; --help shows the arguments")


def _parser(run: Callable[..., Results], kind: type) -> argparse.ArgumentParser:
    room, name = _names(run)
    parser = _Parser(
        prog=f"python -m experiments.{room}.{name}",
        description=inspect.getdoc(inspect.getmodule(run)),
        epilog="settings:\n" + describe(kind),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("--config", type=user_path, metavar="FILE", help="TOML file of settings")
    add(
        "--set",
        dest="settings",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="one setting, after --config and --smoke; may be given more than once",
    )
    add("--smoke", action="store_true", help="a tiny version of it")
    add("--out", type=user_path, metavar="DIR", help=f"default: out/{room}/{name}")
    add("--runs", type=user_path, metavar="FILE", help="add one JSON line on this run to the file")
    add(
        "--record",
        type=user_path,
        metavar="FILE",
        help="also keep the record in the file; if it holds one of the same settings, inputs,"
        " programs and versions, nothing is run",
    )
    add("--executor", choices=get_args(Name), default="serial", help="where points are computed")
    add("--workers", type=int, metavar="N", help="of the executor; default: one a processor")
    add("--address", metavar="WHERE", help="of a running Ray cluster")
    add("--json", action="store_true", help="print metrics.json on stdout")
    return parser
