"""Pitches, their nets, and balls that cross them."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest

from mgjax.ballsport.ball.physics import Net
from mgjax.ballsport.scene.config import validate_scene
from mgjax.stage.apps.match.pitch import beside, colours, net_thing, over_net, pitch, side


@pytest.mark.parametrize("count", [3, 6])
@pytest.mark.parametrize("net", [False, True])
def test_a_pitch_is_a_scene(count: int, net: bool) -> None:
    """Valid, of so many players, none of whom stands in another's way or beside the pitch."""
    config = pitch(count, net=net)
    validate_scene(config)
    assert len(config.players) == count
    spots = [(p.x, p.z) for p in config.players] + [(s[1], s[2]) for s in beside(config)]
    assert min(math.dist(a, b) for a, b in combinations(spots, 2)) > 1.2


@pytest.mark.parametrize("count", [3, 6])
def test_a_net_parts_the_players(count: int) -> None:
    """Each stands well on one side, in that side's colour, and the thing is where the net is."""
    config = pitch(count, net=True)
    thing = net_thing(config)
    assert config.net is not None
    assert thing is not None
    assert thing.end is not None
    sides = [side(config.net, p.x, p.z) for p in config.players]
    assert min(map(abs, sides)) > 1.5
    hues = colours(config)
    assert [hues[p.name] == "blue" for p in config.players] == [value < 0 for value in sides]
    for place in (thing.place, thing.end):
        assert side(config.net, place[0], place[2]) == pytest.approx(0.0, abs=1e-9)
        assert place[1] == config.net.height


def test_without_a_net() -> None:
    config = pitch(6, net=False)
    assert net_thing(config) is None
    assert len(set(colours(config).values())) == 6


def test_over_a_net() -> None:
    """The lowest crossing counts, between two moments as well; the ball's own size is no air."""
    net = Net(z=1.0, height=1.0)
    path = np.array([[0.0, 1.0, 0.0], [0.0, 3.0, 2.0], [0.0, 2.5, 3.0]])
    assert over_net(net, path, 0.1) == pytest.approx(0.9)
    assert over_net(net, path[1:], 0.1) is None
    back = np.concatenate([path, [[0.0, 1.3, 0.0]]])
    assert over_net(net, back, 0.1) == pytest.approx(1.3 + (1 / 3) * 1.2 - 1.1)
