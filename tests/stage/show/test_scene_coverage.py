from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.coverage.throws import measure_coverage
from mgjax.ballsport.ball.physics import Net
from mgjax.ballsport.scene.ball_track import csv_text
from mgjax.ballsport.scene.build import build_scene
from mgjax.ballsport.scene.config import Pass, Player, SceneConfig
from mgjax.ballsport.scene.report import scene_json
from mgjax.cli.report import to_json
from mgjax.io.bvh.write import save_bvh
from mgjax.stage.show.coverage import AROUND_M, LEVELS, coverage_show
from mgjax.stage.show.folder import show_of_folder
from mgjax.stage.show.of import show_of
from mgjax.stage.show.scene import net_things, scene_show


@pytest.fixture(scope="module")
def scene():
    players = (Player(name="Ana", x=-2.0, z=0.0), Player(name="Ben", x=2.0, z=0.0))
    passes = (Pass(by="Ana", to="Ben"), Pass(by="Ben", to="Ana"))
    net = Net(x=0.0, z=0.0, heading=np.pi / 2, height=0.8)
    return build_scene(SceneConfig(players=players, passes=passes, takes=1, net=net))


def test_players_ball_and_passes(scene):
    show, report = scene_show(scene), scene_json(scene)
    assert [actor.id for actor in show.actors] == ["Ana", "Ben"]
    assert len({actor.colour for actor in show.actors}) == 2
    (ball,) = show.balls
    frames = np.arange(0, len(scene.ball.places), 7)
    flown = [np.interp(frames / scene.frame_rate, ball.times, ball.places[:, i]) for i in range(3)]
    np.testing.assert_allclose(np.stack(flown, axis=1), scene.ball.places[frames], atol=0.02)
    passes = [span for span in show.spans if "thrown in" not in span.text]
    assert len(passes) == len(report["passes"]) == 2
    for span, row in zip(sorted(passes, key=lambda s: s.start), report["passes"], strict=True):
        assert (span.start, span.end) == (row["start_s"], row["arrives_s"])
        assert span.row == f"to {row['to']}"
    assert f"{report['passes_made']} of 2 passes made" in show.words
    assert show_of(scene).words == show.words


def test_the_net_stands_across():
    (thing,) = net_things(Net(x=1.0, z=2.0, heading=0.0, height=1.5))
    (a, b) = np.array(thing.place), np.array(thing.end)
    np.testing.assert_allclose((a + b) / 2, [1.0, 1.5, 2.0])
    np.testing.assert_allclose((b - a)[1:], 0, atol=1e-12)
    assert net_things(None) == []


def test_the_folder_shows_the_same(tmp_path, scene):
    report = scene_json(scene)
    (tmp_path / "timeline.json").write_text(to_json(report))
    (tmp_path / "ball.csv").write_text(csv_text(scene.ball, scene.frame_rate))
    for name, motion in scene.motions.items():
        save_bvh(tmp_path / f"{name}.bvh", scene.skeleton, motion)
    show, wanted = show_of_folder(tmp_path), scene_show(scene)
    assert (show.words, show.notes, show.spans) == (wanted.words, wanted.notes, wanted.spans)
    assert [a.colour for a in show.actors] == [a.colour for a in wanted.actors]
    assert show.things[0].place == pytest.approx(wanted.things[0].place)
    assert show.balls[0].radius == wanted.balls[0].radius
    middle = wanted.balls[0].times[len(wanted.balls[0].times) // 2]
    for i in range(3):
        at = [np.interp(middle, b.times, b.places[:, i]) for b in (show.balls[0], wanted.balls[0])]
        assert at[0] == pytest.approx(at[1], abs=0.02)


@pytest.fixture(scope="module")
def covered(graph):
    return measure_coverage(graph, directions=4, heights=(0.6, 1.4), arrivals=(1.0,), nodes=6)


def test_a_ball_for_each_direction_and_height(graph, covered):
    show = coverage_show(graph, covered)
    avoided = covered.answers.status == 0
    things = {thing.id: thing for thing in show.things}
    assert len(things) == 8
    for direction, angle in enumerate(covered.directions):
        for height, up in enumerate(covered.heights):
            thing = things[f"from{direction}at{height}"]
            wanted = [AROUND_M * np.sin(angle), up, AROUND_M * np.cos(angle)]
            np.testing.assert_allclose(thing.place, wanted, atol=1e-9)
            mask = (covered.direction == direction) & (covered.height == height)
            share = avoided[mask].mean()
            assert thing.colour == next(c for least, c, _ in LEVELS if share >= least)
    assert show.words.startswith(f"{avoided.mean():.0%} of {len(covered)} balls")
    assert sum(bar.value for bar in show.bars) == pytest.approx(1)
    assert show_of(covered).words == show.words


def test_the_body_stands_and_looks_ahead(graph, covered):
    frames = coverage_show(graph, covered).actors[0].frames
    assert np.abs(frames.root[0, [0, 2]]).max() < 1e-3
    assert 0.7 < frames.root[0, 1] < 1.2
    unknown = replace(covered)
    with pytest.raises(ValueError, match="without its graph"):
        show_of(unknown)
