"""The order of arguments that CONTRIBUTING.md states, of every public function of every room."""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

SETTINGS = "by name, unless it is the last and must be given"
ROOMS = ("avoidance", "ballsport", "clips", "graph", "hybrid", "quality")
PAGE = Path(__file__).resolve().parent.parent / "CONTRIBUTING.md"


def places() -> dict[str, list[str]]:
    """The table under "Arguments": names of arguments by their place."""
    section = PAGE.read_text("utf-8").split("\n## Arguments\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (.+?) \| (.+?) \|$", section, re.MULTILINE)[1:]
    return {place: re.findall(r"`(\w+)`", names) for place, names in rows if "`" in names}


def public_functions() -> Iterator[tuple[str, Callable[..., object]]]:
    for room in ROOMS:
        module = importlib.import_module(f"mgjax.{room}")
        for name in dir(module):
            found = getattr(module, name)
            function = inspect.unwrap(found) if callable(found) else found
            if inspect.isfunction(function) and not name.startswith("_"):
                yield f"{room}.{name}", function


FUNCTIONS = dict(public_functions())


def test_the_table_is_read() -> None:
    assert list(places()) == ["first", "then", "config", SETTINGS]
    assert all(places().values())
    assert len(FUNCTIONS) > 50


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_order(name: str) -> None:
    given = inspect.signature(FUNCTIONS[name]).parameters.values()
    empty = inspect.Parameter.empty
    by_place = [p.name for p in given if p.kind is p.POSITIONAL_OR_KEYWORD]
    by_name = [p.name for p in given if p.kind is p.KEYWORD_ONLY]
    assert all(p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY) for p in given)
    table = places()
    files = [argument for argument in by_place if argument in table["first"]]
    assert by_place[: len(files)] == files
    data = [argument for argument in by_place if argument in table["then"]]
    assert by_place[len(files) :][: len(data)] == data
    assert len(data) < 2
    (config,) = table["config"]
    if config in by_place:
        assert by_place[-1] == config
    if not name.split(".")[1].startswith("save_"):  # what is saved is no setting
        early = by_place
        if early and inspect.signature(FUNCTIONS[name]).parameters[early[-1]].default is empty:
            early = early[:-1]
        assert not set(early) & set(table[SETTINGS])
    known = [config, *table[SETTINGS]]
    order = [argument for argument in by_name if argument in known]
    assert order == sorted(order, key=known.index)
