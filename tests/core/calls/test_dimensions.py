"""Shapes against their description."""

from __future__ import annotations

import pytest

from mgjax.core.calls.dimensions import Sizes, fitting


@pytest.mark.parametrize(
    ("dims", "shape"),
    [
        ("", ()),
        ("3", (3,)),
        ("F J 3", (5, 2, 3)),
        ("*b J 3", (2, 3)),
        ("*b J 3", (7, 8, 2, 3)),
        ("... 4", (4,)),
        ("J J", (2, 2)),
        ("_ _", (2, 3)),
        ("J+1", (9,)),
    ],
)
def test_fits(dims: str, shape: tuple[int, ...]):
    assert fitting(dims)(shape, "x", {}) == ""


@pytest.mark.parametrize(
    ("dims", "shape", "words"),
    [
        ("3", (2,), " (2 where 3 belong)"),
        ("F J 3", (5, 3), " (3 dimensions)"),
        ("*b J 3", (3,), " (2 dimensions)"),
        ("J J", (2, 3), " with J = 2, as x has"),
    ],
)
def test_says_what_does_not_fit(dims: str, shape: tuple[int, ...], words: str):
    assert fitting(dims)(shape, "x", {}) == words


def test_sizes_are_those_of_arguments_before():
    sizes: Sizes = {}
    assert fitting("*b J 3")((4, 5, 2, 3), "joints", sizes) == ""
    assert sizes == {"b": ((4, 5), "joints"), "J": (2, "joints")}
    assert fitting("*b 3")((4, 6, 3), "target", sizes) == " with b = [4, 5], as joints has"
    assert fitting("J")((3,), "weights", sizes) == " with J = 2, as joints has"
