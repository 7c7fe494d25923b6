"""What pages and folders say of an attack that is parried."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.selection import Selection, select
from mgjax.graph.types import MotionGraph
from mgjax.stage.show.selection import selection_show
from mgjax.stage.show.words import avoided_words, status_colour
from tests.avoidance.parry.made import CONFIG, ball_at_chest, guarding_graph


@pytest.fixture(scope="module")
def graph() -> MotionGraph:
    return guarding_graph()


@pytest.fixture(scope="module")
def attack(graph: MotionGraph) -> Attack:
    return ball_at_chest(graph, side=0.1)


@pytest.fixture(scope="module")
def parried(graph: MotionGraph, attack: Attack) -> Selection:
    return select(graph, 0, attack, config=CONFIG)


def test_a_ball_that_is_parried_ends_where_it_is_met(
    graph: MotionGraph, attack: Attack, parried: Selection
) -> None:
    parry = parried.parry
    assert parry is not None
    show = selection_show(graph, attack, parried)
    limb = parry.limb.replace("_", " ")
    assert show.words == f"parried with the {limb}: nothing avoids it"
    (ball,) = show.balls
    assert ball.times[-1] == pytest.approx(parry.time)
    np.testing.assert_allclose(
        np.linalg.norm(ball.places[-1] - parry.place), attack.radii[0], atol=1e-4
    )
    assert ("parried", parry.time) in show.moments
    assert any(name == "arm led by" for name, _ in show.notes)


def test_words_and_colours() -> None:
    words = avoided_words("parried", None, 0.1, "left_hand")
    assert words == "parried with the left hand: nothing avoids it"
    colours = {status_colour(status) for status in Status}
    assert colours == {"green", "orange", "red"}
    assert Status.PARRIED.code == 3
