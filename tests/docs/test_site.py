"""What the site has beyond the files of ``docs``: links, docstrings, pages of the reference."""

from __future__ import annotations

import importlib
from types import ModuleType

import pytest

import mgjax.avoidance
from tests.docs.pages import ROOT


@pytest.fixture
def making(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The modules by which the site is made."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    for name in ("links", "reference", "docstrings"):
        importlib.import_module(f"making.{name}")
    return importlib.import_module("making")


@pytest.mark.parametrize(
    ("page", "link", "there"),
    [
        ("docs/parry.md", "../experiments/pictures/parry.png", "pictures/parry.png"),
        ("docs/howto/label.md", "../../experiments/pictures/a.png", "../pictures/a.png"),
        ("docs/howto/add_a_room.md", "../../CONTRIBUTING.md", "../CONTRIBUTING.md"),
        ("docs/howto/label.md", "threshold.md", "threshold.md"),
        ("CHANGELOG.md", "docs/scaling.md", "scaling.md"),
        ("CONTRIBUTING.md", "CHANGELOG.md", "CHANGELOG.md"),
        ("docs/parry.md", "../mgjax/core/errors.py", "../mgjax/core/errors.py"),
        ("docs/parry.md", "https://example.org/a.md", "https://example.org/a.md"),
    ],
)
def test_links(making: ModuleType, page: str, link: str, there: str) -> None:
    text = f"[a]({link}#b), `[a]({link})`"
    assert making.links.rewritten(text, page) == f"[a]({there}#b), `[a]({link})`"


def test_an_entry_of_two_parameters_becomes_two(making: ModuleType) -> None:
    text = "What.\n\nArgs:\n    a, b: one\n        and more.\n    c: other.\n"
    expected = (
        "What.\n\nArgs:\n    a: one\n        and more.\n    b: one\n        and more.\n"
        "    c: other.\n"
    )
    assert making.docstrings.one_by_one(text) == expected


def test_the_reference_has_every_public_name(making: ModuleType) -> None:
    page = making.reference.page("avoidance")
    assert all(f"::: mgjax.avoidance.{name}\n" in page for name in mgjax.avoidance.__all__)
    assert page.index("::: mgjax.avoidance.select\n") < page.index("::: mgjax.avoidance.Attack\n")


def test_roles_become_names(making: ModuleType) -> None:
    html = "see :func:<code>~mgjax.clips.folder.load_clips</code> and :class:<code>Clip</code>"
    plain = "see <code>load_clips</code> and <code>Clip</code>"
    assert making.reference.plain_roles(html) == plain
