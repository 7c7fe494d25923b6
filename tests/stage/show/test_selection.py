import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.timing.walk_warps import part_moments
from mgjax.core.shown import origin_of
from mgjax.stage.show.of import show_of
from mgjax.stage.show.selection import attack_balls, selection_show
from mgjax.stage.show.throws import Thrown, throws_show
from mgjax.stage.show.words import avoided_words


def _kind(graph, selection) -> str:
    kind, way = graph.label_kind[selection.part], graph.label_direction[selection.part]
    return f"{kind} {way}".strip().replace("_", " ")


def test_the_figures_are_those_of_the_selection(graph, thrown):
    attack, selection = thrown
    show = selection_show(graph, attack, selection)
    last = (selection.motion.num_frames - 1) / selection.motion.frame_rate
    assert show.seconds == pytest.approx(last)
    assert show.seconds > selection.crop.end
    assert show.words == avoided_words("avoided", _kind(graph, selection), selection.clearance_m)
    assert [bar.value for bar in show.bars] == [
        selection.energy.avoidance, selection.energy.body,
        selection.energy.movement, selection.energy.timescale,
    ]  # fmt: skip
    notes = dict(show.notes)
    assert notes["candidates"] == str(selection.candidates)
    assert notes["time scale"] == f"{selection.time_scale:.2f}"


def test_the_avoidance_is_where_the_motion_plays_it(graph, thrown):
    attack, selection = thrown
    show = selection_show(graph, attack, selection)
    (span,) = [span for span in show.spans if span.row == "avoidance"]
    moments = part_moments(graph, selection.walk, selection.path_length, selection.part)
    np.testing.assert_allclose(
        selection.timing.at(np.array([span.start, span.end])), moments[[0, 2]], atol=1e-6
    )
    walk = [span for span in show.spans if span.row == "walk"]
    assert walk[0].start == 0.0
    assert all(a.end == pytest.approx(b.start) for a, b in zip(walk, walk[1:], strict=False))
    assert dict(show.moments)["ball passes"] == pytest.approx(selection.crop.middle)


def test_the_ball_flies_as_the_attack_does(graph, thrown):
    attack, selection = thrown
    (ball,) = selection_show(graph, attack, selection).balls
    assert ball.radius == attack.radii[0]
    times = np.linspace(ball.times[0], ball.times[-1], 50)
    flown = np.stack([np.interp(times, ball.times, ball.places[:, i]) for i in range(3)], axis=1)
    np.testing.assert_allclose(flown, attack.at(times)[:, 0], atol=2e-3)


def test_what_select_returns_knows_its_attack(graph, thrown):
    attack, selection = thrown
    assert origin_of(selection) == (graph, attack)
    assert show_of(selection).words == selection_show(graph, attack, selection).words


def test_each_sphere_lives_as_long_as_it_does():
    times = np.array([-0.5, 0.5, 1.0, 2.0])
    centres = np.zeros((4, 2, 3))
    centres[:, 0, 0] = times
    centres[:, 1, 1] = times**2
    attack = Attack(
        times=times, centres=centres, radii=np.array([0.1, 0.2]),
        starts=np.array([-0.5, 1.0]), stops=np.array([1.0, 2.0]),
    )  # fmt: skip
    first, second = attack_balls(attack, now=10.0)
    np.testing.assert_allclose(first.times[[0, -1]], [10.0, 11.0])
    np.testing.assert_allclose(first.places[:, 0], first.times - 10.0)
    np.testing.assert_allclose(second.times[[0, -1]], [11.0, 12.0])
    np.testing.assert_allclose(second.places[[0, -1], 1], [1.0, 4.0])


def test_words_of_each_outcome():
    assert avoided_words("avoided", "duck", 0.041) == "avoided by duck, 4 cm clear"
    assert avoided_words("avoided", "duck", 0.004) == "avoided by duck, 4 mm clear"
    assert avoided_words("avoided", "duck", 3.0) == "avoided by duck, more than 2 m clear"
    assert avoided_words("hit", "sway left", -0.02) == "hit, 2 cm deep, in spite of sway left"
    assert "no candidate" in avoided_words("no_candidate", None, None)


def test_throws_are_placed_in_the_world(graph, thrown):
    """One throw at second 0 of its own motion lies where it lies in the selection's show."""
    attack, selection = thrown
    one = Thrown(now=0.0, attack=attack, selection=selection)
    later = Thrown(now=0.25, attack=attack, selection=selection)
    show = throws_show(graph, selection.motion, [one, later])
    alone = selection_show(graph, attack, selection)
    np.testing.assert_allclose(show.balls[0].places, alone.balls[0].places, atol=1e-4)
    np.testing.assert_allclose(show.balls[1].times, alone.balls[0].times + 0.25)
    assert show.words == "2 of 2 balls avoided"
