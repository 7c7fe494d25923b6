"""Public peers beside mgjax: the same work in the same run, in turns, where a peer can be had.

    python -m experiments.benchmarks.peers --environments DIR --only mink pyroki

Each peer has a virtual environment of its own below DIR (default: ``peers`` in mgjax's cache
folder, or ``MGJAX_PEERS``), made where there is none from what the Python package index has; its
half runs there as a process that knows nothing of mgjax, and both halves are given the same
numbers. A turn is all items of the work, again and again for a while: peer, mgjax, peer, mgjax, ….
A peer that cannot be installed or fails is listed with the reason. Without a package index, where
an environment is still to be made, nothing is measured and the exit status is 2.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from experiments.benchmarks.beside import environments
from experiments.benchmarks.beside.environments import Unavailable
from experiments.benchmarks.beside.table import PEERS
from experiments.benchmarks.beside.turns import half, in_turns
from experiments.benchmarks.beside.types import Peer
from mgjax.core.errors import ConfigError
from mgjax.runs.experiment import Results, experiment


@dataclass(frozen=True, kw_only=True)
class Config:
    """Settings."""

    only: tuple[str, ...] = ()
    """Names of peers; none: all."""
    turns: int = 5
    """Of each half."""
    items: int = 30
    """Targets of each work that has some."""
    least_s: float = 0.2
    """Of one turn."""
    limit_s: float = 300.0
    """Longest wait for one answer of a peer."""
    seed: int = 0
    """Of all random numbers."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        """Needs no index: what mgjax needs itself."""
        return {"only": ("scipy.sparse.csgraph",), "turns": 2, "items": 2, "least_s": 0.01}


def run(config: Config) -> Results:
    return compared(chosen(PEERS, config.only), config)


def chosen(peers: Sequence[Peer], only: Sequence[str]) -> list[Peer]:
    """Those of these names, or all."""
    known = [peer.name for peer in peers]
    if strange := [name for name in only if name not in known]:
        raise ConfigError(got=f"only = {strange[0]!r}", expected=f"of {', '.join(known)}")
    return [peer for peer in peers if not only or peer.name in only]


def compared(peers: Sequence[Peer], config: Config) -> Results:
    """Measures all works of peers; what fails does not keep others from being measured."""
    base = environments.folder()
    pythons, failed = {}, []
    for peer in peers:
        try:
            pythons[peer.name] = environments.interpreter(peer, base)
        except Unavailable as error:
            failed.append({"peer": peer.name, "work": "all", "reason": str(error)})
    metrics, timings = [], []
    for peer in peers:
        for name, work in peer.works.items() if peer.name in pythons else ():
            label = {"peer": peer.name, "work": name, "words": work.words}
            try:
                with half(peer, pythons[peer.name], config.limit_s) as other:
                    job = work.make(config.seed, config.items)
                    found = in_turns(job, other, config.turns, config.least_s)
            except Unavailable as error:
                failed.append({"peer": peer.name, "work": name, "reason": str(error)})
                continue
            label["version"] = found["metrics"]["versions"][peer.distributions[0]]
            met = {f"{side}_met": found["metrics"][side]["met"] for side in ("theirs", "ours")}
            metrics.append(label | found["metrics"])
            timings.append(label | found["timings"] | met)
    found = {
        "works": sum(len(peer.works) for peer in peers),
        "measured": len(metrics),
        "rows": metrics,
        "failed": failed,
    }
    return Results(metrics=found, timings={"rows": timings}, lines=lines(timings, failed))


def lines(rows: Sequence[dict[str, Any]], failed: Sequence[dict[str, Any]]) -> tuple[str, ...]:
    """What is printed: a line for each work, and for each that could not be measured."""
    measured = [
        f"{row['peer']} {row['version']}, {row['words']}: {1e6 * row['theirs']['median_s']:.4g} µs,"
        f" mgjax {1e6 * row['ours']['median_s']:.4g} µs, ratio {row['ratio']:.3g}"
        f" ({row['ratio_quartiles'][0]:.3g} to {row['ratio_quartiles'][1]:.3g});"
        f" met {row['theirs_met']:.0%} and {row['ours_met']:.0%}"
        for row in rows
    ]
    missing = [f"{row['peer']}, {row['work']}: not measured: {row['reason']}" for row in failed]
    return (*measured, *missing)


def as_settings(words: Sequence[str]) -> list[str]:
    """The arguments of an experiment; ``--environments`` goes to the environment variable."""
    kept, rest = [], list(words)
    while rest:
        word = rest.pop(0)
        if word == "--environments" and rest:
            os.environ[environments.FOLDER] = rest.pop(0)
        elif word == "--only":
            names = []
            while rest and not rest[0].startswith("--"):
                names.append(rest.pop(0))
            kept += ["--set", f"only={names}"]
        else:
            kept.append(word)
    return kept


if __name__ == "__main__":
    sys.argv[1:] = as_settings(sys.argv[1:])
    experiment(run, Config)
