"""How large compiled programs are: operations that are lowered, without compiling or running."""

from __future__ import annotations

import importlib
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import jax
import pytest

KEPT = Path(__file__).with_suffix(".json")
SLACK = 0.25
"""A program that grows by more was blown up; one that shrinks by more has a new figure to keep."""


class _LoweredError(Exception):
    """Ends a call as soon as its program is known."""


def operations(function: Any, *arguments: Any, **named: Any) -> int:
    """Operations of a jitted function in StableHLO, those of functions it calls once each."""
    text = function.lower(*arguments, **named).as_text()
    return len(re.findall(r"^\s*(?:%\S+ = )?\"?(?:stablehlo|chlo|func\.call|call)\b", text, re.M))


def operations_within(place: str, call: Callable[[], Any]) -> int:
    """The same of a jitted function, as a call that reaches it would run it.

    Args:
        place: module and name, with a dot.
        call: is ended where it calls that function.
    """
    module, _, name = place.rpartition(".")
    jitted = getattr(importlib.import_module(module), name)
    found: list[int] = []

    def noted(*arguments: Any, **named: Any) -> NoReturn:
        found.append(operations(jitted, *arguments, **named))
        raise _LoweredError

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(place, noted)
        with pytest.raises(_LoweredError):
            call()
    return found[0]


def check(name: str, count: int) -> None:
    """Compares a count with the one that is kept for this version of jax.

    Other versions lower to other operations, so only their order of magnitude is checked.
    """
    kept = json.loads(KEPT.read_text())
    known, slack = kept["operations"][name], SLACK if jax.__version__ == kept["jax"] else 1.0
    assert known / (1 + slack) <= count <= known * (1 + slack), (name, count, known)
