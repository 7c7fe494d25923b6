"""What the user wants, and what becomes of it."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.core.errors import ConfigError
from mgjax.stage.apps.match.wishes import MOST_PICKED, Wishes


def wishes(**values: object) -> Wishes:
    return Wishes(players=["Ana", "Ben", "Cem"], rng=np.random.default_rng(0), **values)  # type: ignore


def test_who_was_clicked_gets_the_ball() -> None:
    made = wishes(kind="attack", bounces="2")
    made.pick("Ben", "Ana")
    made.pick("Cem", "Ana")
    first, second = made.next_pass("Ana"), made.next_pass("Ben")
    assert first is not None
    assert second is not None
    assert (first.by, first.to, first.kind, first.bounces) == ("Ana", "Ben", "attack", 2)
    assert (second.by, second.to) == ("Ben", "Cem")


def test_nobody_passes_to_himself() -> None:
    made = wishes()
    with pytest.raises(ConfigError, match="Ana, who has the ball then"):
        made.pick("Ana", "Ana")
    made.pick("Ben", "Ana")
    with pytest.raises(ConfigError, match="Ben, who has the ball then"):
        made.pick("Ben", "Ana")
    made.pick("Ana", "Ana")
    assert made.picked == ["Ben", "Ana"]


def test_what_is_no_player_or_too_much_is_refused() -> None:
    made = wishes()
    with pytest.raises(ConfigError, match="expected Ana, Ben, Cem"):
        made.pick("Eve", "Ana")
    for k in range(MOST_PICKED):
        made.pick("BenAna"[3 * (k % 2) :][:3], "Ana")
    with pytest.raises(ConfigError, match="up to"):
        made.pick("Cem", "Ana")


def test_on_by_itself_goes_to_the_others() -> None:
    made = wishes()
    passes = [made.next_pass("Ana") for _ in range(40)]
    assert {p.to for p in passes if p} == {"Ben", "Cem"}
    assert {p.bounces for p in passes if p} == {0, 1, 2}


def test_it_waits_for_a_click_or_a_kick() -> None:
    made = wishes(on=False, kind="toss")
    assert made.next_pass("Ana") is None
    made.kicked = True
    decided = made.next_pass("Ana")
    assert decided is not None
    assert decided.kind == "any"
    assert made.next_pass("Ben") is None
