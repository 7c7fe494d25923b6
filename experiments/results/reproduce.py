"""Runs every experiment at full size and writes RESULTS.md and the figures of README.md.

    python -m experiments.results.reproduce --capture FOLDER

Each run leaves a small record beside its results. At the end all are copied to
``experiments/records``, so that each is of the programs as they were at the beginning; from there
alone the documents are written. An experiment whose record is of the same settings, inputs,
programs and versions is not run again; one that was interrupted goes on. Without capture those
that need it are left out.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from experiments.results.documents import write_documents
from experiments.results.plan import PLAN, Planned
from mgjax.io.output import replace_file

ROOT = Path(__file__).resolve().parents[2]
RECORDS = ROOT / "experiments" / "records"


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit status: 1 where an experiment failed, 2 for bad input."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])  # type: ignore[union-attr]
    add = parser.add_argument
    add("--capture", type=Path, help="folder of the motion capture; default: MGJAX_CAPTURE")
    add("--out", type=Path, default=Path("out/reproduce"), help="folder of all results")
    add("--records", type=Path, default=RECORDS, help="folder of the records")
    add("--only", action="append", default=[], metavar="NAME", help="run those of this name only")
    add("--smoke", action="store_true", help="tiny versions of them, to see that they run")
    add("--no-documents", action="store_true", help="leave RESULTS.md and README.md as they are")
    options = parser.parse_args(arguments)
    named = options.capture or os.environ.get("MGJAX_CAPTURE")
    capture = Path(named).expanduser().resolve() if named else None
    if capture is not None and not capture.is_dir():
        print(f"reproduce: got {capture}, expected a folder of motion capture", file=sys.stderr)
        return 2
    if options.smoke:
        capture, options.records = None, options.out / "records"
    wanted = [p for p in PLAN if not options.only or {p.record, p.experiment} & {*options.only}]
    if not wanted:
        known = ", ".join(planned.record for planned in PLAN)
        print(f"reproduce: got --only {options.only}, expected of {known}", file=sys.stderr)
        return 2
    try:
        failed = [p.record for p in wanted if not _run(p, capture, options)]
    finally:
        for planned in [] if options.smoke else wanted:
            _keep(options.out, options.records, planned)
    if not options.no_documents and not options.smoke:
        write_documents(ROOT, options.records)
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def _keep(out: Path, records: Path, planned: Planned) -> None:
    """Copies the record of a run that ended."""
    name = f"{planned.record}.json"
    if (out / "records" / name).is_file():
        records.mkdir(parents=True, exist_ok=True)
        replace_file(records / name, (out / "records" / name).read_bytes())


def _run(planned: Planned, capture: Path | None, options: argparse.Namespace) -> bool:
    """Runs one in a process of its own; whether it went well, or was left out."""
    label = f"{planned.record:32}"
    if planned.clips and capture is None and not options.smoke:
        print(f"{label} left out: it needs motion capture (--capture)", flush=True)
        return True
    words = planned.words(ROOT, capture, options.out)
    words += ["--smoke"] if options.smoke else []
    module = f"experiments.{planned.experiment.replace('/', '.')}"
    begun = time.monotonic()
    done = subprocess.run([sys.executable, "-m", module, *words], cwd=ROOT, check=False)
    state = "done" if done.returncode == 0 else f"exit status {done.returncode}"
    print(f"{label} {state}, {time.monotonic() - begun:.0f} s\n", flush=True)
    return done.returncode == 0


if __name__ == "__main__":
    sys.exit(main())
