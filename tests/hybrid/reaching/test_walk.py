from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from mgjax.core.errors import ReachError
from mgjax.core.kinematics import global_positions
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.hybrid.config import PathConfig, ReachConfig
from mgjax.hybrid.ik.limbs import find_limb
from mgjax.hybrid.paths.search import follow
from mgjax.hybrid.paths.sketch import make_sketch
from mgjax.hybrid.reaching.result import ReachResult
from mgjax.hybrid.reaching.targets import make_target
from mgjax.hybrid.reaching.walk import reach
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import load_motion
from tests.hybrid.paths.made import walking as few_transitions

LINE = make_sketch([[0, 0], [0, 4]])
BEAM = PathConfig(method="beam")


def walking():
    """Embedded clips with enough transitions for turning back."""
    return few_transitions(("walk", "walk_curve", "steps", "turns"), 5)


def go(*targets, graph=None, config: ReachConfig | None = None, sketch=LINE) -> ReachResult:
    return reach(graph or walking(), sketch, targets, path=BEAM, config=config)


def check(result: ReachResult, graph=None) -> np.ndarray:
    """What every reach must keep; returns the places of the joints."""
    graph = graph or walking()
    positions = np.asarray(global_positions(graph.skeleton, result.motion), np.float64)
    parents = np.array(graph.skeleton.parents[1:])
    lengths = np.linalg.norm(positions[:, 1:] - positions[:, parents], axis=-1)
    wanted = np.linalg.norm(np.asarray(graph.skeleton.offsets, np.float64)[1:], axis=-1)
    np.testing.assert_allclose(lengths, np.broadcast_to(wanted, lengths.shape), atol=1e-5)
    assert result.fastest_deg_s <= 720
    for row in result.targets:
        if row.status != "reached":
            continue
        assert row.first is not None
        assert row.last is not None
        frames = np.arange(row.first, row.last + 1)
        end = find_limb(graph.skeleton, row.target.limb).joints[-1]
        goal = row.target.at((frames - row.first) / graph.frame_rate)
        off = np.linalg.norm(positions[frames, end] - goal, axis=-1)
        assert off.max() < 0.005
        assert row.hold_m == pytest.approx(off.max(), abs=1e-6)
    return positions


def test_in_passing_the_legs_keep_the_walk(tmp_path: Path) -> None:
    target = make_target("right_hand", place=[-0.35, 1.2, 2.2], when="passing", hold_s=0.2)
    result = go(target)
    (row,) = result.targets
    assert (row.status, row.extended_m, row.stopped) == ("reached", 0.0, False)
    positions = check(result)
    plain = np.asarray(global_positions(walking().skeleton, result.plain))
    names = walking().skeleton.names
    legs = [j for j, n in enumerate(names) if n[1:] in ("femur", "tibia", "foot", "toes")]
    if row.drop_m == 0:
        np.testing.assert_allclose(positions[:, legs], plain[:, legs], atol=1e-6)
    assert row.first is not None
    before = row.first - round(ReachConfig().blend_s * walking().frame_rate)
    np.testing.assert_allclose(positions[:before], plain[:before], atol=1e-6)
    save_bvh(tmp_path / "reach.bvh", walking().skeleton, result.motion)
    skeleton, motion = load_motion(tmp_path / "reach.bvh")
    again = np.asarray(global_positions(skeleton, motion))
    hand = skeleton.index(names[find_limb(walking().skeleton, "right_hand").joints[-1]])
    np.testing.assert_allclose(again[row.first, hand], target.places[0], atol=2e-3)


def test_weights_are_smooth() -> None:
    target = make_target("right_hand", place=[-0.35, 1.3, 2.2], when="passing", hold_s=0.2)
    result = go(target)
    hand = find_limb(walking().skeleton, "right_hand").joints[-1]
    track = np.asarray(global_positions(walking().skeleton, result.motion), np.float64)[:, hand]
    # Less than 12 m/s in one frame: no jump in velocity when the reach sets in or ends.
    speed = np.diff(track, axis=0) * walking().frame_rate
    assert np.linalg.norm(np.diff(speed, axis=0), axis=1).max() < 1.2


@pytest.mark.parametrize("when", ["passing", "end", "start", 1.0])
def test_the_walk_is_extended(when: float | str) -> None:
    target = make_target("right_hand", place=[0.2, 1.3, 5.6], when=when, hold_s=0.2)
    here = go(target, config=ReachConfig(extend=False))
    assert here.targets[0].status == "out_of_reach"
    assert np.isnan(here.targets[0].hold_m)
    result = go(target)
    (row,) = result.targets
    assert row.status == "reached"
    assert row.extended_m > 0.5
    check(result)


def test_before_and_after_the_walk() -> None:
    before = make_target("left_hand", place=[0.3, 1.2, 0.3], when="start", hold_s=0.4)
    after = make_target("right_hand", place=[-0.2, 1.1, 4.4], when="end", hold_s=0.4)
    result = go(before, after)
    first, last = result.targets
    assert first.status == last.status == "reached"
    assert first.stopped
    assert last.stopped
    positions = check(result)
    assert first.last is not None
    root = positions[: first.last, 0]
    assert np.linalg.norm(root - root[0], axis=1).max() < 0.2
    assert result.motion.num_frames > result.walked.frames + 20


def test_both_hands_a_moving_target_and_a_low_one() -> None:
    together = [
        make_target("left_hand", place=[0.25, 1.2, 4.4], when="end", hold_s=0.3),
        make_target("right_hand", track=[[0, -0.25, 1.0, 4.4], [0.3, -0.25, 1.3, 4.4]], when="end"),
    ]
    result = go(*together)
    assert [row.status for row in result.targets] == ["reached", "reached"]
    assert result.targets[0].first == result.targets[1].first
    check(result)
    low = make_target("right_hand", place=[-0.2, 0.25, 4.4], when="end", hold_s=0.2)
    result = go(low)
    (row,) = result.targets
    assert row.status == "reached"
    assert row.drop_m > 0.1
    check(result)


def test_limits_can_be_off_and_some_targets_are_too_high() -> None:
    target = make_target("right_hand", place=[-0.35, 1.2, 2.2], when="passing", hold_s=0.2)
    result = go(target, config=ReachConfig(limits=False))
    assert result.targets[0].status == "reached"
    check(result)
    high = make_target("right_hand", place=[0, 3.0, 2.0], when="passing")
    result = go(high)
    assert result.targets[0].status == "too_high"
    assert result.fastest_deg_s == 0


def test_the_whole_body_ducks_under_a_bar() -> None:
    height = float(np.asarray(global_positions(walking().skeleton, go().plain))[0, :, 1].max())
    free = make_target("head", bar=([-1, height + 0.5, 2], [1, height + 0.5, 2], 0.03))
    (row,) = go(free).targets
    assert (row.status, row.first) == ("cleared", None)
    bar = make_target("head", bar=([-1, height - 0.12, 2], [1, height - 0.12, 2], 0.03))
    result = go(bar)
    (row,) = result.targets
    assert row.status == "cleared"
    assert row.clear_m > 0
    assert row.first is not None
    check(result)
    knees = make_target("head", bar=([-1, 0.5, 2], [1, 0.5, 2], 0.03))
    (row,) = go(knees).targets
    assert row.status == "hit"
    assert row.clear_m < 0


def test_bad_targets() -> None:
    inside = make_target("right_hand", place=[0, 1.1, 0], when="start")
    with pytest.raises(ReachError, match="inside the body"):
        go(inside)
    twice = make_target("right_hand", place=[0, 1.1, 4.5], when="end")
    with pytest.raises(ReachError, match="two targets of the right_hand"):
        go(twice, replace(twice))


@lru_cache(maxsize=1)
def captured(folder: Path):
    from mgjax.clips.folder import load_clips

    clips, _ = load_clips(folder)
    return build_graph(clips, config=GraphConfig(neighbourhood=5))


def test_on_capture(capture: Path) -> None:
    graph = captured(capture / "locomotion" / "cmu16")
    curve = make_sketch([[0, 0], [1.5, 2.5], [0, 5], [-1.5, 7.5], [0, 10]], spline=True)
    high = make_target("right_hand", place=[0.05, 1.75, 5.5], when="passing")
    far = make_target("left_hand", place=[1.5, 0.9, 11.0], when="end")
    bar = make_target("head", bar=([-2.5, 1.5, 7.5], [-0.5, 1.5, 7.5], 0.03))
    result = go(high, far, bar, graph=graph, sketch=curve)
    assert [row.status for row in result.targets] == ["reached", "reached", "cleared"]
    check(result, graph)


def test_a_blend_of_no_length_is_at_once() -> None:
    config = ReachConfig(blend_s=0.0, turn_deg_s=1e6)
    hand = make_target("right_hand", place=[-0.35, 1.2, 2.2], when="passing", hold_s=0.2)
    bar = make_target("head", bar=([-1, 1.5, 3], [1, 1.5, 3], 0.03))
    result = reach(walking(), LINE, (hand, bar), path=BEAM, config=config)
    assert np.isfinite(np.asarray(result.motion.local_rotations)).all()
    row, ducked = result.targets
    assert (row.status, ducked.status) == ("reached", "cleared")
    assert row.first is not None
    assert ducked.first is not None
    held = {f for r in (row, ducked) for f in range(r.first, r.last + 1)}  # pyright: ignore
    before = next(f for f in range(row.first - 1, -1, -1) if f not in held)
    np.testing.assert_allclose(
        result.motion.local_rotations[before], result.plain.local_rotations[before], atol=1e-6
    )


def test_a_known_walk_is_reached_on_without_another_search(monkeypatch: pytest.MonkeyPatch) -> None:
    target = make_target("right_hand", place=[-0.35, 1.2, 2.2], when="passing", hold_s=0.2)
    whole = go(target)
    walked = follow(walking(), LINE, config=BEAM)
    monkeypatch.delattr("mgjax.hybrid.reaching.walk.follow")
    known = reach(walking(), LINE, (target,), path=BEAM, walked=walked)
    np.testing.assert_array_equal(known.motion.local_rotations, whole.motion.local_rotations)


def test_what_is_drawn_away_from_its_target_is_missed() -> None:
    places = ([-0.3, 1.2, 2.2], [-0.3, 1.9, 2.3])
    result = go(*(make_target("right_hand", place=p, when="passing", hold_s=0.3) for p in places))
    for row in result.targets:
        assert (row.status == "reached") == (row.hold_m <= ReachConfig().hold_m)
    # Whether the arm is too fast or late is a matter of rounding: both are told, neither is hidden.
    assert {"missed", "too_fast"} & {row.status for row in result.targets}
