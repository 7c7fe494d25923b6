"""Players, their ways from link to link, and rallies planned touch by touch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.ballsport.aiming.solve import OK, UNDER_NET
from mgjax.ballsport.aiming.timed import aim_timed
from mgjax.ballsport.ball.physics import BallPhysics, Net
from mgjax.ballsport.clipset.build import ClipSet
from mgjax.ballsport.clipset.repertoire import Repertoire, make_repertoire
from mgjax.ballsport.config import AnalysisConfig, KindConfig, TransitionConfig, hit_bone
from mgjax.ballsport.scene.build import build_scene, prepare_scene
from mgjax.ballsport.scene.config import Pass, Player, SceneConfig
from mgjax.ballsport.scene.gaze import look_at
from mgjax.ballsport.scene.kick import kick_change, kicks_of
from mgjax.ballsport.scene.link_paths import NO_HOP, find_link_paths
from mgjax.ballsport.scene.player import new_actor
from mgjax.ballsport.scene.rally import Rally
from mgjax.ballsport.scene.report import scene_json
from mgjax.ballsport.scene.types import Asked
from mgjax.clips.synthetic_turns import synthetic_turns
from mgjax.core.errors import ConfigError, MotionError
from mgjax.core.kinematics import global_positions, planar_frames
from tests.reference import ball as reference

PLAYERS = (
    Player(name="A", x=0.0, z=-2.0),
    Player(name="B", x=1.8, z=1.8),
    Player(name="C", x=-1.8, z=1.8),
)
SCENE = SceneConfig(
    players=PLAYERS,
    passes=(Pass(by="A", to="B"), Pass(by="B", to="A"), Pass(by="A", to="C", kind="pass")),
    frame_rate=30.0,
    end_s=1.0,
)


@pytest.fixture(scope="module")
def moves(made_set: ClipSet) -> Repertoire:
    return make_repertoire(made_set, ball_radius=0.11)


def test_turn_clips() -> None:
    """As far as asked, from rest to rest on the spot, at a natural pace, feet on the floor."""
    for clip, angle in zip(synthetic_turns((30, -90, 180)), (30, -90, 180), strict=True):
        places = np.asarray(global_positions(clip.skeleton, clip.motion))
        plane = np.asarray(planar_frames(clip.skeleton, places), np.float64)
        heading = np.unwrap(plane[:, 0])
        assert np.degrees(heading[-1] - heading[0]) == pytest.approx(angle, abs=0.5)
        assert np.abs(plane[-1, 1:] - plane[0, 1:]).max() < 0.01
        assert np.degrees(np.abs(np.diff(heading)).max() * 60) < 250
        feet = places[:, [clip.skeleton.index("ltoes"), clip.skeleton.index("rtoes")]]
        speed = np.linalg.norm(np.diff(feet, axis=0), axis=-1) * 60
        assert (speed.min(axis=1) < 0.05).all()  # one foot stands at any time
    for bad in (0, 200):
        with pytest.raises(MotionError, match="turn"):
            synthetic_turns((bad,))


def test_contacts(moves: Repertoire) -> None:
    """Surfaces touch, ahead of the bone, above the ground; slow frames are left out."""
    for hit, touch in moves.touch.items():
        path, velocity = moves.clips.bone_path(hit)
        reach = 0.11 + hit_bone(moves.clips.hit_bone[hit]).radius_m
        away = touch.centres - path
        np.testing.assert_allclose(np.linalg.norm(away, axis=1), reach, atol=1e-6)
        assert (touch.centres[touch.mask, 1] >= 0.11).all()
        assert (np.sum(away * velocity, axis=1)[touch.mask] > 0).all()
        speed = np.linalg.norm(velocity, axis=1)
        assert (velocity[touch.mask, 1] >= 0).all()
        assert not touch.mask[speed < 0.3 * speed.max()].any()


def test_kicks_are_in_the_body_frame(moves: Repertoire) -> None:
    """Kicks go ahead, the left foot's ball is to the left."""
    for hit in moves.touch:
        for kick in kicks_of(moves, hit):
            assert kick.centre[2] > 0
            assert abs(kick.aside) < 0.5
            assert (kick.centre[0] > 0) == (moves.clips.hit_bone[hit] == "left_foot")


def test_kick_change() -> None:
    bone = np.array([0.0, 3.0, 4.0])
    balls = np.array([1.2 * bone, 2.4 * bone, bone + np.array([1.0, 0.0, 0.0])])
    np.testing.assert_allclose(kick_change(balls, bone[None]), [0.0, 1.0, 0.2], atol=1e-12)


def test_aim_timed_takes_just_so_long() -> None:
    """Against float64 flight: place, time and bounces; what cannot be is not met."""
    physics = BallPhysics()
    times = np.array([0.9, 1.3, 1.7])
    starts = np.tile([0.2, 0.5, 0.3], (3, 1))
    targets = np.tile([2.0, 0.6, 3.0], (3, 1))
    for bounces in (0, 1):
        velocities, met = aim_timed(
            starts,
            targets,
            times,
            bounces=bounces,
            guesses=np.tile([2.0, 4.0, 3.0], (3, 1)),
            physics=physics,
            max_speed=30.0,
            net=None,
        )
        assert met.all()
        for velocity, time in zip(velocities, times, strict=True):
            place, count = reference.arrival(starts[0], np.float64(velocity), time, physics)
            assert np.linalg.norm(place - targets[0]) < 2e-4
            assert count == bounces
    slow = aim_timed(
        starts,
        targets,
        times,
        bounces=0,
        guesses=starts,
        physics=physics,
        max_speed=2.0,
        net=Net(z=1.0, height=1.0),
    )
    assert not slow[1].any()


@pytest.mark.parametrize("turn", [0, 90])
def test_chains_leave_room_for_blends(moves: Repertoire, turn: int) -> None:
    """Every piece holds its two blends, hops are rows of the table, and the frames add up."""
    idle = moves.idle
    run, frame = int(moves.runs[idle[0]]), int(moves.starts[idle[3]])
    hit = next(iter(moves.before))
    targets = moves.before[hit]
    found = find_link_paths(moves, run, frame, frame + 5, targets, turn=turn, most=120)
    assert len(found.frames)
    assert (found.frames <= 120).all()
    turns = {start: stop - moves.window for start, stop in moves.turns.values()}
    for row in range(0, len(found.frames), max(1, len(found.frames) // 50)):
        here, earliest, frames, turned = frame, frame + 5, 0, 0
        for leave, enter in found.hops[row]:
            if leave == NO_HOP:
                break
            assert leave >= earliest
            frames += leave - here
            here, earliest = enter, enter + moves.window
            if enter in turns:
                turned += 1
                earliest = turns[enter]
        assert frames == found.frames[row]
        assert turned == (turn != 0)
        assert any(moves.starts[t] <= here < moves.stops[t] for t in targets)


def test_actor_faces_and_idles(moves: Repertoire) -> None:
    """Turns by stepping to a heading; idle motion never ends; the account is that of the motion."""
    begin = int(moves.starts[moves.idle[0]])
    actor = new_actor(moves, (0.4, 1.0, -2.0), begin)
    np.testing.assert_allclose(actor.stand, [0.4, 1.0, -2.0], atol=1e-6)
    actor.face(0.5, now=10, tolerance=0.3)
    assert len(actor.pieces) == 1
    actor.face(2.0, now=10, tolerance=0.3)
    assert [angle for _, angle in actor.turns] == [90]
    motion, seams = actor.motion(600)
    assert motion.num_frames == 600
    assert len(seams) >= 2
    places = np.asarray(global_positions(moves.clips.skeleton, motion))
    plane = np.asarray(planar_frames(moves.clips.skeleton, places), np.float64)
    assert abs(np.degrees(plane[-1, 0] - 2.0)) < 12
    assert np.hypot(plane[:, 1] - 1.0, plane[:, 2] + 2.0).max() < 0.15
    speed = np.linalg.norm(np.diff(places, axis=0), axis=-1) * 30
    assert speed.max() < 3.0


def test_gaze_turns_only_the_head(moves: Repertoire) -> None:
    skeleton = moves.clips.skeleton
    actor = new_actor(moves, (0.0, 0.0, 0.0), int(moves.starts[moves.idle[0]]))
    motion, _ = actor.motion(40)
    ball = np.tile([2.0, 1.6, 2.0], (40, 1))
    looked = look_at(skeleton, motion, ball)
    before, after = (np.asarray(global_positions(skeleton, m)) for m in (motion, looked))
    head = [skeleton.index(n) for n in ("upperneck", "head", "head_end")]
    body = [j for j in range(skeleton.num_joints) if j not in head]
    np.testing.assert_allclose(before[:, body], after[:, body], atol=1e-6)
    behind = look_at(skeleton, motion, np.tile([0.0, 1.5, -5.0], (40, 1)))
    np.testing.assert_allclose(np.asarray(global_positions(skeleton, behind)), before, atol=0.05)


@pytest.fixture(scope="module")
def decided(moves: Repertoire) -> tuple[Rally, list[tuple[Asked, int]]]:
    """A rally whose first two hits are the user's."""
    asked: list[tuple[Asked, int]] = []
    holder: list[Rally] = []

    def choose(question: Asked) -> int | None:
        asked.append((question, len(holder[0].touches)))
        return question.hits[len(asked)]

    rally = Rally(SCENE, moves, choose)
    holder.append(rally)
    while not rally.done:
        rally.step()
    return rally, asked


def test_user_decides_before_the_launch(decided: tuple[Rally, list[tuple[Asked, int]]]) -> None:
    """Asked once per open touch, before the pass to it is launched; idle until then."""
    rally, asked = decided
    assert [question.touch for question, _ in asked] == [0, 1]
    assert [question.player for question, _ in asked] == ["A", "B"]
    for question, planned in asked:
        assert planned == question.touch
        touch = rally.touches[question.touch]
        assert touch.by_user
        assert touch.kick.hit == question.hits[question.touch + 1]
        flight = next(flight for flight in rally.flights if flight.stop == touch.time)
        assert flight.start / rally.rate == pytest.approx(question.deadline_s)
        # The warped link motion, which is that of the hit, begins no sooner than the launch.
        begins = [time for _, time in rally.actors[touch.player].knots[1::2]]
        assert min(begins) >= flight.start or touch.player == "A"
    assert not rally.touches[2].by_user


def test_flights_join(decided: tuple[Rally, list[tuple[Asked, int]]]) -> None:
    rally, _ = decided
    assert [flight.number for flight in rally.flights] == [-1, 0, 1, 2, 3]
    for before, touch, after in zip(rally.flights, rally.touches, rally.flights[1:], strict=False):
        assert before.stop == touch.time == after.start
        np.testing.assert_array_equal(after.place, touch.centre)
        assert before.status == OK


def test_wrong_hits_are_refused(moves: Repertoire) -> None:
    with pytest.raises(ConfigError, match="touch 1: got hit 999"):
        build_scene(SCENE, moves=moves, choose=lambda _: 999)


def test_what_cannot_be_is_missed(moves: Repertoire) -> None:
    """The ball goes as near as it can, and another is thrown in to the next player."""
    config = replace(
        SCENE,
        passes=(Pass(by="A", to="B", bounces=0), Pass(by="B", to="C", bounces=0)),
        throw_in=(0.0, 8.0, 0.0),
        net=Net(z=0.0, height=6.0),
        max_speed=9.0,
    )
    scene = build_scene(config, moves=moves)
    report = scene_json(scene)
    assert [flight.status for flight in scene.flights] == [OK, UNDER_NET, OK, OK, OK]
    assert (report["passes_made"], report["passes_missed"]) == (1, 1)
    assert report["passes"][0]["miss_m"] > 0.5
    assert report["passes"][1]["arrival_miss_m"] < 1e-3
    assert [event["event"] for event in report["events"]].count("miss") == 1
    assert [throw["to"] for throw in report["throws"]] == ["A", "B"]


def test_a_throw_that_cannot_be(moves: Repertoire) -> None:
    with pytest.raises(ConfigError, match="throw from"):
        build_scene(replace(SCENE, throw_in=(0.0, 1.0, 90.0), max_speed=5.0), moves=moves)


def test_captured_kicks(real_set: ClipSet) -> None:
    """A scene out of captured kicks: they take part, and the ball still meets the foot."""
    moves = make_repertoire(real_set, ball_radius=0.11)
    captured = [hit for hit in moves.touch if not real_set.labelled[hit]]
    assert captured
    config = replace(SCENE, passes=SCENE.passes[:1])
    scene = build_scene(config, moves=moves, choose=lambda asked: captured[0])
    assert scene.touches[0].kick.hit == captured[0]
    assert scene_json(scene)["worst"]["surface_gap_m"] < 0.01


def test_settings_reach_the_clip_set() -> None:
    """The sections of a scene are those of its clip set and of its transitions."""
    config = replace(
        SCENE,
        takes=1,
        kinds=KindConfig(pass_m_s=2.0, attack_m_s=100.0),
        analysis=AnalysisConfig(smoothing_s=0.05),
        transition=TransitionConfig(seconds=0.5),
    )
    usual, moves = prepare_scene(replace(SCENE, takes=1)), prepare_scene(config)
    assert (usual.window, moves.window) == (10, 15)
    assert config.clip_set.kinds == config.kinds
    assert max(moves.clips.vectors.v_max) < max(usual.clips.vectors.v_max)
