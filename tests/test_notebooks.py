"""Notebooks are pairs of a notebook and a script; pytest executes them through nbmake."""

from __future__ import annotations

import ast
import importlib
import re
from pathlib import Path
from typing import Any

import jupytext
import nbformat
import pytest

from experiments.notebooks.keep import MOST_BYTES, PATH, cleaned
from mgjax.core.errors import OutputError

NOTEBOOKS = sorted((Path(__file__).resolve().parent.parent / "notebooks").glob("*.ipynb"))
ROOMS = {"avoidance", "ballsport", "clips", "graph", "hybrid", "pictures", "quality"}


def outputs(file: Path) -> list[Any]:
    return [
        output
        for cell in nbformat.read(file, as_version=4).cells
        if cell.cell_type == "code"
        for output in cell.outputs
    ]


def imports(source: str) -> set[tuple[str, str]]:
    """Modules of this package that a script imports, and the names it takes of them."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {(alias.name, "") for alias in node.names}
        if isinstance(node, ast.ImportFrom):
            found |= {(str(node.module), alias.name) for alias in node.names}
    return {(module, name) for module, name in found if module.split(".")[0] == "mgjax"}


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_pairs(file: Path) -> None:
    notebook, script = jupytext.read(file), jupytext.read(file.with_suffix(".py"))
    assert [(c.cell_type, c.source) for c in notebook.cells] == [
        (c.cell_type, c.source) for c in script.cells
    ]
    assert notebook.metadata.kernelspec == script.metadata.kernelspec
    code = [c for c in notebook.cells if c.cell_type == "code"]
    # Nothing is computed there that belongs into the library.
    lines = [line for c in code for line in c.source.split("\n")]
    assert not any(line.startswith(("def ", "class ")) for line in lines)


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_what_is_kept(file: Path) -> None:
    """Plots and motion, seen also where no script runs; nothing of the machine they came from."""
    kept = outputs(file)
    kinds = {output.output_type for output in kept}
    assert kinds <= {"stream", "display_data"}, "run make notebooks"
    data = [output.data for output in kept if output.output_type == "display_data"]
    assert any("image/png" in each for each in data)
    for each, after in zip(data, data[1:], strict=False):
        if "<iframe" in each.get("text/html", ""):
            assert "image/png" in after, "a player is followed by its picture"
    for output in kept:
        text = output.get("text", "") + output.get("data", {}).get("text/plain", "")
        assert PATH.search(text) is None
        assert " at 0x" not in text
        assert "Warning" not in text
    assert file.stat().st_size <= MOST_BYTES


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_public_names_only(file: Path) -> None:
    source = file.with_suffix(".py").read_text()
    found = imports(source)
    assert found
    for module, name in found:
        parts = module.split(".")
        assert len(parts) == 1 or (len(parts) == 2 and parts[1] in ROOMS), module
        if name:
            assert name in importlib.import_module(module).__all__, f"{module}.{name}"
    assert not re.search(r"\bmgjax\.(?!enable_cache)\w+\.\w+\.", source)


def made(*kept: Any) -> nbformat.NotebookNode:
    cell = nbformat.v4.new_code_cell("1", outputs=list(kept))
    return nbformat.v4.new_notebook(cells=[cell])


def test_a_player_is_kept_with_its_picture_after_it() -> None:
    data = {"text/html": "<iframe>", "image/png": "AA==", "text/plain": "a walk", "x/y": "z"}
    shown = nbformat.v4.new_output("execute_result", data=data, execution_count=3)
    (cell,) = cleaned(made(shown), "n").cells
    assert [sorted(output.data) for output in cell.outputs] == [
        ["text/html", "text/plain"],
        ["image/png", "text/plain"],
    ]
    assert cell.id == "n-0"


@pytest.mark.parametrize(
    "output",
    [
        nbformat.v4.new_output("stream", name="stderr", text="a warning"),
        nbformat.v4.new_output("stream", name="stdout", text="written to /home/someone/walk.bvh"),
        nbformat.v4.new_output("error", ename="ValueError", evalue="no", traceback=[]),
    ],
)
def test_what_is_not_to_be_kept(output: Any) -> None:
    with pytest.raises(OutputError):
        cleaned(made(output), "n")
