"""What a run was: revision, versions, machine, times; and lines of JSON."""

from __future__ import annotations

import importlib.metadata
import json
import math
import os
import platform
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jax.monitoring
import numpy as np

import mgjax
from mgjax.core.errors import OutputError, printable
from mgjax.io.text import reason

PACKAGES = ("jax", "jaxlib", "numpy", "scipy")
COMPILE_EVENTS = "/jax/core/compile/"
"""Tracing, lowering and compiling (or loading from the cache) of each program report under it."""
BACKEND_EVENT = "/jax/core/compile/backend_compile_duration"
LOAD_EVENT = "/jax/compilation_cache/cache_retrieval_time_sec"


@dataclass(kw_only=True)
class CompileTimes:
    """What jax reported while a run went on.

    Attributes:
        spans: seconds since the epoch at which a step of a compilation began and ended.
        programs: how many were asked for; each is compiled or loaded.
        loaded: how many of them came from the persistent cache.
        load_s: seconds that this took.
    """

    spans: list[tuple[float, float]] = field(default_factory=list)
    programs: int = 0
    loaded: int = 0
    load_s: float = 0.0

    @property
    def seconds(self) -> float:
        """Time in which anything was traced, lowered, compiled or loaded; nested spans once."""
        total, until = 0.0, -math.inf
        for start, end in sorted(self.spans):
            total += max(end - max(start, until), 0.0)
            until = max(until, end)
        return total


@contextmanager
def compile_times() -> Iterator[CompileTimes]:
    """Listens to jax's compilations, in any thread, until the block ends."""
    times = CompileTimes()

    def on_span(event: str, start_time: float, end_time: float, **_: Any) -> None:
        if event.startswith(COMPILE_EVENTS):
            times.spans.append((start_time, end_time))
            times.programs += event == BACKEND_EVENT

    def on_duration(event: str, duration_secs: float, **_: Any) -> None:
        if event == LOAD_EVENT:
            times.loaded += 1
            times.load_s += duration_secs

    jax.monitoring.register_event_time_span_listener(on_span)
    jax.monitoring.register_event_duration_secs_listener(on_duration)
    try:
        yield times
    finally:
        jax.monitoring.unregister_event_time_span_listener(on_span)
        jax.monitoring.unregister_event_duration_listener(on_duration)


def revision(folder: str | Path) -> tuple[str | None, bool | None]:
    """Git revision of the repository that holds ``folder``, and whether files differ from it.

    New files that git does not ignore count as a difference. (None, None) outside a repository,
    without git, or before the first commit.
    """
    answers: list[str] = []
    for words in (["rev-parse", "HEAD"], ["status", "--porcelain"]):
        command = ["git", "--no-optional-locks", "-C", str(folder), *words]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
        except (OSError, subprocess.SubprocessError):
            return None, None
        answers.append(done.stdout.strip())
    return answers[0], bool(answers[1])


def versions() -> dict[str, str]:
    """Versions of Python and of the packages on which results depend."""
    installed = {name: importlib.metadata.version(name) for name in PACKAGES}
    return {"python": platform.python_version(), **installed, "mgjax": mgjax.__version__}


def machine() -> dict[str, Any]:
    """The kind of machine, without anything that names this one or its user."""
    affinity = getattr(os, "sched_getaffinity", None)
    try:
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    except (AttributeError, ValueError, OSError):
        memory = None
    return {
        "cpu": _cpu_model(),
        "cores": os.cpu_count(),
        "cores_usable": len(affinity(0)) if affinity else os.cpu_count(),
        "memory_gb": None if memory is None else round(memory, 1),
        "os": f"{platform.system()} {platform.release().partition('-')[0]}",
        "architecture": platform.machine(),
        "jax_backend": jax.default_backend(),
        "jax_devices": jax.device_count(),
    }


def load_average() -> float | None:
    """Processes that ran or waited for a processor in the last minute; None where none says so."""
    return round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None


def _cpu_model() -> str | None:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.lower().startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or None


def plain(value: Any, place: str = "metrics") -> Any:
    """The value as JSON has it: NumPy's numbers and arrays become Python's, NaN and ±inf None.

    Raises:
        TypeError: something that JSON has no form for; says where it is.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise TypeError(f"{place}: got key {key!r}, expected a string")
        return {key: plain(item, f"{place}.{key}") for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item, f"{place}[{i}]") for i, item in enumerate(value)]
    raise TypeError(f"{place}: got {type(value).__name__}, expected what JSON can hold")


def flat(value: Any, prefix: str = "") -> dict[str, Any]:
    """Nested tables as one, with dotted keys; lists are left out. A row for polars or duckdb."""
    row: dict[str, Any] = {}
    for key, item in value.items():
        if isinstance(item, Mapping):
            row |= flat(item, f"{prefix}{key}.")
        elif not isinstance(item, list | tuple):
            row[prefix + key] = item
    return row


def append_line(path: str | Path, row: Mapping[str, Any]) -> None:
    """Adds one JSON line to a file, in a single write that is on disk when this returns."""
    line = json.dumps(plain(row, "row"), allow_nan=False).encode() + b"\n"
    with _opened(path) as file:
        file.write(line)
        file.flush()
        os.fsync(file.fileno())


def check_appendable(path: str | Path) -> None:
    """Raises :class:`OutputError` where :func:`append_line` would, before long work."""
    _opened(path).close()


def _opened(path: str | Path) -> Any:
    try:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        return open(path, "ab", buffering=0)
    except (OSError, ValueError) as error:
        raise OutputError(
            f"{printable(path)}: cannot be written ({reason(error)}), expected a writable file"
        ) from None
