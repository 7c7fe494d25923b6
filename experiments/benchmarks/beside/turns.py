"""A peer and mgjax measured in turns: A B A B …, so that a ratio comes from one run."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from experiments.benchmarks.beside import serve
from experiments.benchmarks.beside.calls import turn, warmed
from experiments.benchmarks.beside.environments import Unavailable, one_line
from experiments.benchmarks.beside.types import Job, Peer

ROOT = Path(__file__).resolve().parents[3]


class Half:
    """The process of a peer's half."""

    def __init__(self, process: subprocess.Popen[str], notes: Any, limit_s: float) -> None:
        self.process, self.notes, self.limit_s = process, notes, limit_s

    def ask(self, **asked: Any) -> dict[str, Any]:
        """Its answer.

        Raises:
            Unavailable: it failed, ended, or took too long.
        """
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        late = threading.Event()

        def end() -> None:
            late.set()
            self.process.kill()

        timer = threading.Timer(self.limit_s, end)
        timer.start()
        try:
            self.process.stdin.write(json.dumps(asked) + "\n")
            self.process.stdin.flush()
            line = self.process.stdout.readline()
        except BrokenPipeError:
            line = ""
        finally:
            timer.cancel()
        if not line:
            slow = f"no answer within {self.limit_s:g} s"
            raise Unavailable(slow if late.is_set() else self._last_words())
        answer = json.loads(line)
        if "failed" in answer:
            raise Unavailable(one_line(answer["failed"]))
        return answer

    def _last_words(self) -> str:
        self.process.wait()
        self.notes.seek(0)
        said = [line for line in self.notes.read().splitlines() if line.strip()]
        return one_line(said[-1]) if said else f"exit status {self.process.returncode}"


@contextmanager
def half(peer: Peer, python: Path, limit_s: float) -> Iterator[Half]:
    """A process with the peer's half, ended with the block."""
    module = peer.theirs.__name__
    words = [str(python), "-m", serve.__name__, module, *peer.distributions]
    kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    kept |= {"PYTHONNOUSERSITE": "1", "JAX_PLATFORMS": "cpu"}
    with tempfile.TemporaryFile("w+", encoding="utf-8") as notes:
        process = subprocess.Popen(
            words,
            cwd=ROOT,
            env=kept,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=notes,
            text=True,
        )
        try:
            yield Half(process, notes, limit_s)
        finally:
            process.kill()
            process.communicate()


def in_turns(job: Job, other: Half, turns: int, least_s: float) -> dict[str, Any]:
    """Measures a peer and mgjax, the peer first, after both have done all of the work once.

    Returns:
        ``metrics`` (what was met by each, versions) and ``timings``: of each ``median_s`` and
        ``quartiles_s`` of all calls, per item, ``first_call_s`` and ``turns_s``, the median of each
        turn; ``ratios``, theirs over ours of each turn, their median and quartiles.
    """
    begun = {"theirs": other.ask(work=job.data), "ours": warmed(job.ours)}
    taken: dict[str, list[np.ndarray]] = {"theirs": [], "ours": []}
    for _ in range(turns):
        answer = other.ask(least_s=least_s)
        taken["theirs"].append(np.array(answer["seconds"]) / job.each)
        taken["ours"].append(np.array(turn(job.ours, least_s)) / job.each)
    timings: dict[str, Any] = {
        side: _times(times) | {"first_call_s": begun[side]["first_call_s"]}
        for side, times in taken.items()
    }
    ratios = np.divide(timings["theirs"]["turns_s"], timings["ours"]["turns_s"])
    timings |= {"ratio": float(np.median(ratios)), "ratio_quartiles": _quartiles(ratios)}
    timings["ratios"] = ratios.tolist()
    metrics: dict[str, Any] = {
        side: {
            "met": float(np.mean(np.array(begun[side]["misses"]) <= job.tolerance)),
            "largest_miss": float(np.max(begun[side]["misses"])),
        }
        for side in taken
    }
    metrics |= {"tolerance": job.tolerance, "items": job.ours.count, "each": job.each}
    return {"metrics": metrics | {"versions": begun["theirs"]["versions"]}, "timings": timings}


def _times(times: list[np.ndarray]) -> dict[str, Any]:
    every = np.concatenate(times)
    return {
        "median_s": float(np.median(every)),
        "quartiles_s": _quartiles(every),
        "turns_s": [float(np.median(each)) for each in times],
    }


def _quartiles(values: np.ndarray) -> list[float]:
    return [float(q) for q in np.percentile(values, [25, 75])]
