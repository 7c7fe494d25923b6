"""RESULTS.md and the figures of README.md, written whole from templates and records."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from experiments.results.figures import filled
from experiments.results.plan import PLAN
from mgjax.core.errors import ConfigError, FileFormatError
from mgjax.io.output import replace_file
from mgjax.io.text import read_text
from mgjax.runs.kept import find_records

HERE = Path(__file__).parent
BEGIN = "<!-- figures: written by make reproduce from experiments/results/readme.md -->"
END = "<!-- end of figures -->"


def write_documents(root: Path, records: Path) -> None:
    """Writes RESULTS.md, and the figures between the marks of README.md.

    Raises:
        ConfigError: a figure that no record backs, or a README without the marks.
    """
    known = load_records(records)
    replace_file(root / "RESULTS.md", results_text(known))
    readme = root / "README.md"
    before, _, after = marked(readme.read_text(encoding="utf-8"))
    replace_file(readme, before + figures_text(known) + after)


def results_text(records: Mapping[str, Any]) -> str:
    """RESULTS.md."""
    words = {
        "provenance": provenance(records),
        "missing": missing(records),
        "measured": measured(records),
    }
    return filled(template("results"), records, words)


def figures_text(records: Mapping[str, Any]) -> str:
    """What stands between the marks of README.md."""
    return filled(template("readme"), records, {"measured": measured(records)})


def template(name: str) -> str:
    """The text of a template."""
    return read_text(HERE / f"{name}.md", "template")


def marked(readme: str) -> tuple[str, str, str]:
    """What is before, between and after the marks; the marks belong to the outer parts."""
    before, begin, rest = readme.partition(BEGIN)
    inside, end, after = rest.partition(END)
    if not begin or not end:
        raise ConfigError(got="README.md without its marks", expected=f"{BEGIN} … {END}")
    return before + begin, inside, end + after


def load_records(folder: Path) -> dict[str, Any]:
    """The records in a folder by the name of their script, or of the file where they differ."""
    found: dict[str, Any] = {}
    for path, record in find_records([folder]):
        room, _, script = record["experiment"].partition("/")
        name = script if path.stem == f"{room}_{script}" else path.stem
        if name in found:
            raise FileFormatError(path, None, f"a second record {name}", "one of each name")
        found[name] = record
    return found


def measured(records: Mapping[str, Any]) -> str:
    """When, on what machines and how busy they were."""
    machine = " and ".join(sorted({_machine(record) for record in records.values()}))
    version = _commonest(_versions(record) for record in records.values())
    days = sorted({record["finished"][:10] for record in records.values()})
    when = days[0] if len(days) == 1 else f"{days[0]} to {days[-1]}"
    loads = [load for record in records.values() for load in record["load_average"] if load]
    busy = f", load average {min(loads):.0f} to {max(loads):.0f}" if loads else ""
    return textwrap.fill(f"{when}, {machine}, {version}{busy}", 110)


def missing(records: Mapping[str, Any]) -> str:
    """Planned experiments that have no record, as a list."""
    known = {record["experiment"] for record in records.values()}
    names = [planned.experiment for planned in PLAN if planned.experiment not in known]
    return "\n".join(f"- `{name}`" for name in names) or "- none"


def provenance(records: Mapping[str, Any]) -> str:
    """A table with a line for each record: what was run, on what, and how long it took."""
    lines = [
        "| experiment | sizes and limits (all settings: in the record) | capture | seed | finished"
        " | revision | wall s | of that compiling | CPU s |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for record in (records[name] for name in sorted(records)):
        revision = (record["git_revision"] or "none")[:10]
        revision += " and changes" if record["git_dirty"] else ""
        read = ", ".join(f"{record['config'][k]} `{v[:8]}`" for k, v in record["inputs"].items())
        seeds = record["config"].get("seeds", record["seed"])
        seed = "" if seeds is None else str(seeds).strip("[]")
        seconds = record["seconds"]
        lines.append(
            f"| `{record['experiment']}` | {_settings(record)} | {read} | {seed}"
            f" | {record['finished'][:16]} | `{revision}` | {seconds['wall']:.0f}"
            f" | {seconds['compile']:.0f} | {seconds['cpu']:.0f} |"
        )
    return "\n".join(lines)


def _settings(record: Mapping[str, Any]) -> str:
    """Plain settings of the top level; the record has all of them."""
    shown = [
        f"{key} = {value}"
        for key, value in record["config"].items()
        if isinstance(value, int | float) and not isinstance(value, bool) and key != "seed"
    ]
    return ", ".join(shown)


def _machine(record: Mapping[str, Any]) -> str:
    machine = record["machine"]
    cores, memory = machine["cores_usable"], machine["memory_gb"]
    return (
        f"{machine['cpu']}, {cores} cores shared with other work, {memory} GB,"
        f" jax on {machine['jax_backend']}"
    )


def _versions(record: Mapping[str, Any]) -> str:
    names = {"python": "Python", "jax": "jax", "numpy": "NumPy", "scipy": "SciPy"}
    return ", ".join(f"{shown} {record['versions'][name]}" for name, shown in names.items())


def _commonest(values: Any) -> str:
    return Counter(values).most_common(1)[0][0]
