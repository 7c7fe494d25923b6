"""An experiment over a grid of settings, random ones, or both: one JSON line a run."""

from __future__ import annotations

import functools
import importlib
import itertools
import json
import operator
import os
import sys
import time
import tomllib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from tqdm import tqdm

from mgjax.core.errors import ConfigError, FileFormatError
from mgjax.core.parallel.run import run_all
from mgjax.io.settings import Words, changed
from mgjax.io.text import quoted
from mgjax.io.toml_file import toml_value
from mgjax.runs.experiment import Results, measured
from mgjax.runs.identity import INPUTS, fingerprint, inputs_of, settings_of, sources_of
from mgjax.runs.record import append_line, flat, plain, versions

T = TypeVar("T")
Setting = tuple[str, tuple[Any, ...]]
"""Key, and values of a grid or both ends of a range."""
LOT = 64
"""Most runs that are made together."""


@dataclass(frozen=True, kw_only=True)
class Swept:
    """An experiment that can be swept.

    Attributes:
        run: of one config.
        kind: of its config.
        traced: dotted keys of settings in which configs may differ that are run together.
        run_together: of several configs, the results of each; None where each is a run of its own.
    """

    run: Callable[..., Results]
    kind: type
    traced: tuple[str, ...] = ()
    run_together: Callable[[Sequence[Any]], Sequence[Results]] | None = None


def found_experiment(name: str) -> Swept:
    """The experiment of a module, which is looked for here, too.

    The module has ``run`` and ``Config``. It may have ``run_together`` and ``TRACED``, the names of
    numbers that one compiled call takes many values of: then runs that differ in these alone are
    made in one call.

    Raises:
        ConfigError: no such module, or one that is no experiment.
    """
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    try:
        module = importlib.import_module(name)
        together = getattr(module, "run_together", None)
        traced = tuple(module.TRACED) if together else ()
        return Swept(run=module.run, kind=module.Config, traced=traced, run_together=together)
    except (ModuleNotFoundError, AttributeError, ValueError) as error:
        expected = "the module of an experiment, such as experiments.avoidance.success"
        raise ConfigError(got=f"{quoted(name)} ({error})", expected=expected) from None


def read_setting(text: str, argument: str, *, ends: bool = False) -> Setting:
    """``key=[…]`` as a key and what the list has.

    Args:
        text: as it was written.
        argument: for messages.
        ends: there are two numbers, the second larger.

    Raises:
        ConfigError: something else.
    """
    key, _, listed = text.partition("=")
    try:
        values = tomllib.loads(f"x = {listed}")["x"]
    except tomllib.TOMLDecodeError:
        values = None
    if not isinstance(values, list) or not values or not key.strip():
        raise ConfigError(got=quoted(text), expected="key=[value, value, …]", place=argument)
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
    if ends and not (numbers and len(values) == 2 and values[0] < values[1]):
        raise ConfigError(got=quoted(text), expected="key=[low, high]", place=argument)
    return key.strip(), tuple(values)


def combinations(
    grid: Sequence[Setting], draws: Sequence[Setting] = (), *, samples: int = 1, seed: int = 0
) -> list[dict[str, Any]]:
    """What each run sets: all combinations of the grid, each with as many draws.

    Drawn are uniform numbers between both ends; whole ones, both ends among them, where these are.
    The same seed draws the same, and more samples begin with those of fewer.
    """
    rng = np.random.default_rng(seed)
    drawn = [{key: _draw(rng, *ends) for key, ends in draws} for _ in range(samples)]
    keys = [key for key, _ in grid]
    return [
        dict(zip(keys, values, strict=True)) | one
        for one in drawn
        for values in itertools.product(*(values for _, values in grid))
    ]


def _draw(rng: np.random.Generator, low: Any, high: Any) -> Any:
    if isinstance(low, int) and isinstance(high, int):
        return int(rng.integers(low, high, endpoint=True))
    return float(rng.uniform(low, high))


def sweep(
    name: str,
    base: object,
    settings: Sequence[Mapping[str, Any]],
    out: str | Path,
    *,
    executor: Executor,
    progress: bool = False,
) -> tuple[int, int]:
    """Runs an experiment with each of some settings, those that the file lacks.

    A line is on disk as soon as its run is over, and says ``experiment``, ``fingerprint``,
    ``config.…``, ``metrics.…``, ``timings.…`` and ``seconds``: a table for polars or duckdb. It is
    found again by its fingerprint: settings, inputs, programs and versions. A line that was being
    written when the process ended is cut off; lines of other runs stay. Runs that are made together
    (:func:`found_experiment`) say how many shared the call as ``together``; their ``seconds`` are
    equal shares of its time.

    Args:
        name: module of the experiment.
        base: its config, which the settings change.
        settings: by dotted key.
        out: the file, JSON lines.
        executor: of the runs.
        progress: shows a bar with the time left.

    Returns:
        How many runs were made now, and how many were there.

    Raises:
        ConfigError: a key that the config lacks, or a value that does not fit it.
        FileFormatError: the file has other lines.
        WorkerError: a worker ended; finished runs stay in the file.
    """
    experiment = found_experiment(name)
    configs = [_set(base, some) for some in settings]
    keys = _fingerprints(experiment.run, configs)
    there = known_lines(out)
    missing = {key: config for key, config in zip(keys, configs, strict=True) if key not in there}
    label = ".".join(name.split(".")[-2:]).replace(".", "/")
    bar = tqdm(total=len(set(keys)), initial=len(set(keys)) - len(missing), disable=not progress)
    with bar:
        lots = _lots(experiment, missing)
        tasks = ((name, [missing[key] for key in lot]) for lot in lots)
        for number, rows in run_all(executor, run_lot, tasks):
            for key, found in zip(lots[number], rows, strict=True):
                settings_ = plain(settings_of(missing[key]), "config")
                row = {"experiment": label, "fingerprint": key, "config": settings_}
                append_line(out, flat(row | found))
            bar.update(len(rows))
    return len(missing), len(set(keys)) - len(missing)


def _lots(experiment: Swept, configs: Mapping[str, Any]) -> list[list[str]]:
    """The names of configs, those together that differ in traced settings only."""
    alike: dict[str, list[str]] = {}
    for name, config in configs.items():
        fixed = plain(settings_of(config), "config")
        for key in experiment.traced:
            *tables, last = key.split(".")
            functools.reduce(operator.getitem, tables, fixed)[last] = None
        alike.setdefault(json.dumps(fixed) if experiment.traced else name, []).append(name)
    return [names[i : i + LOT] for names in alike.values() for i in range(0, len(names), LOT)]


def run_lot(task: tuple[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """Metrics, timings and seconds of runs that are made in one call, in whatever process."""
    name, configs = task
    experiment = found_experiment(name)
    begun = time.perf_counter()
    if experiment.run_together is None:
        found: Sequence[Results] = [measured(experiment.run, config) for config in configs]
    else:
        found = experiment.run_together(configs)
    seconds = round((time.perf_counter() - begun) / len(found), 4)
    together = {} if experiment.run_together is None else {"together": len(found)}
    return [
        {
            "metrics": plain(results.metrics),
            "timings": plain(results.timings, "timings"),
            "seconds": seconds,
        }
        | together
        for results in found
    ]


def known_lines(path: str | Path) -> set[str]:
    """Fingerprints of the runs in a file, whose last line is cut off if it is not whole."""
    path = Path(path)
    data = path.read_bytes() if path.exists() else b""
    whole = data[: data.rfind(b"\n") + 1]
    try:
        found = {json.loads(line)["fingerprint"] for line in whole.splitlines()}
    except (ValueError, KeyError, TypeError):
        raise FileFormatError(path, None, "other lines", "a file of a sweep, or none") from None
    if len(whole) < len(data):
        os.truncate(path, len(whole))
    return found


def _set(base: T, settings: Mapping[str, Any]) -> T:
    for key, value in settings.items():
        base = changed(base, key, Words(toml_value(value)), "sweep")
    return base


def _fingerprints(run: Callable[..., Results], configs: Sequence[Any]) -> list[str]:
    """Of each run; files that several read are hashed once."""
    made_of = {"sources": sources_of(run), "versions": versions()}
    read: dict[Any, dict[str, str]] = {}
    keys = []
    for config in configs:
        paths = tuple(getattr(config, name, None) for name in INPUTS)
        if paths not in read:
            read[paths] = inputs_of(config)
        settings = plain(settings_of(config), "config")
        keys.append(fingerprint(run.__module__, settings, made_of | {"inputs": read[paths]}))
    return keys
