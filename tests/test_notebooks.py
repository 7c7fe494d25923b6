"""Notebooks are pairs of a notebook and a script; pytest executes them through nbmake."""

from __future__ import annotations

from pathlib import Path

import jupytext
import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parent.parent / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_pairs(file: Path) -> None:
    notebook, script = jupytext.read(file), jupytext.read(file.with_suffix(".py"))
    assert [(c.cell_type, c.source) for c in notebook.cells] == [
        (c.cell_type, c.source) for c in script.cells
    ]
    assert notebook.metadata.kernelspec == script.metadata.kernelspec
    code = [c for c in notebook.cells if c.cell_type == "code"]
    assert not any(c.outputs or c.execution_count for c in code)
    # Nothing is computed there that belongs into the library.
    lines = [line for c in code for line in c.source.split("\n")]
    assert not any(line.startswith(("def ", "class ")) for line in lines)


def test_there_are_notebooks(request: pytest.FixtureRequest) -> None:
    assert NOTEBOOKS
    assert request.config.pluginmanager.hasplugin("nbmake")
