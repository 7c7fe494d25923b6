from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import MOMENTS, evaluated, make_attack_batch
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.body.edge_tables import speed_classes
from mgjax.avoidance.body.spheres import sphere_centres
from mgjax.avoidance.candidates.batch import CANDIDATE_BUCKETS, pad_candidates
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig, SpeedConfig
from mgjax.avoidance.energy import accumulate, evaluate
from mgjax.avoidance.energy.accumulate import TIMES
from mgjax.avoidance.energy.evaluate import judge
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.rates import FAR
from mgjax.avoidance.timing.time_scale import OK
from mgjax.core.kinematics import global_positions
from mgjax.graph.types import NO_EDGE, MotionGraph
from mgjax.graph.walk import Walk, make_walk, sample_walk
from tests.avoidance.made import random_graph, throw
from tests.reference import avoidance as reference
from tests.reference import energy as energy_reference

CONFIGS = {
    "default": AvoidanceConfig(),
    "paper": AvoidanceConfig(
        energy=EnergyConfig(
            form="paper", d0="paper", E_avoidance=40.0, w_a=0.5, w_m=0.0, w_t=2.0, w_speed_up=1.0
        ),
        speed=SpeedConfig(V_fast=0.3, V_slow=0.1, V_still=0.0),
        limit_scale=False,
    ),
}


def searched(
    graph: MotionGraph, config: AvoidanceConfig, seed: int, attack: Attack | None = None
) -> tuple[Candidates, Attack, Crop]:
    """A node with candidates for a random ball."""
    rng = np.random.default_rng(seed)
    tables = prepared_for(graph, config).tables
    for _ in range(200):
        thrown = throw(rng) if attack is None else attack
        crop = crop_attack(thrown, radius=1.0, height=2.3)
        assert crop is not None
        node = int(rng.integers(graph.num_nodes))
        found = enumerate_candidates(
            graph, tables, node, crop.middle, window=config.T_window, capacity=4096
        )
        if 5 <= len(found.length) <= 300:
            return found, thrown, crop
    raise AssertionError("no node with candidates")


def evaluation_times(attack: Attack, crop: Crop, config: AvoidanceConfig) -> np.ndarray:
    return np.linspace(crop.start, crop.end, evaluated(attack, crop, config))


def judged(
    graph: MotionGraph,
    candidates: Candidates,
    attack: Attack,
    crop: Crop,
    config: AvoidanceConfig,
) -> dict[str, np.ndarray]:
    prepared = prepared_for(graph, config)
    node = int(graph.edge_source[candidates.edges[0, 0]])
    query = Query(prepared=prepared, config=config, node=node, attack=attack, crop=crop)
    return judge(
        prepared.device,
        candidates,
        attack,
        crop,
        config,
        frame_rate=graph.frame_rate,
        unmoved=query.unmoved,
    )


def slowly(
    graph: MotionGraph,
    candidates: Candidates,
    index: int,
    attack: Attack,
    crop: Crop,
    config: AvoidanceConfig,
    *,
    exact_poses: bool,
) -> dict[str, float]:
    """One candidate by the plain definitions.

    With ``exact_poses`` the body comes from the walk's motion at every time, else from spheres
    that move linearly from frame to frame, as the tables have them.
    """
    tables = prepared_for(graph, config).tables
    edges = candidates.edges[index, : candidates.length[index]]
    part = candidates.part[index]
    seconds = graph.edge_frames[edges] / graph.frame_rate
    slow, fast = speed_classes(tables.top_speed, config.speed)
    frames = np.array([graph.label_starts[part], graph.label_stops[part]])
    begin, end = (frames - graph.edge_starts[edges[-1]]) / graph.frame_rate
    limit = config.energy.E_time if config.limit_scale else np.inf
    s, scales, status = reference.time_scale(
        seconds, slow[edges], fast[edges], 0.5 * (begin + end), crop.middle, 0.5 / 30, limit
    )
    if status != "ok":
        return {"status": status}
    starts = np.concatenate([[0.0], np.cumsum(seconds * scales)])
    t0, t1 = starts[-2] + begin * scales[-1], starts[-2] + end * scales[-1]
    times = evaluation_times(attack, crop, config)
    spheres = tables.spheres

    def body(time: float) -> np.ndarray:
        if not exact_poses:
            return reference.body_at(graph, spheres, edges, scales, time)
        walk = Walk(edges=edges, scales=np.array(scales))
        motion = sample_walk(graph, walk, np.array([time]))
        return np.asarray(sphere_centres(spheres, global_positions(graph.skeleton, motion)))[0]

    wanted = energy_reference.energies(
        attack.at(times),
        attack.radii,
        np.stack([body(time) for time in times]),
        spheres.radii,
        body(t0),
        (times >= t0) & (times < t1),
        times <= starts[-1],
        dt=times[1] - times[0],
        config=config.energy,
    )
    e = config.energy
    timescale = energy_reference.time_scale_energy(s, e.E_time, e.w_speed_up)
    onward = reference.edges_onward(graph, int(graph.edge_source[edges[0]]), crop.end)
    moments = [crop.end * k / MOMENTS for k in range(1, MOMENTS + 1)]
    displacement = energy_reference.displacement(
        [body(min(time, starts[-1])) for time in moments],
        [reference.body_at(graph, spheres, onward, [1.0] * len(onward), t) for t in moments],
    )
    displacement = displacement if e.w_m > 0 else 0.0  # nothing asks for it
    counted = np.array([*seconds[:-1], 0.5 * (begin + end)])
    free = counted[(fast if counted.sum() > crop.middle else slow)[edges]].sum()
    return {
        "status": status,
        "s_time": s,
        "s_error": 0.0 if s == 1.0 else rounding(counted, crop.middle) / free,
        "timescale": timescale,
        "displacement": displacement,
        "movement": displacement / e.D_move,
        "total": e.w_a * wanted.avoidance
        + e.w_b * wanted.body
        + e.w_m * displacement / e.D_move
        + e.w_t * timescale,
        **vars(wanted),
    }


def rounding(counted: np.ndarray, t_attack: float) -> float:
    """How far float32 may be off in t_attack − t_nonadjustable, s.

    The durations are rounded, then added up in an order that differs from processor to processor:
    each of the n summands and partial sums is off by half a unit in the last place, 2⁻²⁴ of the
    whole sum, at most. t_nonadjustable is the difference of two such sums.
    """
    whole = counted.sum()
    return 2.0**-24 * (t_attack + 2 * (len(counted) + 1) * whole)


@pytest.mark.parametrize("speed", [10.0, 1.5])
@pytest.mark.parametrize("name", CONFIGS)
def test_agrees_with_the_definitions(any_graph: MotionGraph, name: str, speed: float) -> None:
    # The slow ball is near for longer than the avoidance parts last.
    config = CONFIGS[name]
    ball = throw(np.random.default_rng(4), speed=speed, arrives=1.2)
    candidates, attack, crop = searched(any_graph, config, seed=4, attack=ball)
    got = judged(any_graph, candidates, attack, crop, config)
    rng = np.random.default_rng(0)
    usable = np.flatnonzero(got["status"] == OK)
    chosen = rng.choice(usable, min(6, len(usable)), replace=False)
    for index in chosen:
        wanted = slowly(any_graph, candidates, int(index), attack, crop, config, exact_poses=False)
        assert wanted.pop("status") == "ok"
        # Where t_attack is all but t_nonadjustable, s_time is a difference of nearly equal numbers
        # and eq. 9 divides by it: 1/s changes by at most Δs / (s (s − Δs)).
        s, error = wanted["s_time"], wanted.pop("s_error") + 1e-6 * wanted["s_time"]
        e = config.energy
        faster = max(e.w_speed_up, 1.0) * error / (s * max(s - error, 1e-9))
        change = max(error, faster) / e.E_time
        for key, value in wanted.items():
            value = min(float(value), FAR)
            allowed = {
                "s_time": error,
                "timescale": change + 1e-6 * value,
                "total": 2e-3 + e.w_m * 1e-3 + e.w_t * change,
                "penetration": 2e-3 * max(1.0, abs(value)),
            }.get(key, 2e-3)
            assert abs(got[key][index] - value) < allowed, (key, got[key][index], value)
    for index in np.flatnonzero(got["status"] != OK)[:3]:
        wanted = slowly(any_graph, candidates, int(index), attack, crop, config, exact_poses=False)
        assert wanted["status"] != "ok"


def test_near_the_poses_of_the_motion(any_graph: MotionGraph) -> None:
    # Volumes at the graph's rate, linear in between, rank; they are near the motion itself.
    config = AvoidanceConfig()
    candidates, attack, crop = searched(any_graph, config, seed=9)
    got = judged(any_graph, candidates, attack, crop, config)
    for index in np.flatnonzero(got["status"] == OK)[:4]:
        wanted = slowly(any_graph, candidates, int(index), attack, crop, config, exact_poses=True)
        assert abs(got["d"][index] - min(float(wanted["d"]), FAR)) < 0.02
        assert abs(got["d0"][index] - min(float(wanted["d0"]), FAR)) < 0.02


def test_padding_changes_nothing(made_graph: MotionGraph) -> None:
    config = AvoidanceConfig()
    candidates, attack, crop = searched(made_graph, config, seed=2)
    full = judged(made_graph, candidates, attack, crop, config)
    # Fewer candidates, and longer rows: other buckets, the same numbers.
    few = Candidates(
        edges=candidates.edges[:3], length=candidates.length[:3], part=candidates.part[:3],
        overflow=0,
    )  # fmt: skip
    extra = np.full((len(candidates.length), 40), NO_EDGE)
    wide = replace(candidates, edges=np.concatenate([candidates.edges, extra], axis=1))
    many = Candidates(
        edges=np.tile(candidates.edges, (40, 1)),
        length=np.tile(candidates.length, 40),
        part=np.tile(candidates.part, 40),
        overflow=0,
    )
    length = candidates.edges.shape[1]
    for other in (few, wide, many):
        got = judged(made_graph, other, attack, crop, config)
        for key, values in got.items():
            if key == "order":
                continue
            count = min(len(values), len(full[key]))
            a, b = full[key][:count], values[:count]
            if key == "scales":
                a, b = a[:, :length], b[:, :length]
            np.testing.assert_allclose(a, b, atol=2e-5, err_msg=key)
    assert len(judged(made_graph, many, attack, crop, config)["d"]) == 40 * len(full["d"])


def test_times_in_lots_change_nothing(
    made_graph: MotionGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    # All evaluated times in one lot, or in five.
    config = AvoidanceConfig()
    candidates, attack, crop = searched(made_graph, config, seed=2)
    assert 4 * 4 + 1 < evaluated(attack, crop, config) <= min(5 * 4 + 1, TIMES)
    at_once = judged(made_graph, candidates, attack, crop, config)
    jax.clear_caches()
    monkeypatch.setattr(accumulate, "TIMES", 5)  # each lot begins with the last of the one before
    in_lots = judged(made_graph, candidates, attack, crop, config)
    jax.clear_caches()
    for key in ("d", "d0", "penetration", "avoidance", "body", "total"):
        np.testing.assert_allclose(at_once[key], in_lots[key], atol=2e-5, err_msg=key)


def test_attacks_do_not_compile_anew(made_graph: MotionGraph) -> None:
    config = AvoidanceConfig()
    compiled = evaluate._judge
    shapes = set()
    for seed in range(12):
        candidates, attack, crop = searched(made_graph, config, seed=seed)
        shape = pad_candidates(candidates).edges.shape
        assert make_attack_batch(attack, crop, config, 1.0).frames.shape == (1, 256, 3)
        before = compiled._cache_size()
        judged(made_graph, candidates, attack, crop, config)
        assert compiled._cache_size() == before or shape not in shapes
        shapes.add(shape)
    assert len(shapes) <= len(CANDIDATE_BUCKETS)
    # Other numbers in the settings are traced, too.
    other = replace(config, energy=EnergyConfig(E_avoidance=0.7, D_body=0.1, w_b=3.0))
    before = compiled._cache_size()
    judged(made_graph, candidates, attack, crop, other)
    assert compiled._cache_size() == before


def test_evaluation_times() -> None:
    config = AvoidanceConfig()
    rng = np.random.default_rng(0)
    fast, slow = throw(rng, speed=10.0), throw(rng, speed=1.5)
    crop = Crop(start=1.0, end=1.2)
    times = evaluation_times(fast, crop, config)  # 0.12 m at 10 m/s
    assert (times[0], times[-1]) == (1.0, 1.2)
    assert np.diff(times).max() <= 0.012 + 1e-9
    assert np.diff(times).max() > 0.011
    assert np.diff(evaluation_times(slow, crop, config)).max() <= 0.05 + 1e-9
    assert len(evaluation_times(fast, Crop(start=1.0, end=1.0), config)) == 2


def test_a_walk_that_ends_before_the_attack(made_graph: MotionGraph) -> None:
    # Times after the end of the path count for nothing: d and d0 are far, no energy is NaN.
    graph = random_graph(1)
    config = AvoidanceConfig(speed=SpeedConfig(V_fast=1e9, V_slow=0.0, V_still=0.0))
    candidates = Candidates(
        edges=graph.label_edge[:1, None], length=np.array([1]), part=np.array([0]), overflow=0
    )
    attack = throw(np.random.default_rng(0), arrives=9.0)
    crop = crop_attack(attack, radius=1.0, height=2.3)
    assert crop is not None
    got = judged(graph, candidates, attack, crop, config)
    assert got["status"][0] != OK
    assert got["d"][0] == got["d0"][0] == FAR
    assert all(np.isfinite(values).all() for values in got.values())


def test_time_scaled_walks_meet_the_attack(any_graph: MotionGraph) -> None:
    config = AvoidanceConfig()
    candidates, attack, crop = searched(any_graph, config, seed=5)
    got = judged(any_graph, candidates, attack, crop, config)
    middle = 0.5 * (any_graph.label_starts + any_graph.label_stops)
    for index in np.flatnonzero(got["status"] == OK):
        length = candidates.length[index]
        walk = make_walk(any_graph, candidates.edges[index, :length], got["scales"][index, :length])
        part = candidates.part[index]
        within = (middle[part] - any_graph.edge_starts[walk.edges[-1]]) / any_graph.frame_rate
        t_avoid = walk.starts(any_graph)[-2] + within * walk.scales[-1]
        exact = got["s_time"][index] == 1.0
        assert abs(t_avoid - crop.middle) < (0.5 / 30 + 1e-4 if exact else 1e-4)
