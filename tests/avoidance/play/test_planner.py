from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.transform import after, in_frame
from mgjax.avoidance.body.edge_tables import edge_tables
from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.candidates.enumerate import enumerate_candidates
from mgjax.avoidance.checks.fast import clearance_between
from mgjax.avoidance.checks.written import clearance, sphere_trajectory
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.play.answers import Found
from mgjax.avoidance.play.clocks import (
    SimulatedClock,
    SimulatedSearches,
)
from mgjax.avoidance.play.planner import Planner
from mgjax.avoidance.play.several_attacks import find_path, played_clearance
from mgjax.avoidance.play.timeline import Piece, Timeline
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.rates import CLEAR_M, EXPORT_RATE
from mgjax.core import planar
from mgjax.core.errors import AttackError, ConfigError
from mgjax.core.kinematics import forward, global_positions, planar_frames
from mgjax.graph.feet.played import play_at
from mgjax.graph.types import NO_EDGE, MotionGraph
from tests.avoidance.made import captured_motion, throw, with_knots

QUICK = AvoidanceConfig(checks=12, refine="off")


def world_throw(planner: Planner, rng: np.random.Generator, now: float, **more: float) -> Attack:
    """A ball at where the body is now, in the world."""
    root = planner.frame(now).root_translation[0]
    side = rng.uniform(0, 2 * np.pi)
    height = rng.uniform(0.6, 1.6)
    ball = ball_from(
        side, height, at=(float(root[0]), float(root[2])), arrives=more.get("arrives", 1.2)
    )
    return replace(ball, times=ball.times + now)


def run(
    graph: MotionGraph,
    *,
    latency: float,
    seed: int = 0,
    seconds: float = 12.0,
    every: float = 1.9,
    rate: float = 60.0,
) -> tuple[Planner, list[Attack]]:
    """Plays on a simulated clock with attacks at fixed times that depend on the seed only."""
    clock = SimulatedClock()
    searches = SimulatedSearches(latency)
    planner = Planner(graph, clock=clock, searches=searches, config=QUICK, seed=seed)
    rng = np.random.default_rng(seed)
    attacks: list[Attack] = []
    # Frames between attacks may be shown at any rate.
    for begin in np.arange(0.5, seconds, every):
        while clock.now() + 1 / rate < begin:
            planner.frame()
            clock.advance(1 / rate)
        clock.advance(begin - clock.now())
        attacks.append(world_throw(planner, rng, clock.now()))
        assert planner.attack(attacks[-1]) == len(attacks) - 1
    planner.finish()
    return planner, attacks


@pytest.fixture(scope="module", params=[0.0, 0.1, 0.7], ids=["at once", "short", "long"])
def played(
    made_graph: MotionGraph, request: pytest.FixtureRequest
) -> tuple[Planner, list[Attack], float]:
    return (*run(made_graph, latency=request.param), request.param)


def test_every_attack_has_one_answer(played: tuple) -> None:
    planner, attacks, latency = played
    counts = planner.counts()
    assert counts["attacks"] == len(attacks) == len(planner.answers)
    assert counts["avoided"] + counts["hit"] + counts["superseded"] == len(attacks)
    assert counts["open"] == 0
    assert sorted(a.number for a in planner.answers) == list(range(len(attacks)))
    for answer in planner.answers:
        assert answer.hit == (answer.clearance_m < CLEAR_M)
        assert (answer.waited is None) == (answer.search == "late")
        assert answer.waited is None or answer.waited >= latency - 1e-9
        assert latency > 0 or answer.restarts == 0
    # No edge lasts that long here, so the first search never ends in time.
    assert latency < 0.7 or counts["restarts"] > 0


def test_the_same_seed_plays_the_same(made_graph: MotionGraph) -> None:
    for latency in (0.0, 0.25):
        one, other = (run(made_graph, latency=latency, seconds=6.0, rate=r) for r in (60.0, 13.0))
        # Not even the rate of the frames matters.
        assert one[0].timeline.edges == other[0].timeline.edges
        assert one[0].timeline.scales == other[0].timeline.scales
        for a, b in zip(one[0].answers, other[0].answers, strict=True):
            assert replace(a, waited=None) == replace(b, waited=None)
    third, _ = run(made_graph, latency=0.25, seconds=6.0, seed=1)
    assert third.timeline.edges != one[0].timeline.edges


def test_what_is_shown_is_what_is_written(made_graph: MotionGraph) -> None:
    start = np.array([0.7, -2.0, 3.0])
    clock, searches = SimulatedClock(), SimulatedSearches(0.1)
    planner = Planner(
        made_graph, clock=clock, searches=searches, config=QUICK, seed=4, node=5, start=start
    )
    rng = np.random.default_rng(1)
    times = np.arange(0, 6.0, 1 / 53)
    shown = []
    for number, now in enumerate(times):
        clock.advance(now - clock.now())
        shown.append(planner.frame())
        if number in (30, 140):
            planner.attack(world_throw(planner, rng, clock.now()))
    walk = planner.timeline.walk()
    assert made_graph.edge_source[walk.edges[0]] == 5
    assert min(walk.scales) != 1 or max(walk.scales) != 1  # something was scaled in time
    written = planner.timeline.sample(times)
    roots = np.concatenate([pose.root_translation for pose in shown])
    turns = np.concatenate([pose.local_rotations for pose in shown])
    np.testing.assert_allclose(roots, written.root_translation, atol=1e-5)
    np.testing.assert_allclose(np.abs(np.sum(turns * written.local_rotations, -1)), 1, atol=1e-5)
    # As a walk that is written from the beginning on, but for the moments of its frames.
    whole = play_at(made_graph, walk, times, rate=EXPORT_RATE, start=start)
    np.testing.assert_allclose(roots, whole.root_translation, atol=5e-3)
    # The past stays as it was.
    np.testing.assert_array_equal(planner.frame(times[70]).root_translation, roots[70:71])
    line = planner.timeline
    assert line.edges == walk.edges.tolist()
    np.testing.assert_allclose(line.starts, walk.starts(made_graph), atol=1e-12)
    # It begins where it was told to.
    frame = planar_frames(made_graph.skeleton, global_positions(made_graph.skeleton, shown[0]))[0]
    np.testing.assert_allclose(frame, start, atol=0.02)  # a transition's pose is blended


def test_no_jump(made_graph: MotionGraph, played: tuple) -> None:
    planner, _, _ = played
    line = planner.timeline
    graph = made_graph
    # Fastest that any joint moves from one captured or blended frame to the next.
    positions, _ = forward(graph.skeleton, graph.root_translation, graph.local_rotations)
    steps = np.linalg.norm(np.diff(np.asarray(positions, np.float64), axis=0), axis=-1).max(axis=1)
    inside = np.concatenate(
        [np.arange(a, b) for a, b in zip(graph.edge_starts, graph.edge_stops, strict=True)]
    )
    fastest = steps[inside].max() * graph.frame_rate
    times = np.arange(0, line.end - 0.1, 1 / 120)
    motion = line.sample(times)
    places = np.asarray(global_positions(graph.skeleton, motion), np.float64)
    speed = np.linalg.norm(np.diff(places, axis=0), axis=-1).max(axis=1) * 120
    starts, scales = np.array(line.starts), np.array(line.scales)
    index = np.searchsorted(starts, times[:-1], side="right") - 1
    after = np.minimum(index + 1, len(scales) - 1)
    assert (speed * np.minimum(scales[index], scales[after]) <= 1.1 * fastest).all()


def test_found_at_once_is_spliced_in_at_the_end_of_the_edge(made_graph: MotionGraph) -> None:
    rng = np.random.default_rng(5)
    spliced = 0
    for seed in range(12):
        clock = SimulatedClock()
        told: list[Found] = []
        planner = Planner(made_graph, clock=clock, config=QUICK, seed=seed, on_found=told.append)
        clock.advance(0.8)
        attack = world_throw(planner, rng, clock.now())
        line = planner.timeline
        count, node, end = len(line.edges), line.node, line.end
        assert line.deadline > clock.now()
        asked = in_frame(attack, line.frame_at_end(), end)
        planner.attack(attack)
        answer = planner.finish()[0]
        if end >= attack.end:  # too long an edge
            assert answer.search == "late"
            continue
        assert (answer.restarts, answer.waited) == (0, 0.0)
        chosen = told[-1].path.choice
        assert chosen is not None
        assert chosen.node == node
        assert chosen.candidates == choose(made_graph, node, asked, config=QUICK).candidates
        if chosen.status == "no_candidate":
            continue
        length = len(chosen.walk.edges)
        # Up to the attack's end the walk that was chosen is played; later edges are random.
        got = line.edges[count : count + length]
        assert got == chosen.walk.edges[: len(got)].tolist()
        assert len(got) >= chosen.path_length
        np.testing.assert_array_equal(
            line.scales[count : count + len(got)], chosen.walk.scales[: len(got)]
        )
        if chosen.status == "avoided" and answer.search == "avoided":
            assert answer.status == "avoided"
            assert answer.clearance_m > 0
            spliced += 1
    assert spliced >= 2


def test_an_edge_that_ends_first_is_drawn_and_the_search_begins_again(
    made_graph: MotionGraph,
) -> None:
    seen = 0
    for seed in range(6):
        clock = SimulatedClock()
        planner = Planner(made_graph, clock=clock, searches=SimulatedSearches(0.45), seed=seed)
        plain = Planner(made_graph, clock=SimulatedClock(), seed=seed)
        clock.advance(0.8)
        attack = world_throw(planner, np.random.default_rng(seed), 0.8, arrives=2.5)
        planner.attack(attack)
        answer = planner.finish()[0]
        if answer.search not in ("avoided", "hit") or not answer.restarts:
            continue
        seen += 1
        # Up to where the search was answered the edges are those that are drawn without attack.
        answered = answer.known + answer.waited
        plain.frame(answered)
        count = int(np.searchsorted(planner.timeline.starts, answered))
        count = min(count, len(plain.timeline.edges))
        assert planner.timeline.edges[:count] == plain.timeline.edges[:count]
        assert answer.waited >= 0.45
    assert seen >= 2


def test_dropping_candidates_is_searching_from_the_next_node(made_graph: MotionGraph) -> None:
    tables = edge_tables(made_graph, QUICK.body_rate)
    compared = 0
    for node in range(0, made_graph.num_nodes, 97):
        edge = int(made_graph.edges_from(node)[-1])
        more = {"window": 1.0, "capacity": 10**6}
        old = enumerate_candidates(made_graph, tables, node, 1.31234, **more)
        rest = 1.31234 - tables.seconds[edge]
        new = enumerate_candidates(
            made_graph, tables, int(made_graph.edge_target[edge]), rest, **more
        )

        def rows(edges: np.ndarray, part: np.ndarray) -> set[tuple]:
            return {
                (*row[row != NO_EDGE].tolist(), int(p)) for row, p in zip(edges, part, strict=True)
            }

        kept = (old.edges[:, 0] == edge) & (old.length > 1)
        assert rows(old.edges[kept, 1:], old.part[kept]) == rows(new.edges, new.part)
        compared += int(kept.sum())
    assert compared > 20


def test_an_attack_while_another_is_unanswered(made_graph: MotionGraph) -> None:
    clock = SimulatedClock()
    planner = Planner(made_graph, clock=clock, searches=SimulatedSearches(0.2), seed=5)
    rng = np.random.default_rng(2)
    clock.advance(0.5)
    thrown = [world_throw(planner, rng, clock.now(), arrives=1.5)]
    planner.attack(thrown[0])
    clock.advance(0.05)
    thrown.append(world_throw(planner, rng, clock.now(), arrives=1.8))
    planner.attack(thrown[1])
    clock.advance(0.6)  # answered by now; a third one joins
    planner.frame()
    thrown.append(world_throw(planner, rng, clock.now(), arrives=1.4))
    planner.attack(thrown[2])
    answers = sorted(planner.finish(), key=lambda a: a.number)
    assert [a.status == "superseded" for a in answers] == [True, False, False]
    assert answers[0].search == "late"
    assert answers[1].waited is not None
    check_independently(planner, thrown)


def check_independently(planner: Planner, attacks: list[Attack]) -> int:
    """Sweeps every attack against the whole motion that was played; returns the hits."""
    line = planner.timeline
    graph = line.graph
    spheres = preset_spheres(graph.skeleton)
    count = int(np.ceil(line.end * EXPORT_RATE))
    motion = replace(line.sample(np.arange(count) / EXPORT_RATE), frame_rate=EXPORT_RATE)
    trace = sphere_trajectory(graph, spheres, motion)
    hits = 0
    for answer in planner.answers:
        attack = attacks[answer.number]
        if attack.start >= answer.known:  # else a part does not count
            gap = clearance(attack, trace, spheres.radii)[1]
            assert gap == pytest.approx(answer.clearance_m, abs=2e-5)
            assert (gap < CLEAR_M) == answer.hit or abs(gap - CLEAR_M) < 2e-5
        hits += answer.hit
    return hits


def test_hits_are_reported_exactly(played: tuple) -> None:
    planner, attacks, _ = played
    assert check_independently(planner, attacks) == planner.counts()["touched"]


def test_hits_and_misses_both_occur(made_graph: MotionGraph) -> None:
    planner, attacks = run(made_graph, latency=0.02, seconds=20.0, seed=3, every=0.6)
    hits = check_independently(planner, attacks)
    assert 0 < hits < len(attacks)
    promised = [a for a in planner.answers if a.search == "avoided"]
    assert promised
    # Alone under way, what was promised is kept.
    assert sum(not a.hit for a in promised) > 0.5 * len(promised)


def test_a_path_that_is_clear_of_both(made_graph: MotionGraph) -> None:
    rng = np.random.default_rng(8)
    spheres = preset_spheres(made_graph.skeleton)
    prepared = prepared_for(made_graph, QUICK)
    joint = 0
    for _ in range(40):
        node = int(rng.integers(made_graph.num_nodes))
        newest = throw(rng, arrives=1.3)
        rest = rest_before(made_graph, node)
        alone = find_path(prepared, node, newest, [], QUICK, rest).choice
        assert alone is not None
        if alone.status != "avoided":
            continue
        # Another attack stands where the walk that is best for the newest has a sphere.
        trace = sphere_trajectory(made_graph, spheres, captured_motion(made_graph, alone.walk, 1.5))
        place = trace.centres[int(1.2 * 240), int(rng.integers(len(spheres.radii)))]
        other = Attack(
            times=np.array([1.19, 1.21]), centres=np.tile(place, (2, 1, 1)), radii=np.array([0.02])
        )
        found = find_path(prepared, node, newest, [other], QUICK, rest)
        assert found.walk is not None
        gaps = [clearance_between(prepared.posed, a, found.walk, 0.0, 5.0) for a in (newest, other)]
        if found.joint:
            assert min(gaps) >= CLEAR_M
            assert alone.walk.edges.tolist() != found.walk.edges.tolist()
            joint += 1
        else:  # the newest counts
            np.testing.assert_array_equal(found.walk.edges, alone.walk.edges)
            assert gaps[1] < CLEAR_M <= gaps[0]
    assert joint >= 1


def rest_before(graph: MotionGraph, node: int) -> Piece:
    """A whole played edge that ends at the node, seen from there."""
    edge = int(np.flatnonzero(graph.edge_target == node)[0])
    line = Timeline(graph, int(graph.edge_source[edge]))
    line.append(edge)
    piece = line.between(0.0, line.end)
    start = np.asarray(planar.compose(planar.inverse(line.frame_at_end()), piece.start))
    return replace(piece, begins=-line.end, start=start)


def test_a_hit_before_the_path_can_begin(made_graph: MotionGraph) -> None:
    node = int(made_graph.edge_target[int(np.argmax(made_graph.edge_frames))])
    rest = rest_before(made_graph, node)
    wall = Attack(
        times=np.array([rest.begins / 2, 0.5]),
        centres=np.array([[[0.0, 1.0, 0.0]], [[0.0, 90.0, 0.0]]]),
        radii=np.array([2.0]),
    )
    prepared = prepared_for(made_graph, QUICK)
    assert find_path(prepared, node, wall, [], QUICK, rest).status == "hit"


def test_an_attack_that_cannot_be_avoided_is_a_hit(made_graph: MotionGraph) -> None:
    clock = SimulatedClock()
    planner = Planner(made_graph, clock=clock, seed=1)
    clock.advance(1.0)
    root = planner.frame().root_translation[0].astype(np.float64)
    inside = Attack(
        times=np.array([1.0, 2.0]), centres=np.stack([root, root])[:, None], radii=np.array([1.0])
    )
    planner.attack(inside)
    wide = replace(inside, times=np.array([1.5, 3.0]), radii=np.array([50.0]))
    planner.attack(wide)
    answers = planner.finish()
    assert [a.status for a in answers] == ["hit", "hit"]
    assert all(a.clearance_m < 0 for a in answers)


def test_bad_attacks_are_refused_and_not_counted(made_graph: MotionGraph) -> None:
    clock = SimulatedClock()
    planner = Planner(made_graph, clock=clock, seed=1)
    clock.advance(3.0)
    good = throw(np.random.default_rng(0))
    with pytest.raises(AttackError, match="is over at 3 s"):
        planner.attack(replace(good, times=good.times - 3.0))
    with pytest.raises(AttackError, match="finite"):
        planner.attack(replace(good, centres=good.centres * np.nan))
    with pytest.raises(AttackError, match="at most 60"):
        planner.attack(replace(good, times=good.times + 62.5))
    assert planner.counts()["attacks"] == 0
    with pytest.raises(ConfigError, match="got node -1"):
        Planner(made_graph, node=-1)
    with pytest.raises(ConfigError, match="got T_window"):
        Planner(made_graph, config=AvoidanceConfig(T_window=0.0))


def test_a_sphere_that_comes_and_goes(made_graph: MotionGraph) -> None:
    clock = SimulatedClock()
    planner = Planner(made_graph, clock=clock, config=QUICK, seed=1)
    clock.advance(1.0)
    ball = with_knots(world_throw(planner, np.random.default_rng(3), 1.0), 200)
    # A second sphere is around the body all the time, but there only at the very beginning.
    inside = np.repeat(planner.frame().root_translation.astype(np.float64), len(ball.times), axis=0)
    for until, hit in ((ball.times[2], True), (ball.times[20], True)):
        both = replace(
            ball,
            centres=np.stack([ball.centres[:, 0] + [0, 50, 0], inside], axis=1),
            radii=np.array([0.1, 3.0]),
            starts=np.array([ball.start, ball.start]),
            stops=np.array([ball.end, until]),
        )
        planner.attack(both)
        assert planner.finish()[-1].hit == hit
    clock.advance(float(ball.times[30]) - clock.now())
    planner.attack(both)  # what is left is far above
    assert not planner.finish()[-1].hit
    gone = replace(both, stops=ball.times[[10, 20]])
    with pytest.raises(AttackError, match="is over"):
        planner.attack(gone)


def test_a_search_that_raises_is_told_once(
    made_graph: MotionGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("no path")

    clock = SimulatedClock()
    planner = Planner(made_graph, clock=clock, searches=SimulatedSearches(0.01), seed=0)
    monkeypatch.setattr("mgjax.avoidance.play.planner.find_path", fail)
    clock.advance(0.5)
    planner.attack(world_throw(planner, np.random.default_rng(0), 0.5))
    with pytest.raises(ZeroDivisionError):
        planner.frame(2.0)
    planner.frame(2.1)
    assert [a.search for a in planner.finish()] == ["late"]


def test_what_is_left_of_an_attack() -> None:
    attack = with_knots(throw(np.random.default_rng(1), arrives=1.0), 200)
    assert after(attack, attack.start) is attack
    now = 0.9123
    left = after(attack, now)
    assert left.start == now
    times = np.linspace(now, attack.end, 50)
    np.testing.assert_allclose(left.at(times), attack.at(times), atol=1e-12)
    two = replace(
        attack,
        centres=np.repeat(attack.centres, 2, axis=1),
        radii=np.array([0.1, 0.2]),
        starts=np.array([attack.start, attack.times[-2]]),
        stops=np.array([attack.times[3], attack.end]),
    )
    left = after(two, float(attack.times[10]))
    assert left.radii.tolist() == [0.2]
    assert left.starts is not None
    np.testing.assert_array_equal(left.starts, attack.times[[-2]])
    shifted = in_frame(two, np.array([0.3, 1.0, 2.0]), 0.4)
    assert shifted.stops is not None
    np.testing.assert_allclose(shifted.stops, two.stops - 0.4)
    np.testing.assert_allclose(
        np.asarray(planar.apply(np.array([0.3, 1.0, 2.0]), shifted.centres)),
        two.centres,
        atol=1e-12,
    )


def test_the_check_of_a_stretch_is_that_of_the_whole(made_graph: MotionGraph) -> None:
    planner = Planner(made_graph, seed=7)
    planner.frame(9.0)
    line = planner.timeline
    rng = np.random.default_rng(7)
    attack = after(world_throw(planner, rng, 5.0, arrives=0.4), 5.2)
    whole, part = (line.between(a, b, feet=True) for a, b in ((0.0, 9.0), (5.0, attack.end + 0.1)))
    a, b = (played_clearance(made_graph, piece, attack, 5.2) for piece in (whole, part))
    assert a == pytest.approx(b, abs=1e-5)


def test_a_search_that_hangs_does_not_hold_up_frames(made_graph: MotionGraph) -> None:
    clock = SimulatedClock()
    planner = Planner(made_graph, clock=clock, searches=SimulatedSearches(1e9), seed=0)
    rng = np.random.default_rng(0)
    for _ in range(5):
        clock.advance(0.7)
        planner.attack(world_throw(planner, rng, clock.now()))
        assert np.isfinite(planner.frame().root_translation).all()
    answers = planner.finish()
    assert {a.search for a in answers} == {"late"}
    assert sum(a.status == "superseded" for a in answers) >= 1


def test_with_grace_the_planner_waits_for_a_search_before_it_draws(made_graph: MotionGraph) -> None:
    latency, grace = 0.3, 0.25
    spared = 0
    for seed in range(12):
        counted = []
        for allowed in (0.0, grace):
            clock = SimulatedClock()
            searches = SimulatedSearches(latency)
            planner = Planner(made_graph, clock=clock, searches=searches, seed=seed, grace=allowed)
            clock.advance(0.8)
            planner.advance()
            attack = world_throw(planner, np.random.default_rng(seed), 0.8, arrives=2.0)
            planner.attack(attack)
            while clock.now() < attack.end + 0.2:
                final = planner.advance()
                assert final >= clock.now() - allowed
                clock.advance(1 / 60)
            answer = planner.finish()[0]
            assert check_independently(planner, [attack]) == answer.hit
            counted.append(answer.restarts)
        assert counted[1] <= counted[0]
        spared += counted[1] < counted[0]
    assert spared >= 2
    with pytest.raises(ConfigError, match="grace"):
        Planner(made_graph, grace=-0.1)


def test_of_edges_long_past_only_what_the_feet_were_off_is_kept(made_graph: MotionGraph) -> None:
    line, rng = Timeline(made_graph, 0), np.random.default_rng(0)
    for _ in range(8):
        line.append(int(rng.choice(made_graph.edges_from(line.node))))
    line.sample(np.arange(0.0, line.deadline, 1 / 30))
    for state in line._feet[1:]:
        for each in jax.tree.leaves(state):
            base = each.base if isinstance(each, np.ndarray) else None
            assert base is None or base.nbytes == each.nbytes
