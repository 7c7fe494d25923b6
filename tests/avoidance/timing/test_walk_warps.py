from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.checks.written import (
    SphereTrajectory,
    clearance,
    sphere_trajectory,
    walk_motion,
)
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.selection import Selection, both_timings, select, write
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.rates import CLEAR_M, EXPORT_RATE
from mgjax.avoidance.timing.walk_warps import (
    LEEWAY,
    linear_warp,
    part_moments,
    smooth_warp,
    speed_change,
)
from mgjax.cli.avoid import selection_json
from mgjax.cli.report import to_json
from mgjax.core.errors import ConfigError, MotionError
from mgjax.core.timing.time_warp import TimeWarp
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import make_walk, sample_walk
from tests.avoidance.made import make_graph, throw
from tests.reference import warp as reference

QUICK = AvoidanceConfig(checks=12, refine="off")


def stretches(runs: list[tuple[float, float]]) -> TimeWarp:
    """One speed for each (seconds of the walk, speed)."""
    lengths, speeds = np.array(runs).T
    places = np.concatenate([[0.0], np.cumsum(lengths)])
    times = np.concatenate([[0.0], np.cumsum(lengths / speeds)])
    return TimeWarp(
        times=np.repeat(times, 2),
        positions=np.repeat(places, 2),
        speeds=np.concatenate([[1.0], np.repeat(speeds, 2), [1.0]]),
    )


def random_runs(rng: np.random.Generator) -> tuple[list[tuple[float, float]], float]:
    """Runs of which some are scaled, and when an avoidance in the last one has its middle."""
    speed = np.exp(rng.uniform(0.02, np.log(4))) ** rng.choice([-1, 1])
    count = int(rng.integers(1, 6))
    scaled = rng.random(count) < 0.7
    scaled[rng.integers(count)] = True
    lengths = rng.choice([1 / 30, 2 / 30, 0.2, 0.5, 1.0], size=count)
    runs = [(float(x), float(speed) if s else 1.0) for x, s in zip(lengths, scaled, strict=True)]
    before = sum(x / v for x, v in runs[:-1])
    t_avoid = before + rng.uniform(0.2, 0.9) * runs[-1][0] / runs[-1][1]
    if all(v == 1 for _, v in runs[:-1]) and runs[-1][1] == 1:
        return random_runs(rng)
    return runs, t_avoid


def slopes(warp: TimeWarp) -> np.ndarray:
    lasts = np.diff(warp.times)
    return np.abs(np.diff(warp.speeds)[lasts > 1e-9] / lasts[lasts > 1e-9])


@pytest.mark.parametrize("sign", [1, -1])
def test_by_hand(sign: int) -> None:
    # 1.2 s of the walk within 1 s, from speed 1 to 1.2 (or 0.8 s, to 0.8): the speed rises to 1 + x
    # and falls to 1.2 at one rate a, so 2 x - 0.2 = a, and what it plays more than 1 s is
    # (2 x² - 0.04) / 2 a = 0.2. Hence x = 0.2 + 0.1 √2 and a = 0.2 + 0.2 √2.
    linear = stretches([(4.0, 1 + 0.2 * sign)])
    smooth = smooth_warp(linear, 1.0, (1.0, 1.0))
    rate, top = 0.2 + 0.2 * np.sqrt(2), 0.2 + 0.1 * np.sqrt(2)
    turn = top / rate
    times = np.array([-1.0, 0.0, turn / 2, turn, 1.0])
    speeds = 1 + sign * np.array([0.0, 0.0, top / 2, top, 0.2])
    np.testing.assert_allclose(smooth.speed(times), speeds, atol=1e-9)
    places = np.array([-1.0, 0.0, turn / 2 + sign * turn * top / 8, turn, 1 + 0.2 * sign])
    places[3] += sign * turn * top / 2
    np.testing.assert_allclose(smooth.at(times), places, atol=1e-9)
    np.testing.assert_allclose(smooth.when(places), times, atol=1e-9)
    # Then back to 1 in 0.2 / a s, and at that speed for ever.
    back = 1 + 0.2 / rate
    np.testing.assert_allclose(smooth.speed(np.array([back, 9.0])), 1.0, atol=1e-9)
    passed = smooth.at(np.array([back, 9.0]))
    np.testing.assert_allclose(passed[0], places[-1] + (back - 1) * (1 + 0.1 * sign), atol=1e-9)
    np.testing.assert_allclose(passed[1] - passed[0], 9 - back, atol=1e-9)


def test_nothing_is_played_faster_than_asked_for() -> None:
    rng = np.random.default_rng(3)
    kept = 0
    for _ in range(40):
        runs, t_avoid = random_runs(rng)
        linear = stretches(runs)
        free = smooth_warp(linear, t_avoid, (0.8 * t_avoid, t_avoid))
        limit = max(linear.speeds.max(), 1 + rng.uniform(0, 0.3))
        smooth = smooth_warp(linear, t_avoid, (0.8 * t_avoid, t_avoid), limit)
        assert smooth.speeds.max() <= limit + 1e-9
        np.testing.assert_allclose(smooth.at(np.array([t_avoid])), linear.at(np.array([t_avoid])))
        if free.speeds.max() <= limit:
            np.testing.assert_allclose(smooth.speeds, free.speeds, atol=1e-6)
        kept += smooth is linear
    assert 0 < kept < 20
    # All of it at the limit: there is no other way.
    linear = stretches([(4.0, 1.15)])
    assert smooth_warp(linear, 1.0, (1.0, 1.0), 1.15) is linear


def test_against_brute_force() -> None:
    rng = np.random.default_rng(1)
    for _ in range(6):
        runs, t_avoid = random_runs(rng)
        smooth = smooth_warp(stretches(runs), t_avoid, (t_avoid, t_avoid))
        before = sum(x / v for x, v in runs[:-1])
        runs[-1] = ((t_avoid - before) * runs[-1][1], runs[-1][1])
        rate = reference.slowest_change(runs, LEEWAY, t_avoid)
        assert slopes(smooth).max() == pytest.approx(rate, rel=0.02)
        places, speeds = reference.fastest(runs, LEEWAY, rate)
        times = reference.times_of(places, speeds)
        np.testing.assert_allclose(smooth.when(places), times, atol=2e-3)


def test_what_a_smooth_warp_keeps() -> None:
    rng = np.random.default_rng(2)
    met_early = 0
    for _ in range(300):
        runs, t_avoid = random_runs(rng)
        linear = stretches(runs)
        near = (t_avoid - rng.uniform(0, 0.3), t_avoid + rng.uniform(0, 0.3))
        smooth = smooth_warp(linear, t_avoid, near)
        at = np.array([t_avoid])
        np.testing.assert_allclose(smooth.at(at), linear.at(at), atol=1e-6)  # s; 1 ms is asked
        # Natural before and after, monotone, and without a jump.
        assert smooth.speeds[0] == smooth.speeds[-1] == 1.0
        assert (np.diff(smooth.times) >= 0).all()
        assert (smooth.speeds > 0).all()
        at_once = np.diff(smooth.times) < 1e-9
        np.testing.assert_allclose(np.diff(smooth.speeds)[at_once], 0.0, atol=1e-5)
        rate = slopes(smooth)
        moving = rate[rate > 1e-6]
        np.testing.assert_allclose(moving, moving[0], rtol=1e-4)
        # No edge is much faster or slower than the scales say, and none the other way.
        up = runs[0][1] > 1 or any(v > 1 for _, v in runs)
        places = np.linspace(0, float(linear.at(at)[0]), 50)[1:-1]
        ratio = smooth.speed(smooth.when(places)) / linear.speed(linear.when(places))
        assert ((ratio if up else 1 / ratio) <= LEEWAY * (1 + 1e-6)).all()
        # While the attack is near, the same is shown, where one speed lasts that long.
        begin = max(near[0], t_avoid / 2)
        window = np.linspace(begin, t_avoid, 20)
        same = np.abs(smooth.at(window) - linear.at(window)).max() < 1e-6
        met_early += same
        times = np.linspace(-0.5, t_avoid + 3, 200)
        np.testing.assert_allclose(smooth.when(smooth.at(times)), times, atol=1e-9)
    assert met_early > 100


def test_nothing_scaled_and_what_cannot_be() -> None:
    same = smooth_warp(stretches([(0.5, 1.0), (2.0, 1.0)]), 1.0, (0.9, 1.1))
    times = np.linspace(-1, 4, 30)
    np.testing.assert_array_equal(same.at(times), times)
    np.testing.assert_array_equal(same.speed(times), 1.0)
    np.testing.assert_array_equal(same.when(times), times)
    assert speed_change(same, 3.0, 120.0) == 0.0
    with pytest.raises(MotionError, match="expected one after now"):
        smooth_warp(stretches([(1.0, 2.0)]), 0.0, (0.0, 0.0))
    with pytest.raises(MotionError, match="sped up and slowed down, expected one"):
        smooth_warp(stretches([(1.0, 2.0), (1.0, 0.5)]), 1.0, (1.0, 1.0))


def test_extremes() -> None:
    # A single frame, fourfold both ways; and a factor far outside the limit.
    for length, speed in ((1 / 60, 4.0), (1 / 60, 0.25), (3.0, 50.0), (0.02, 0.01)):
        t_avoid = length / speed
        smooth = smooth_warp(stretches([(2 * length, speed)]), t_avoid, (0.0, t_avoid))
        assert abs(smooth.at(np.array([t_avoid]))[0] - length) < 1e-9
        assert np.isfinite([*smooth.times, *smooth.positions, *smooth.speeds]).all()
        assert (smooth.speeds > 0).all()


def test_next_to_nothing_is_scaled() -> None:
    # Just before the attack is near, and so little that it makes no difference.
    for length in (0.0, 1e-17, 1e-12, 1e-10, 1e-6):
        linear = stretches([(0.6 - length, 1.0), (2.0, 2.0)])
        smooth = smooth_warp(linear, 1.0, (0.6, 1.2))
        assert abs(smooth.at(np.array([1.0]))[0] - linear.at(np.array([1.0]))[0]) < 1e-6
        linear = stretches([(1.0 - length, 1.0), (2.0, 0.5)])
        smooth = smooth_warp(linear, 1.0, (0.6, 1.2))
        assert abs(smooth.at(np.array([1.0]))[0] - linear.at(np.array([1.0]))[0]) < 1e-6
        assert np.isfinite([*smooth.times, *smooth.speeds]).all()


def test_change_of_speed() -> None:
    # From natural to double speed at once: 1 within a frame. Mirrored: 1 - 1/2.
    assert speed_change(stretches([(2.0, 2.0)]), 0.5, 120.0) == pytest.approx(120.0)
    assert speed_change(stretches([(1.0, 0.5)]), 1.0, 120.0) == pytest.approx(60.0)
    # The jump is later than what counts.
    late = stretches([(1.0, 1.0), (1.0, 2.0)])
    assert speed_change(late, 0.9, 120.0) == 0.0
    assert speed_change(late, 1.1, 120.0) == pytest.approx(120.0)
    # Of a ramp it is the slope.
    ramp = smooth_warp(stretches([(4.0, 1.2)]), 1.0, (1.0, 1.0))
    assert speed_change(ramp, 2.0, 120.0) == pytest.approx(0.2 + 0.2 * np.sqrt(2), rel=1e-6)


def test_the_linear_form_is_what_the_scales_say() -> None:
    graph = make_graph([(0, 1, 30), (1, 2, 2), (2, 0, 41)], [(2, 6, 12)])
    walk = make_walk(graph, [0, 1, 2, 0], [0.7, 1.0, 0.7, 1.0])
    warp = linear_warp(graph, walk)
    times = np.arange(200) / 120
    plain = sample_walk(graph, walk, times)
    played = walk_motion(graph, walk, 199 / 120, warp)
    assert played.frame_rate == EXPORT_RATE
    np.testing.assert_allclose(played.root_translation, plain.root_translation, atol=1e-5)
    np.testing.assert_allclose(played.local_rotations, plain.local_rotations, atol=1e-5)
    np.testing.assert_allclose(warp.when(warp.at(times)), times, atol=1e-12)
    # The part: frames 6 … 12 of the third edge.
    moments = part_moments(graph, walk, 3, 0)
    np.testing.assert_allclose(moments, 32 / 30 + np.array([6, 9, 12]) / 30)
    np.testing.assert_allclose(warp.when(moments[1:2]), walk.starts(graph)[2] + 0.7 * 9 / 30)


@pytest.fixture(scope="module")
def answers(any_graph: MotionGraph) -> list[tuple[int, Attack, Selection]]:
    rng = np.random.default_rng(6)
    found = []
    for number in range(20):
        node = int(rng.integers(any_graph.num_nodes))
        attack = throw(rng, arrives=rng.uniform(0.9, 1.5), gravity=number % 3 == 0)
        found.append((node, attack, select(any_graph, node, attack, config=QUICK)))
    return found


def test_answers_are_smooth_clear_and_in_time(any_graph: MotionGraph, answers: list) -> None:
    radii = preset_spheres(any_graph.skeleton).radii
    smooth = other = 0
    for node, attack, chosen in answers:
        plain = select(any_graph, node, attack, config=replace(QUICK, warp="linear"))
        assert plain.warp == "linear"
        count = min(len(plain.walk.edges), len(chosen.walk.edges))
        if (plain.walk.edges[:count] != chosen.walk.edges[:count]).any():
            # What is clear in one form, with its feet kept, may be touched in the other.
            assert chosen.status == "avoided"
            other += 1
            continue
        assert plain.status == chosen.status
        if chosen.status != "avoided":
            assert chosen.warp == "linear"
            np.testing.assert_array_equal(
                plain.motion.root_translation, chosen.motion.root_translation
            )
            continue
        smooth += chosen.warp == "smooth"
        assert chosen.clearance_m >= CLEAR_M
        assert clearance(attack, chosen.trace, radii)[1] == chosen.clearance_m
        middle = part_moments(any_graph, chosen.walk, chosen.path_length, chosen.part)[1:2]
        late = 0.5 / any_graph.frame_rate if chosen.time_scale == 1.0 else 0.0
        for one in (chosen, plain):
            assert abs(one.timing.when(middle)[0] - chosen.crop.middle) <= late + 1e-3
        assert abs(chosen.timing.when(middle)[0] - plain.timing.when(middle)[0]) < 1e-6
        until = attack.end + QUICK.settle_s
        changes = [speed_change(one.timing, until, EXPORT_RATE) for one in (chosen, plain)]
        assert changes[0] <= changes[1] + 1e-9
        if chosen.time_scale != 1.0 and chosen.warp == "smooth":
            assert changes[0] < 0.5 * changes[1]
        # The walk is long enough to show something new to the end.
        natural = any_graph.edge_frames[chosen.walk.edges].sum() / any_graph.frame_rate
        assert chosen.timing.at(np.array([until]))[0] <= natural + 1e-9
    assert smooth >= 5
    assert other <= 3


def furthest(
    traces: list[SphereTrajectory], radii: np.ndarray, late: int
) -> tuple[int, np.ndarray, float]:
    """The sphere centre of the second trace that is furthest from the first at about a moment."""
    places = traces[1].centres[late]
    body = traces[0].centres[late - 2 : late + 3].swapaxes(0, 1)
    gaps = np.linalg.norm(places[:, None, None] - body[None], axis=-1) - radii[:, None]
    room = gaps.min(axis=(1, 2))
    return late, places[np.argmax(room)], float(room.max())


def test_linear_where_the_smooth_form_is_touched(any_graph: MotionGraph, answers: list) -> None:
    spheres = preset_spheres(any_graph.skeleton)
    fell_back = 0
    for node, attack, chosen in answers:
        if chosen.status != "avoided" or chosen.warp != "smooth":
            continue
        choice = choose(any_graph, node, attack, config=QUICK)
        traces = [
            sphere_trajectory(any_graph, spheres, walk_motion(any_graph, choice.walk, 1.0, timing))
            for timing in both_timings(any_graph, choice)
        ]
        # A speck where the smooth form has a sphere for a moment, and the other has none.
        late, place, room = max(
            (furthest(traces, spheres.radii, late) for late in range(24, 200, 8)),
            key=lambda found: found[2],
        )
        if room < 0.004:
            continue
        speck = Attack(
            times=late / 240 + np.array([-0.004, 0.004]),
            centres=np.tile(place, (2, 1, 1)),
            radii=np.array([0.001]),
        )
        found = write(prepared_for(any_graph, QUICK), speck, choice, QUICK)
        assert found.warp == "linear"
        assert found.status == "avoided"
        assert (found.clearance_m or 0.0) >= CLEAR_M
        np.testing.assert_array_equal(found.walk.edges, choice.walk.edges)
        fell_back += 1
    assert fell_back >= 1


def test_what_the_command_says(any_graph: MotionGraph, answers: list) -> None:
    for _, attack, chosen in answers:
        result = json.loads(to_json(selection_json(any_graph, chosen)))
        said = result["warp"]
        assert said["form"] == chosen.warp
        change = said["speed_change_per_s"]
        assert change["smooth"] <= change["linear"] + 1e-9
        low, high = said["speed"]
        assert 0 < low <= 1 <= high or result["time_scale"] not in (None, 1.0)
        if chosen.part is None:
            assert said["t_avoid"] is None
            assert (low, high, change["linear"]) == (1.0, 1.0, 0.0)
        else:
            half = 0.5 / any_graph.frame_rate if chosen.time_scale == 1.0 else 0.0
            assert abs(said["t_avoid"] - chosen.crop.middle) <= half + 1e-3
        end = 0.0
        for row in result["walk"]:
            assert row["start_s"] == pytest.approx(end, abs=1e-9)
            natural = any_graph.edge_frames[row["edge"]] / any_graph.frame_rate
            assert row["end_s"] - end == pytest.approx(natural * row["scale"])
            end = row["end_s"]
        assert end >= attack.end + QUICK.settle_s - 1e-6


def test_an_unknown_warp(made_graph: MotionGraph) -> None:
    config = AvoidanceConfig()
    object.__setattr__(config, "warp", "bent")
    with pytest.raises(ConfigError, match="got warp = 'bent', expected smooth or linear"):
        select(made_graph, 0, throw(np.random.default_rng(0)), config=config)
