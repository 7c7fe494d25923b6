"""The finished points of a sweep, kept as they come."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, TypeVar

from mgjax.core.parallel.executors import SerialExecutor
from mgjax.core.parallel.run import run_all
from mgjax.runs.record import append_line, plain

T = TypeVar("T")


class Points:
    """The finished points of a sweep, kept in a file as they come, so that a run can go on.

    The first line of the file says what the run is: experiment, settings, inputs, programs. A file
    that says the same is continued; any other is begun anew, with a note on what differs. A line
    that was being written when the process ended is cut off. Without a file nothing outlives the
    process.

    Attributes:
        executor: of :meth:`measure_all`; by default this process.
        measured, resumed: how many points were measured now, and how many found in the file.
        differs: what the file that was there says otherwise, if it is of another run.
    """

    def __init__(
        self,
        path: str | Path | None = None,
        identity: Any = None,
        executor: Executor | None = None,
    ) -> None:
        self.executor = executor or SerialExecutor()
        self.measured = 0
        self.resumed = 0
        self.differs: tuple[str, ...] = ()
        self._path = None if path is None else Path(path)
        self._header = {"run": plain(identity, "identity")}
        self._rows: dict[str, dict[str, Any]] = {}
        self._begun = self._path is not None and self._read(self._path)

    def _read(self, path: Path) -> bool:
        """Takes over the points of the same run; whether there is such a file."""
        try:
            data = path.read_bytes()
        except OSError:
            return False
        lines = data[: data.rfind(b"\n") + 1]
        try:
            first, *rows = [json.loads(line) for line in lines.splitlines()]
            if first != self._header:
                self.differs = _differing(first["run"], self._header["run"])
                return False
            self._rows = {row["key"]: row for row in rows}
        except (ValueError, KeyError, TypeError):
            return False
        if len(lines) < len(data):
            os.truncate(path, len(lines))
        return True

    def measure(self, key: str, work: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """The result of ``work``, or what it was in an earlier process.

        Args:
            key: names the point; the same key is measured once.
            work: returns JSON values; they come back as JSON has them, either way.
        """
        if key in self._rows:
            self.resumed += 1
            return self._rows[key]["value"]
        start = time.perf_counter()
        value = work()
        return self._add(key, value, time.perf_counter() - start)

    def _add(self, key: str, value: dict[str, Any], seconds: float) -> dict[str, Any]:
        """Keeps a point, and writes it to the file."""
        value = json.loads(json.dumps(plain(value, key), allow_nan=False))
        row = {"key": key, "seconds": round(seconds, 4), "value": value}
        if self._path is not None:
            if not self._begun:
                self._path.unlink(missing_ok=True)
                append_line(self._path, self._header)
                self._begun = True
            append_line(self._path, row)
        self._rows[key] = row
        self.measured += 1
        return value

    def measure_all(
        self, tasks: Mapping[str, T], work: Callable[[T], dict[str, Any]]
    ) -> dict[str, dict[str, Any]]:
        """What :meth:`measure` returns of many points, which the run's executor computes.

        A point is written as soon as it is there; the results are in the order of the tasks.

        Args:
            tasks: by key, what ``work`` is given.
            work: a function of a module, as it may be called in another process.

        Raises:
            WorkerError: a worker ended; finished points stay in the file.
        """
        missing = [key for key in tasks if key not in self._rows]
        begun = time.perf_counter()
        for number, value in run_all(self.executor, work, [tasks[key] for key in missing]):
            seconds = time.perf_counter() - begun
            self._add(missing[number], value, seconds)
            begun = time.perf_counter()
        self.resumed += len(tasks) - len(missing)
        return {key: self._rows[key]["value"] for key in tasks}

    def lines(self) -> str:
        """One JSON line per point."""
        return "".join(json.dumps(row) + "\n" for row in self._rows.values())

    def discard(self) -> None:
        """Removes the file; called when the results of the run are in their place."""
        if self._path is not None:
            self._path.unlink(missing_ok=True)


def _differing(one: Any, other: Any) -> tuple[str, ...]:
    """Keys of two tables whose values differ."""
    if not (isinstance(one, dict) and isinstance(other, dict)):
        return ()
    return tuple(key for key in {**one, **other} if one.get(key) != other.get(key))
