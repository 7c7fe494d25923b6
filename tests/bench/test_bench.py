"""Cases, rows, growth, and the verdict on two benchmarks."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mgjax.bench.cases import Case, cases, named
from mgjax.bench.compare import compare, differ, load_bench
from mgjax.bench.measuring import case_rows, exponents
from mgjax.cli.main import main
from mgjax.core.errors import FileFormatError


def row(ratios: list[float], size: int = 8, name: str = "a") -> dict[str, Any]:
    return {"case": name, "axis": "frames", "size": size, "ratios": ratios}


def test_rows_of_a_case() -> None:
    asked: list[int] = []
    case = Case(
        name="toy", axis="frames", sizes=(4, 8, 16), items=lambda n: n,
        make=lambda n: lambda: asked.append(n),
    )  # fmt: skip
    rows = case_rows([case], repeats=3, most=2)
    assert asked == [4] * 4 + [8] * 4  # one call compiles
    assert [(r["case"], r["axis"], r["size"]) for r in rows] == [
        ("toy", "frames", 4),
        ("toy", "frames", 8),
    ]
    assert all(len(r["ratios"]) == 3 and r["compile_s"] >= 0 for r in rows)
    assert all(r["time_ratio"] == np.median(r["ratios"]) for r in rows)
    assert all(r["peak_memory_mb"] is None or r["peak_memory_mb"] > 1 for r in rows)


def test_growth() -> None:
    rows = [
        {"case": "a", "axis": "frames", "size": n, "median_s": 3e-6 * n**2} for n in (10, 20, 80)
    ]
    rows.append({"case": "a", "axis": "joints", "size": 5, "median_s": 1.0})
    (found,) = exponents(rows)
    assert (found["case"], found["axis"]) == ("a", "frames")
    assert found["exponent"] == pytest.approx(2.0)


def test_verdicts() -> None:
    rng = np.random.default_rng(0)
    near = (1 + 0.01 * rng.normal(size=(2, 15))).tolist()
    wide = np.exp(rng.normal(size=(2, 5))).tolist()
    a = {"rows": [row(near[0], 1), row(near[0], 2), row(near[0], 3), row(wide[0], 4)]}
    b = {"rows": [
        row((2 * np.array(near[1])).tolist(), 1), row((0.5 * np.array(near[1])).tolist(), 2),
        row(near[1], 3), row(wide[1], 4), row(near[1], 5),
    ]}  # fmt: skip
    found = compare(a, b)
    assert [r["verdict"] for r in found] == ["slower", "faster", "same", "undecided"]
    assert found[0]["ratio"] == pytest.approx(2.0, rel=0.05)
    for r in found:
        assert r["interval"][0] <= r["ratio"] <= r["interval"][1]
    assert compare(a, b) == found
    assert differ({"versions": 1}, {"versions": 2}) == ["versions"]


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, factor in (("a", 1.0), ("b", 3.0)):
        made = {"rows": [row([factor, 1.01 * factor, 0.99 * factor])], "git_revision": name}
        (tmp_path / name).mkdir()
        (tmp_path / name / "bench.json").write_text(json.dumps(made))
    assert main(["bench", "compare", str(tmp_path / "a"), str(tmp_path / "b" / "bench.json")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "x 3.00" in lines[0]
    assert lines[0].endswith("slower")
    assert lines[1] == "they differ in: git_revision"
    (tmp_path / "c").write_text('{"rows": []}')
    with pytest.raises(FileFormatError, match="got other text, expected what mgjax bench all"):
        load_bench(tmp_path / "c")
    for words in (
        ("compare", "a"), ("all", "a"), ("all", "--only", "nothing"), ("all", "--repeats", "1"),
        ("all", "--sizes", "0"), ("compare", str(tmp_path / "a"), str(tmp_path / "c")),
    ):  # fmt: skip
        assert main(["bench", *words]) == 2
        assert capsys.readouterr().err.count("\n") == 1


def test_their_names() -> None:
    found = cases()
    keys = [(case.name, case.axis) for case in found]
    assert len(set(keys)) == len(keys)
    assert {"frames", "joints", "batch", "candidates", "spheres"} <= {axis for _, axis in keys}
    assert {case.name for case in named(found, ["aim"])} == {"ballsport.aim_batch"}
    assert len(named(found, ["joints"])) == 2
    assert all(sorted(case.sizes) == list(case.sizes) for case in found)


@pytest.mark.long
@pytest.mark.parametrize("case", cases(), ids=lambda case: f"{case.name} {case.axis}")
def test_every_case_runs(case: Case) -> None:
    (found,) = case_rows([case], repeats=2, most=1)
    assert found["median_s"] > 0
