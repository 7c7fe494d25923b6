"""``mgjax bench``."""

from __future__ import annotations

from mgjax.cli.commands import Bench
from mgjax.cli.report import emit, to_json
from mgjax.io.output import output_folder
from mgjax.runs.benchmarks import build_rows, distance_rows


def run(command: Bench) -> None:
    """Measures and prints rows."""
    rows = distance_rows() if command.what == "distance" else build_rows()
    result = {"rows": rows}
    if command.out is not None:
        with output_folder(command.out) as folder:
            (folder / "bench.json").write_text(to_json(result) + "\n")
    lines = [
        f"{row['case']}: {1000 * row['median_s']:.1f} ms (quartiles"
        f" {1000 * row['quartiles_s'][0]:.1f} … {1000 * row['quartiles_s'][1]:.1f}), compile"
        f" {row['compile_s']:.2f} s, {row['time_ratio']:.2f} x the time of a bare product, ratio"
        f" {row['ratio']:.2f}"
        for row in rows
    ]
    emit(result, lines, as_json=command.json)
