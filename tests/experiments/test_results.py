"""Documents have no figure but those of records."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments.results.documents import (
    BEGIN,
    END,
    figures_text,
    load_records,
    marked,
    results_text,
    template,
)
from experiments.results.figures import filled, unbacked
from experiments.results.plan import PLAN
from experiments.results.reproduce import RECORDS, ROOT
from mgjax.core.errors import ConfigError

TOY = {
    "toy": {
        "metrics": {
            "mean_m": 0.01234,
            "rows": [{"name": "a", "share": 0.5}, {"name": "b", "share": 1.0}],
            "none": None,
            "1": {"deep": [1.5, 2.0]},
        }
    }
}


def test_figures_are_filled_in() -> None:
    text = filled("{toy[metrics][mean_m]:1e3|.1f} mm, {word}", TOY, {"word": "x"})
    assert text == "12.3 mm, x"
    assert filled("{toy[metrics][1][deep]:.1f}", TOY, {}) == "1.5, 2.0"
    table = "| a |\n@each toy[metrics][rows]\n| {row[name]} | {row[share]:.0%} {key} |\n."
    assert filled(table, TOY, {}) == "| a |\n| a | 50% 0 |\n| b | 100% 1 |\n."
    many = "@each toy[metrics][1]\n{key} {row:.2f}"
    assert filled(many, TOY, {}) == "deep 1.50, 2.00"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{toy[metrics][maen_m]}", "which no record backs, expected .* such as mean_m"),
        ("{toy[metrics][rows][2]}", "which no record backs"),
        ("{toy[metrics][none]}", "of which nothing was measured"),
        ("{other[metrics]}", "there is no record"),
        ("{toy[metrics]}", "a table"),
        ("{toy[metrics][mean_m]:q}", "expected figures in braces"),
        ("@each toy[metrics][mean_m]\n{row}", "expected the path of a list"),
    ],
)
def test_figures_that_no_record_backs(text: str, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        filled(text, TOY, {})


def test_numbers_of_templates_are_found() -> None:
    text = "takes 3 ms, as eq. 7 and Table 1 of §5.1 (paper: 40 s) and `x[1]` say"
    assert unbacked(text) == ["3"]
    table = "| what | paper, ms | here |\n|---|---|---|\n| a 5 | 14 | {a[b]:.1f} of 6 |\n"
    assert unbacked(table) == ["5", "6"]
    assert unbacked("![a](b_1.png)\n@each a[1][2]\n") == []


def test_documents_are_those_of_the_records() -> None:
    """Each figure of RESULTS.md and of the section Figures of README.md is that of a record."""
    records = load_records(RECORDS)
    assert (ROOT / "RESULTS.md").read_text() == results_text(records)
    readme = (ROOT / "README.md").read_text()
    before, inside, after = marked(readme)
    assert inside == figures_text(records)
    assert before.removesuffix(BEGIN).endswith("## Figures\n\n")
    assert after.startswith(END + "\n\n## ")
    for name in ("results", "readme"):
        assert unbacked(template(name)) == []


def test_records_are_of_whole_runs() -> None:
    planned = {planned.record for planned in PLAN}
    assert len(planned) == len(PLAN)
    for file in RECORDS.glob("*.json"):
        assert file.stem in planned
        assert file.stat().st_size < 128_000
    for record in load_records(RECORDS).values():
        assert not record["smoke"]
        assert record["git_revision"]
        assert not record["git_dirty"]


def test_the_plan_names_what_is_there() -> None:
    for planned in PLAN:
        assert (ROOT / "experiments" / f"{planned.experiment}.py").is_file()
        words = planned.words(ROOT, Path("capture"), Path("out"))
        assert words.count("--record") == 1
        assert (f"clips=capture/{planned.clips}" in words) == bool(planned.clips)
