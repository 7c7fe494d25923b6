from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mgjax.avoidance.attacks.attack import Attack, validate_attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.attacks.crop import crop_attack
from mgjax.avoidance.attacks.json_file import load_attack
from mgjax.avoidance.attacks.limb import limb_attack
from mgjax.avoidance.attacks.merge import merge_attacks
from mgjax.avoidance.body.spheres import preset_spheres, sphere_centres
from mgjax.avoidance.checks.written import clearance, trace_motion, walk_motion
from mgjax.avoidance.choice.selection import select
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.rates import FAR
from mgjax.clips.synthetic import synthetic_clips
from mgjax.clips.types import Clip
from mgjax.core import planar
from mgjax.core.errors import AttackError, FileFormatError, MgjaxError
from mgjax.core.kinematics import forward, global_positions, planar_frames
from mgjax.core.motion import Motion, cut, resample
from mgjax.core.skeleton import Skeleton
from mgjax.graph.types import MotionGraph
from tests.avoidance.checks.test_written import some_walk
from tests.avoidance.made import throw

LIMB_NAMES = {
    "left_hand": ("left_elbow-left_wrist 0.00", "left_wrist-left_hand 0.60"),
    "right_hand": ("right_elbow-right_wrist 0.00", "right_wrist-right_hand 0.60"),
    "left_foot": ("left_knee-left_ankle 0.00", "left_ankle-left_toe 1.00"),
    "right_foot": ("right_knee-right_ankle 0.00", "right_ankle-right_toe 1.00"),
}
"""First and last sphere."""


def place(attack: Attack, time: float, sphere: int = 0) -> np.ndarray:
    return attack.at(np.array([time]))[0, sphere]


def flown(velocity: np.ndarray, start: np.ndarray, times: np.ndarray, c: float, g: float):
    """The same flight by an adaptive integrator."""

    def slope(_: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[3:], [0, -g, 0] - c * y[3:]])

    state = np.concatenate([start, velocity])
    found = solve_ivp(slope, (0, times[-1]), state, t_eval=times, rtol=1e-11, atol=1e-12)
    return found.y[:3].T


@pytest.mark.parametrize("gravity", [False, True])
@hypothesis.given(
    start=st.tuples(st.floats(-6, 6), st.floats(0.1, 3), st.floats(2, 6)),
    at=st.tuples(st.floats(-0.5, 0.5), st.floats(0.1, 2), st.floats(-0.5, 0.5)),
    speed=st.floats(14, 40),
    arrives=st.floats(0.6, 3),
    drag=st.one_of(st.just(1e-9), st.floats(0.001, 0.9)),
)
def test_drag_is_what_an_integrator_finds(gravity, start, at, speed, arrives, drag) -> None:
    a, b = np.array(start), np.array(at)
    attack = ball_attack(a, b, speed=speed, arrives=arrives, gravity=gravity, drag=drag)
    validate_attack(attack)
    np.testing.assert_allclose(place(attack, arrives), b, atol=1e-6)
    since = attack.times - attack.start
    hypothesis.assume(attack.start > 0)  # else the launch was before
    # The launch velocity from the first two knots, which a parabola joins to third order.
    g = 9.8 if gravity else 0.0
    dt, e = since[1], np.expm1(-drag * since[1])
    coast = -e / drag
    fall = (dt - coast) / drag if drag > 1e-6 else dt * dt / 2
    step = attack.centres[1, 0] - attack.centres[0, 0]
    velocity = (step + np.array([0, g * fall, 0])) / coast
    np.testing.assert_allclose(np.linalg.norm(velocity), speed, rtol=1e-6)
    wanted = flown(velocity, a, since, drag, g)
    np.testing.assert_allclose(attack.centres[:, 0], wanted, atol=1e-6)
    # Its speed only falls towards that of its weight, and so does the acceleration.
    pull = np.array([0.0, -g, 0.0])
    np.testing.assert_allclose(
        attack.acceleration, np.linalg.norm(pull - drag * velocity), rtol=1e-5, atol=1e-9
    )


def test_drag_by_hand() -> None:
    # 10 m/s under 2 /s: (1 − e^−2t) · 5 m; 4 m take ln 5 / 2 s, and 5 m are never reached.
    attack = ball_attack(
        np.array([0.0, 1.0, 4.0]), np.array([0.0, 1.0, 0.0]), speed=10.0, arrives=2.0, drag=2.0
    )
    np.testing.assert_allclose(attack.start, 2.0 - np.log(5) / 2, atol=1e-12)
    np.testing.assert_allclose(attack.acceleration, 20.0)
    np.testing.assert_allclose(attack.end, 32.0)  # it stops a metre behind
    np.testing.assert_allclose(place(attack, 32.0), (0, 1, -1), atol=1e-9)
    with pytest.raises(AttackError, match=r"under drag, expected at least 8\.00"):
        ball_attack(
            np.array([0.0, 1.0, 4.0]), np.array([0.0, 1.0, 0.0]), speed=8.0, arrives=2.0, drag=2.0
        )


@pytest.mark.parametrize("drag", [1e-7, 0.1, 1.0, 5.0])
@pytest.mark.parametrize(
    ("start", "at"),
    [((3, 1.5, 4), (0.2, 1.2, 0)), ((0, 0.2, 6), (0, 1.9, 0)), ((0, 2, 2), (0, 0, 0))],
)
def test_least_speed_and_flatter_throw(start, at, drag: float) -> None:
    a, b = np.array(start, np.float64), np.array(at, np.float64)

    def thrown(speed: float) -> Attack:
        return ball_attack(a, b, speed=speed, arrives=20.0, gravity=True, drag=drag)

    with pytest.raises(AttackError, match="cannot reach") as caught:
        thrown(0.5)
    least = float(re.search(r"at least ([0-9.]+) m/s", str(caught.value))[1])  # type: ignore[index]
    slow = 20.0 - thrown(least).start
    with pytest.raises(AttackError, match="cannot reach"):
        thrown(least - 0.005)
    # A quicker throw takes less time, and no time below its own takes its speed.
    quick = thrown(1.3 * least)
    flight = 20.0 - quick.start
    assert flight < slow
    times = np.linspace(0.02, 1, 400) * flight
    coast = -np.expm1(-drag * times) / drag
    fall = times**2 / 2 if drag < 1e-5 else (times - coast) / drag
    needed = np.linalg.norm((b - a) + np.array([0, 9.8, 0]) * fall[:, None], axis=1) / coast
    assert (needed[:-1] > 1.3 * least).all()
    np.testing.assert_allclose(needed[-1], 1.3 * least, rtol=1e-5)


def test_drag_known_from_now_and_floor() -> None:
    args = np.array([0.0, 2.0, 8.0]), np.array([0.0, 1.0, 0.0])
    whole = ball_attack(*args, speed=20.0, arrives=2.0, gravity=True, drag=0.5)
    late = ball_attack(*args, speed=20.0, arrives=0.1, gravity=True, drag=0.5)
    assert late.start == 0.0
    np.testing.assert_allclose(late.at(late.times), whole.at(late.times + 1.9), atol=1e-4)
    assert late.acceleration < whole.acceleration
    lob = ball_attack(
        np.array([0.0, 1.0, 3.0]),
        np.array([0.0, 0.1, 0.0]),
        speed=8,
        arrives=2,
        gravity=True,
        drag=1,
    )
    np.testing.assert_allclose(lob.centres[-1, 0, 1], 0.0, atol=1e-9)
    for drag in (-0.1, 101.0, float("nan")):
        with pytest.raises(AttackError, match="got drag"):
            ball_attack(*args, speed=20.0, arrives=2.0, drag=drag)


@pytest.fixture(scope="module")
def attacker() -> tuple[Skeleton, Motion]:
    """A clip whose left hand is quickest in frame 100, 3.33 s after its beginning."""
    found: list[tuple[float, int, Clip]] = []
    for clip in synthetic_clips(frame_rate=30.0)[0]:
        hands = global_positions(clip.skeleton, clip.motion)[:, clip.skeleton.index("lhand")]
        speed = np.linalg.norm(np.diff(hands, axis=0), axis=1)[100:-60]
        if len(speed):
            found.append((float(speed.max()), int(np.argmax(speed)), clip))
    quickest, frame, clip = max(found, key=lambda item: item[:2])
    assert quickest * 30 > 1.0
    return clip.skeleton, cut(clip.motion, frame, clip.motion.num_frames)


@pytest.mark.parametrize("limb", LIMB_NAMES)
def test_limb_is_forward_kinematics(attacker, limb: str) -> None:
    skeleton, motion = attacker
    hit, stands = 100 / 30, np.array([2.8, 0.4, 1.1])
    attack = limb_attack(skeleton, motion, limb=limb, hit_s=hit, arrives=1.0, place=stands)
    validate_attack(attack)
    np.testing.assert_allclose((attack.start, attack.end), (0.6, 1.3), atol=1e-9)
    positions, _ = forward(skeleton, motion.root_translation, motion.local_rotations)
    spheres = preset_spheres(skeleton)
    first, last = (spheres.names.index(name) for name in LIMB_NAMES[limb])
    body = np.asarray(planar_frames(skeleton, positions))[100].astype(np.float64)
    move = planar.compose(stands, np.asarray(planar.inverse(body)))
    world = np.asarray(planar.apply(move, np.asarray(sphere_centres(spheres, positions))))
    for frame in range(88, 109):
        there = attack.at(np.array([(frame - 100) / 30 + 1.0]))[0]
        np.testing.assert_allclose(there[0], world[frame, first], atol=2e-5)
        np.testing.assert_allclose(there[-1], world[frame, last], atol=2e-5)
    np.testing.assert_allclose(attack.radii[[0, -1]], spheres.radii[[first, last]])
    assert len(attack.radii) == (3 if "hand" in limb else 5)
    assert np.diff(attack.times).max() < 1 / 239
    # Between knots it bends no more than it says.
    fine = resample(cut(motion, 88, 110), 960.0)
    positions, _ = forward(skeleton, fine.root_translation, fine.local_rotations)
    world = np.asarray(planar.apply(move, np.asarray(sphere_centres(spheres, positions))))
    times = np.arange(fine.num_frames) / 960 + (88 - 100) / 30 + 1.0
    inside = times <= attack.end
    off = np.linalg.norm(attack.at(times[inside])[:, -1] - world[inside][:, last], axis=-1)
    assert off.max() <= attack.acceleration * np.diff(attack.times).max() ** 2 / 8 + 2e-5


@pytest.mark.parametrize("side", [0.0, np.pi / 2, -2.0])
def test_limb_meets_a_target(attacker, side: float) -> None:
    skeleton, motion = attacker
    attack = limb_attack(
        skeleton, motion, limb="right_hand", hit_s=2.01, arrives=0.8, target=(0.1, -0.2), side=side
    )
    end = place(attack, 0.8, -1)
    np.testing.assert_allclose(end[[0, 2]], (0.1, -0.2), atol=1e-9)
    # The same limb in the attacker's own frame tells how the body is turned and where it stands.
    own = limb_attack(
        skeleton, motion, limb="right_hand", hit_s=2.01, arrives=0.8, place=(0.0, 0.0, 0.0)
    )
    mine, world = (x.at(np.array([0.8]))[0] for x in (own, attack))
    turns = [np.arctan2(*(x[-1] - x[0])[[0, 2]]) for x in (mine, world)]
    turn = np.array([turns[1] - turns[0], 0.0, 0.0])
    root = (world[-1] - np.asarray(planar.apply(turn, mine[-1])))[[0, 2]]
    way = root - (0.1, -0.2)
    np.testing.assert_allclose(np.linalg.norm(way), np.hypot(*mine[-1, [0, 2]]), atol=1e-9)
    np.testing.assert_allclose(way / np.linalg.norm(way), (np.sin(side), np.cos(side)), atol=1e-9)


def test_limb_is_cut_to_the_motion_and_to_now(attacker) -> None:
    skeleton, motion = attacker
    stands = (0.0, 0.0, 2.0)
    early = limb_attack(skeleton, motion, limb="left_foot", hit_s=0.1, arrives=1.0, place=stands)
    np.testing.assert_allclose(early.start, 0.9)
    soon = limb_attack(skeleton, motion, limb="left_foot", hit_s=2.0, arrives=0.123, place=stands)
    np.testing.assert_allclose(soon.start, 0.0, atol=1e-12)
    whole = limb_attack(skeleton, motion, limb="left_foot", hit_s=2.0, arrives=1.0, place=stands)
    np.testing.assert_allclose(soon.at(soon.times), whole.at(soon.times + 0.877), atol=1e-3)
    last = (motion.num_frames - 1) / 30
    late = limb_attack(skeleton, motion, limb="left_foot", hit_s=last, arrives=1.0, place=stands)
    assert late.end == 1.0
    one = limb_attack(
        skeleton, cut(motion, 5, 6), limb="left_foot", hit_s=0.0, arrives=1.0, place=stands
    )
    assert len(one.times) == 1


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"limb": "tail"}, "limb 'tail', expected one of left_hand"),
        ({"hit_s": -0.1}, "hit_s = -0.1"),
        ({"hit_s": 1e4}, "hit_s = 10000"),
        ({"hit_s": float("nan")}, "hit_s = nan"),
        ({"before_s": -1.0}, "before_s"),
        ({"after_s": float("inf")}, "after_s"),
        ({"arrives": 0.0}, "arrival 0"),
        ({"arrives": float("nan")}, "arrival nan"),
        ({"place": None}, "place and target"),
        ({"target": (0.0, 0.0)}, "place and target"),
        ({"place": (0.0, 1.0)}, "expected 3 numbers"),
        ({"place": (0.0, float("nan"), 0.0)}, "expected 3 numbers"),
        ({"side": float("nan")}, "side"),
    ],
)
def test_bad_limbs(attacker, change: dict, text: str) -> None:
    more: dict[str, Any] = {"limb": "left_hand", "hit_s": 1.0, "arrives": 1.0, "place": (0, 0, 2)}
    with pytest.raises(AttackError, match=text) as caught:
        limb_attack(*attacker, **(more | change))
    assert "\n" not in str(caught.value)


def straight(start: float, stop: float, begin, end) -> Attack:
    return Attack(
        times=np.array([start, stop]),
        centres=np.array([[begin], [end]], np.float64),
        radii=np.array([0.1]),
    )


def test_merged_by_hand() -> None:
    first = straight(0.0, 1.0, (0, 1, 4), (0, 1, 0))
    second = straight(0.5, 2.0, (3, 0.2, 0), (0, 0.2, 0))
    both = merge_attacks([first, second])
    validate_attack(both)
    np.testing.assert_allclose(both.times, [0, 0.5, 1, 2])
    times = np.array([-1.0, 0.25, 0.5, 0.75, 1.0, 1.0001, 2.0, 3.0])
    got = both.at(times)
    np.testing.assert_allclose(
        got[:, 0],
        [(0, 1, 4), (0, 1, 3), (0, 1, 2), (0, 1, 1), *((0, 1, 0),) * 4],
    )
    np.testing.assert_allclose(
        got[:, 1],
        [
            *((3, 0.2, 0),) * 3,
            (2.5, 0.2, 0),
            (2, 0.2, 0),
            (1.9998, 0.2, 0),
            *((0, 0.2, 0),) * 2,
        ],
    )
    np.testing.assert_array_equal(both.active(times)[1:6, 0], [1, 1, 1, 1, 0])
    np.testing.assert_array_equal(both.active(times)[1:6, 1], [0, 1, 1, 1, 1])
    assert both.largest_speed == 4.0
    # Where a sphere is not there it is not close either.
    crop = crop_attack(both, radius=1.0, height=2.3)
    assert crop is not None
    np.testing.assert_allclose((crop.start, crop.end), (0.75, 2.0), atol=2e-3)
    again = merge_attacks([both, straight(3.0, 4.0, (0, 1, 1), (0, 1, 0))])
    np.testing.assert_allclose(again.at(times)[:6, :2], got[:6])
    np.testing.assert_array_equal(again.stops, [1.0, 2.0, 4.0])
    alike = merge_attacks([first, first])
    assert alike.starts is None
    np.testing.assert_allclose(alike.centres[:, 0], alike.centres[:, 1])
    assert merge_attacks([first]) is first
    with pytest.raises(AttackError, match="no attacks"):
        merge_attacks([])


def test_lives_are_validated() -> None:
    good = straight(0.0, 1.0, (0, 1, 4), (0, 1, 0))
    for starts, stops in (([0.5], [1.0]), ([1.0], [0.0]), ([0.0], [np.nan]), ([0.0, 0.0], [1.0])):
        attack = object.__new__(Attack)
        for name in ("times", "centres", "radii", "acceleration"):
            object.__setattr__(attack, name, getattr(good, name))
        object.__setattr__(attack, "starts", np.array(starts))
        object.__setattr__(attack, "stops", np.array(stops))
        with pytest.raises(AttackError, match="expected"):
            validate_attack(attack)


def test_merging_does_not_bend_more() -> None:
    # Minutes apart in knots: what the falling ball bends must not be taken off for the gap.
    early = throw(np.random.default_rng(1), arrives=1.0, gravity=True)
    late = straight(9.0, 19.0, (0, 1, 9), (0, 1, 4))
    both = merge_attacks([early, late])
    dt = np.diff(both.times).max()
    assert dt <= np.diff(early.times).max() * 1.001
    assert len(both.times) < 6000


@pytest.mark.parametrize("seed", range(12))
def test_merged_clearance_is_the_least(made_graph: MotionGraph, attacker, seed: int) -> None:
    rng = np.random.default_rng(seed)
    spheres = preset_spheres(made_graph.skeleton)
    motion = walk_motion(made_graph, some_walk(made_graph, seed, 8), 3.0)
    trace = trace_motion(made_graph, spheres, motion)
    attacks = [throw(rng, arrives=rng.uniform(0.4, 2.0), gravity=i % 2 == 0) for i in range(3)]
    attacks.append(
        limb_attack(
            *attacker,
            limb=list(LIMB_NAMES)[seed % 4],
            hit_s=rng.uniform(1, 5),
            arrives=rng.uniform(0.3, 2.0),
            target=rng.uniform(-0.6, 0.6, 2),
            side=rng.uniform(-3, 3),
        )
    )
    alone = [clearance(attack, trace, spheres.radii) for attack in attacks]
    merged = merge_attacks(attacks)
    steps, least = clearance(merged, trace, spheres.radii)
    # What the one that bends most may be off its knots is taken off for all.
    sag = merged.acceleration * np.diff(merged.times).max() ** 2 / 8
    assert sag < 5e-4
    nearest = min(x[1] for x in alone)
    assert nearest - sag - 1e-5 <= least <= nearest + 1e-5
    wanted = np.min([x[0] for x in alone], axis=0)
    # Never farther than the nearest of them; nearer only in the step in which one comes or goes.
    assert (steps <= wanted + 1e-5)[wanted < FAR].all()
    edges = np.array([t for attack in attacks for t in (attack.start, attack.end)])
    # A step that begins at a knot counts for the moment before it, too.
    near = np.abs(trace.times[:-1, None] - edges).min(axis=1) <= 1.01 / 240
    other = ~near & (wanted < 100)
    assert other.any()
    np.testing.assert_allclose(steps[other], wanted[other], atol=sag + 1e-5)
    assert (steps[wanted == FAR] > 100).mean() > 0.9


@pytest.mark.parametrize("kind", ["limb", "merged", "drag", "file"])
def test_select_takes_them_all(
    made_graph: MotionGraph, attacker, tmp_path: Path, kind: str
) -> None:
    rng = np.random.default_rng(3)
    start, at = np.array([0.5, 1.4, 4.0]), np.array([0.0, 1.3, 0.0])
    drag = ball_attack(start, at, speed=10.0, arrives=1.2, gravity=True, drag=0.3)
    file = tmp_path / "attack.json"
    file.write_text(
        json.dumps(
            {"radii": [0.1], "times": [0.5, 1.5], "centres": [[[0, 1.3, 4]], [[0, 1.3, -2]]]}
        )
    )
    made: dict[str, Callable[[], Attack]] = {
        "limb": lambda: limb_attack(
            *attacker, limb="right_hand", hit_s=3.3, arrives=1.2, target=(0.0, 0.5), side=0.3
        ),
        "merged": lambda: merge_attacks([throw(rng, arrives=1.0), throw(rng, arrives=1.3), drag]),
        "drag": lambda: drag,
        "file": lambda: load_attack(file),
    }
    attack = made[kind]()
    found = select(made_graph, 0, attack, config=AvoidanceConfig(checks=8))
    assert found.status in ("avoided", "hit", "no_candidate")
    if found.status == "avoided":
        radii = preset_spheres(made_graph.skeleton).radii
        assert clearance(attack, found.trace, radii)[1] > 0


def written(folder: Path, document: object) -> Path:
    file = folder / "attack.json"
    file.write_text(document if isinstance(document, str) else json.dumps(document, indent=1))
    return file


def test_file_of_spheres(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    centres = rng.normal(size=(4, 2, 3))
    document = {
        "radii": [0.1, 0.25],
        "times": [0, 0.5, 1.25, 3],
        "centres": centres.tolist(),
        "frame": "character",
    }
    attack = load_attack(written(tmp_path, document))
    np.testing.assert_array_equal(attack.centres, centres)
    np.testing.assert_array_equal(attack.radii, [0.1, 0.25])
    np.testing.assert_array_equal(attack.times, [0, 0.5, 1.25, 3])
    back = {n: getattr(attack, n).tolist() for n in ("radii", "times", "centres")}
    again = load_attack(written(tmp_path, back))
    np.testing.assert_array_equal(again.centres, attack.centres)


def test_file_of_balls(tmp_path: Path) -> None:
    first = {"from": [3, 1.5, 4], "at": [0, 1.2, 0], "speed": 10, "arrives": 1.2}
    second = first | {"gravity": True, "drag": 0.2, "radius": 0.2, "arrives": 1.5}
    got = load_attack(written(tmp_path, {"balls": [first, second]}))
    a, b = np.array(first["from"], float), np.array(first["at"], float)
    balls = [
        ball_attack(a, b, speed=10.0, arrives=1.2),
        ball_attack(a, b, speed=10.0, arrives=1.5, gravity=True, drag=0.2, radius=0.2),
    ]
    wanted = merge_attacks(balls)
    np.testing.assert_array_equal(got.times, wanted.times)
    np.testing.assert_array_equal(got.centres, wanted.centres)
    np.testing.assert_array_equal(got.radii, [0.12, 0.2])
    one = load_attack(written(tmp_path, {"balls": [first]}))
    np.testing.assert_array_equal(one.centres, balls[0].centres)


BALL = '{"from": [3, 1, 4], "at": [0, 1, 0], "speed": 10, "arrives": 1}'
LIST = '{"radii": [0.1],\n "times": [0, 1],\n "centres": [[[0, 1, 4]],\n  [[0, 1, 0]]]}'


def balls(*lines: str) -> str:
    return '{"balls": [' + ",".join(f"\n{line}" for line in lines) + "]}"


BAD: list[tuple[str, int | None, str]] = [
    ("", None, "an empty file"),
    ("[", 1, "no JSON"),
    ("\n{", 2, "no JSON"),
    ("[" * 100_000, None, "nested too deep"),
    ("[]", 1, "got an empty list, expected an object"),
    ("{}", 1, "no 'radii', expected balls, or radii, times and centres"),
    ('{"ball": []}', 1, "unknown key 'ball', expected one such as 'balls'"),
    (LIST.replace('"radii"', '"radius"'), 1, "'radius', expected one such as 'radii'"),
    (LIST.replace('"times"', '"radii"'), None, "twice"),
    (LIST[:-1] + ',\n "balls": []}', 1, "it beside balls"),
    (LIST[:-1] + ',\n "frame": "world"}', 5, "'world', expected 'character'"),
    (LIST[:-1] + ',\n "fram": "character"}', 5, "one such as 'frame'"),
    (LIST.replace("0.1", "-0.1"), 1, "radii[0]: got"),
    (LIST.replace("0.1", '"a\\nb"'), 1, "expected a finite number"),
    (LIST.replace("[0.1]", "[]"), 1, "an empty list"),
    (LIST.replace("[0, 1],\n", "[0, 0],\n"), 2, "ascending"),
    (LIST.replace("[0, 1],\n", "[0, 99],\n"), 2, "at most 60 s"),
    (LIST.replace("[0, 1],\n", "[0],\n"), 3, "a list of 2, expected a list of 1"),
    (
        LIST.replace("[[0, 1, 0]]", "[[0, 1]]"),
        4,
        "centres[1][0]: a list of 2, expected a list of 3",
    ),
    (LIST.replace("[[0, 1, 0]]", "[[0, true, 0]]"), 4, "centres[1][0][1]: true"),
    (LIST.replace("[[0, 1, 0]]", "[[0, 1e999, 0]]"), 4, "centres[1][0][1]: inf"),
    (LIST.replace("[[0, 1, 0]]", "[[0, NaN, 0]]"), None, "NaN"),
    (LIST.replace("[[0, 1, 0]]", "[]"), 4, "centres[1]: an empty list"),
    ('{"balls": []}', 1, "an empty list, expected a list of balls"),
    ('{"balls": [\n 3]}', 2, "balls[0]: 3, expected an object with from"),
    ('{"balls": [\n{"from": [0, 1, 2]}]}', 2, "no 'at'"),
    (
        balls(BALL.replace("speed", "sped")),
        2,
        "'sped', expected one such as 'speed'",
    ),
    (balls(BALL, BALL.replace("10", "-1")), 3, "balls[1]: speed -1"),
    (balls(BALL.replace("10", "1e999")), 2, "balls[0].speed: inf"),
    (balls(BALL.replace("[3, 1, 4]", "[3, 1]")), 2, "balls[0].from"),
    (balls(BALL.replace("}", ', "gravity": 1}')), 2, "true or false"),
    (balls(BALL.replace("}", ', "drag": -1}')), 2, "drag -1 per second"),
]


@pytest.mark.parametrize(("text", "line", "message"), BAD, ids=range(len(BAD)))
def test_bad_files(tmp_path: Path, text: str, line: int | None, message: str) -> None:
    file = written(tmp_path, text)
    with pytest.raises(FileFormatError) as caught:
        load_attack(file)
    said = str(caught.value)
    assert message.replace("radii[0]: got", "radii[0]: -0.1") in said
    assert caught.value.line == line
    assert "\n" not in said
    assert said.startswith(str(file))
    assert "expected" in said


def test_files_that_are_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="attack file"):
        load_attack(tmp_path / "none.json")
    with pytest.raises(FileFormatError):
        load_attack(tmp_path)


@hypothesis.given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.text(max_size=4) | st.integers(),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(["balls", "radii", "times", "centres", "from", "at", "speed", "x"]),
                inner,
                max_size=4,
            )
        ),
        max_leaves=12,
    )
)
def test_any_document_is_read_or_refused(tmp_path_factory, document: object) -> None:
    file = written(tmp_path_factory.mktemp("any"), document)
    try:
        validate_attack(load_attack(file))
    except MgjaxError as error:
        said = str(error)
    else:
        said = ""
    assert "\n" not in said
