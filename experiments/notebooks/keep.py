"""Executes the notebooks at full size and keeps what they show; ``make notebooks``.

The script of each pair is what counts: the notebook is made anew from it. A thing that shows itself
is kept twice, as its player and after it as the moving picture, since pages that run no scripts
leave the player out. Only pictures, players and text are kept, no times of execution.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path
from typing import Any

import jupytext
import nbformat
from nbclient import NotebookClient

from mgjax.core.errors import OutputError
from mgjax.io.output import replace_file

FOLDER = Path(__file__).resolve().parent.parent.parent / "notebooks"
MOST_BYTES = 1_500_000
KEPT = ("text/plain", "text/html", "image/png")
PATH = re.compile(r"(?<![\w.:/<])/(?:home|root|tmp|work|usr|var|Users|opt|mnt)/\w")
"""An absolute path of some machine."""


def execute(script: Path) -> nbformat.NotebookNode:
    """The notebook of a script, executed from its first cell to its last one."""
    notebook = jupytext.read(script)
    client = NotebookClient(notebook, timeout=3600, kernel_name="python3")
    client.execute(cwd=str(script.parent))
    return notebook


def cleaned(notebook: nbformat.NotebookNode, name: str) -> nbformat.NotebookNode:
    """The notebook with what is to be kept of it.

    Raises:
        OutputError: it has a warning, an error or a path of this machine.
    """
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"{name}-{number}"
        cell["metadata"] = {}
        if cell.cell_type != "code":
            continue
        cell["outputs"] = [kept for output in cell.outputs for kept in _kept(output, name)]
        for output in cell.outputs:
            text = output.get("text", "") + output.get("data", {}).get("text/plain", "")
            if PATH.search(text):
                raise OutputError(got=f"a path in {text:.200}", expected="none", place=name)
    return notebook


def _kept(output: Any, name: str) -> list[Any]:
    if output.output_type == "stream":
        if output.name != "stdout":
            raise OutputError(got=output.text[:300], expected="no warnings", place=name)
        return [output]
    if output.output_type == "error":
        raise OutputError(got=output.evalue, expected="no error", place=name)
    data = {kind: output.data[kind] for kind in KEPT if kind in output.data}
    if {"text/html", "image/png"} <= data.keys():
        picture = {kind: data[kind] for kind in ("image/png", "text/plain")}
        del data["image/png"]
        return [nbformat.v4.new_output("display_data", data=each) for each in (data, picture)]
    return [nbformat.v4.new_output("display_data", data=data)]


def main() -> None:
    """Executes those that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="such as 00_start; default: all")
    names = parser.parse_args().names or sorted(file.stem for file in FOLDER.glob("[0-9]*.py"))
    os.environ.pop("MGJAX_NOTEBOOK_SMOKE", None)
    os.environ["TF_CPP_MIN_LOG_LEVEL"] = "3"
    for name in names:
        notebook = cleaned(execute(FOLDER / f"{name}.py"), name)
        text = nbformat.writes(notebook) + "\n"
        if len(text.encode()) > MOST_BYTES:
            raise OutputError(
                got=f"{len(text.encode()):,} bytes", expected=f"{MOST_BYTES:,}", place=name
            )
        replace_file(FOLDER / f"{name}.ipynb", text)
        print(f"{name}: {len(text.encode()) / 1e6:.2f} MB", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
