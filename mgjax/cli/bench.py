"""``mgjax bench``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import mgjax
from mgjax.cli.arguments import Bench
from mgjax.cli.report import emit, to_json
from mgjax.core.errors import ConfigError
from mgjax.core.xla.compilation import one_thread
from mgjax.io.output import output_folder
from mgjax.runs.record import load_average, machine, revision, versions


def run(command: Bench) -> None:
    """Measures and prints rows."""
    if command.files and command.what != "compare":
        raise ConfigError(got=f"bench {command.what} with files", expected="them for compare only")
    made = {"all": _all, "compare": _compare, "selection": _selection}.get(command.what, _kernels)
    result, lines = made(command)
    if command.what != "compare":
        commit, dirty = revision(Path(mgjax.__file__).parent)
        result |= {"git_revision": commit, "git_dirty": dirty}
        result |= {"versions": versions(), "machine": machine(), "load_average": load_average()}
    if command.out is not None:
        with output_folder(command.out) as folder:
            (folder / "bench.json").write_text(to_json(result) + "\n")
    emit(result, lines, as_json=command.json)


def _all(command: Bench) -> tuple[dict[str, Any], list[str]]:
    from mgjax.bench.cases import cases, named
    from mgjax.bench.measuring import case_rows, exponents
    from mgjax.graph.files import load_graph
    from mgjax.graph.fingerprint import fingerprint

    one_thread()
    if command.repeats < 2:
        raise ConfigError(got=f"--repeats {command.repeats}", expected="2 or more")
    if command.sizes is not None and command.sizes < 1:
        raise ConfigError(got=f"--sizes {command.sizes}", expected="1 or more")
    graph = None if command.graph is None else load_graph(command.graph)
    known = cases(graph)
    found = named(known, command.only)
    if not found:
        names = ", ".join(dict.fromkeys(case.name for case in known))
        raise ConfigError(
            got=f"--only {' '.join(command.only)}", expected=f"part of one of {names}"
        )
    rows = case_rows(
        found, repeats=command.repeats, most=command.sizes, progress=sys.stderr.isatty()
    )
    powers = exponents(rows)
    lines = [
        f"{row['case']:32} {row['size']:>6} {row['axis']:10} {1000 * row['median_s']:10.3f} ms"
        f" ({1000 * row['quartiles_s'][0]:.3f} … {1000 * row['quartiles_s'][1]:.3f}), compile"
        f" {row['compile_s']:.2f} s, {row['time_ratio']:.3g} x a bare pass"
        + (f", {row['peak_memory_mb']:.0f} MB" if row["peak_memory_mb"] else "")
        for row in rows
    ]
    lines += [f"{p['case']}: time grows with {p['axis']} ^ {p['exponent']:.2f}" for p in powers]
    key = None if graph is None else fingerprint(graph)
    return {"rows": rows, "exponents": powers, "graph": key}, lines


def _compare(command: Bench) -> tuple[dict[str, Any], list[str]]:
    from mgjax.bench.compare import compare, differ, load_bench

    if len(command.files) != 2:
        raise ConfigError(got=f"{len(command.files)} files", expected="two: bench compare A B")
    a, b = (load_bench(path) for path in command.files)
    rows = compare(a, b)
    if not rows:
        raise ConfigError(got="no case that both have", expected="two runs with the same --only")
    lines = [
        f"{row['case']:32} {row['size']:>6} {row['axis']:10} x {row['ratio']:.2f}"
        f" ({row['interval'][0]:.2f} … {row['interval'][1]:.2f})  {row['verdict']}"
        for row in rows
    ]
    other = differ(a, b)
    if other:
        lines.append(f"they differ in: {', '.join(other)}")
    return {"rows": rows, "differ": list(other)}, lines


def _kernels(command: Bench) -> tuple[dict[str, Any], list[str]]:
    from mgjax.bench.graph import build_rows, distance_rows

    rows = distance_rows() if command.what == "distance" else build_rows()
    lines = [
        f"{row['case']}: {1000 * row['median_s']:.1f} ms (quartiles"
        f" {1000 * row['quartiles_s'][0]:.1f} … {1000 * row['quartiles_s'][1]:.1f}), compile"
        f" {row['compile_s']:.2f} s, {row['time_ratio']:.2f} x the time of a bare product, ratio"
        f" {row['ratio']:.2f}"
        for row in rows
    ]
    return {"rows": rows}, lines


def _selection(command: Bench) -> tuple[dict[str, Any], list[str]]:
    from mgjax.avoidance.index.build import build_index
    from mgjax.avoidance.index.files import FILE_NAME, load_index
    from mgjax.bench.selection import selection_rows
    from mgjax.graph.files import load_graph

    one_thread()
    if command.graph is None:
        raise ConfigError("got no --graph, expected the folder of a graph for bench selection")
    folder = Path(command.graph)
    graph = load_graph(folder)
    index = load_index(folder, graph) if (folder / FILE_NAME).exists() else build_index(graph)
    result = selection_rows(graph, index, balls=command.balls, progress=sys.stderr.isatty())
    result["index"] = index.report
    lines = [
        f"index {'yes' if row['index'] else 'no '}, slices {'yes' if row['slices'] else 'no '}:"
        f" {row['median_ms']:.2f} ms, p95 {row['p95_ms']:.2f} ms, {row['candidates']:.0f}"
        f" candidates, {100 * row['avoided']:.0f} % avoided, compile {row['compile_s']:.1f} s"
        for row in result["rows"]
    ]
    lines += [
        f"{row['case']}, {row['candidates']:.0f} candidates: {row['median_ms']:.2f} ms"
        + (f", {row['per_attack_ms']:.3f} ms an attack" if "per_attack_ms" in row else "")
        for row in result["figures"]
    ]
    return result, lines
