"""``mgjax runs list``, ``show``, ``compare`` and ``sweep``."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mgjax.cli.arguments import CompareRuns, ListRuns, Runs, SweepRuns
from mgjax.cli.report import emit
from mgjax.core.errors import ConfigError, printable
from mgjax.runs.kept import SETTLED, differences, find_records, leaves, named, ratio

BELOW = (Path("experiments/records"), Path("out"))


def run(command: Runs) -> None:
    """Lists, shows, compares or sweeps."""
    asked = command.action
    if isinstance(asked, SweepRuns):
        swept(asked)
        return
    below = asked.below or tuple(folder for folder in BELOW if folder.is_dir())
    for folder in below:
        if not folder.is_dir():
            raise ConfigError(got=f"--below {printable(folder)}", expected="a folder")
    if isinstance(asked, ListRuns):
        rows = [_row(path, record) for path, record in find_records(below)]
        emit({"runs": rows}, [_line(row) for row in rows] or ["no runs"], as_json=asked.json)
    elif isinstance(asked, CompareRuns):
        found = differences(named(asked.a, below), named(asked.b, below))
        emit({"differ": found}, compared(found), as_json=asked.json)
    else:
        record = named(asked.run, below)
        emit(record, shown(record), as_json=asked.json)


def swept(command: SweepRuns) -> None:
    """Makes the runs that the file lacks."""
    from mgjax.core.parallel.executors import executor
    from mgjax.core.xla.compilation import enable_cache
    from mgjax.runs.settings import resolve
    from mgjax.runs.sweep import combinations, found_experiment, read_setting, sweep

    enable_cache()
    if command.samples < 1:
        raise ConfigError(got=f"--samples {command.samples}", expected="1 or more")
    kind = found_experiment(command.experiment).kind
    base = resolve(kind, command.config, smoke=command.smoke, settings=command.set)
    settings = combinations(
        [read_setting(text, "--grid") for text in command.grid],
        [read_setting(text, "--draw", ends=True) for text in command.draw],
        samples=command.samples,
        seed=command.seed,
    )
    with executor(command.executor, command.workers) as made:
        new, known = sweep(
            command.experiment, base, settings, command.out,
            executor=made, progress=sys.stderr.isatty(),
        )  # fmt: skip
    lines = [f"{new} runs made, {known} were there; in {command.out}"]
    emit({"made": new, "there": known, "out": str(command.out)}, lines, as_json=command.json)


def _row(path: Path, record: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "path": str(path),
        "experiment": record["experiment"],
        "finished": record["finished"],
        "git_revision": record["git_revision"],
        "git_dirty": record["git_dirty"],
        "seed": record["seed"],
        "smoke": record["smoke"],
        "wall_s": record["seconds"]["wall"],
        "fingerprint": record["fingerprint"],
    }


def _line(row: Mapping[str, Any]) -> str:
    revision = (row["git_revision"] or "none")[:10] + ("+" if row["git_dirty"] else "")
    smoke = "  smoke" if row["smoke"] else ""
    return (
        f"{row['experiment']:32} {row['finished'][:16]}  {revision:11} {row['wall_s']:8.1f} s"
        f"  {row['path']}{smoke}"
    )


def shown(record: Mapping[str, Any]) -> list[str]:
    """Lines of dotted keys and values, part by part."""
    lines = [f"{record['experiment']}, finished {record['finished']}"]
    for part in (*SETTLED[1:], "seed", "seconds", "metrics", "timings"):
        lines += [f"{key} = {_word(value)}" for key, value in leaves(record, part).items()]
    return lines


def compared(found: Mapping[str, Mapping[str, tuple]]) -> list[str]:
    """Lines of what differs; figures with the second over the first."""
    if not found:
        return ["no difference"]
    lines = []
    for part, pairs in found.items():
        lines.append(f"{part}: {len(pairs)} differ")
        for key, pair in pairs.items():
            quotient = ratio(pair) if part in ("metrics", "timings") else None
            over = "" if quotient is None else f"  (x {quotient:.3g})"
            name = key.removeprefix(f"{part}.")
            lines.append(f"  {name}: {_word(pair[0])} | {_word(pair[1])}{over}")
    return lines


def _word(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
