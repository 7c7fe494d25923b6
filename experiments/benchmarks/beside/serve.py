"""A peer's half as a process: lines of JSON in, a line of JSON out for each.

    python -m experiments.benchmarks.beside.serve MODULE PACKAGE…

``{"work": {…}}`` sets the work up and does it once; ``{"least_s": …}`` measures one turn. What
fails is answered by ``{"failed": reason}``. What the peer prints goes to stderr.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import json
import os
import platform
import sys
import warnings
from typing import Any

from experiments.benchmarks.beside.calls import Calls, turn, warmed


def main(module: str, packages: list[str]) -> None:
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    warnings.simplefilter("ignore")
    calls: Calls | None = None
    for line in sys.stdin:
        asked = json.loads(line)
        try:
            if calls is None:
                made: Calls = importlib.import_module(module).set_up(**asked["work"])
                answer: Any = {**warmed(made), "versions": versions(packages)}
                calls = made
            else:
                answer = {"seconds": turn(calls, asked["least_s"])}
        except Exception as error:
            answer = {"failed": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), file=answers, flush=True)


def versions(packages: list[str]) -> dict[str, str]:
    """Of Python and of packages, by name."""
    found = {name: importlib.metadata.version(name) for name in packages}
    return {"python": platform.python_version(), **found}


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
