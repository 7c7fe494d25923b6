"""``mgjax bench``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from mgjax.cli.arguments import Bench
from mgjax.cli.report import emit, to_json
from mgjax.core.errors import ConfigError
from mgjax.core.xla.compilation import one_thread
from mgjax.io.output import output_folder


def run(command: Bench) -> None:
    """Measures and prints rows."""
    result, lines = _selection(command) if command.what == "selection" else _kernels(command)
    if command.out is not None:
        with output_folder(command.out) as folder:
            (folder / "bench.json").write_text(to_json(result) + "\n")
    emit(result, lines, as_json=command.json)


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
