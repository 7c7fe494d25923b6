"""Attacks that nothing avoids, met by an arm: by the written file, and only that arm."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.attacks.merge import merge_attacks
from mgjax.avoidance.attacks.transform import in_frame
from mgjax.avoidance.body.edge_tables import edge_tables
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.selection import Selection, select
from mgjax.avoidance.parry.checked import keeps_limits, met, track_of
from mgjax.avoidance.parry.guard import find_arms, guard_of
from mgjax.avoidance.parry.parry import Parry, find_parry
from mgjax.avoidance.play.planner import Planner
from mgjax.avoidance.rates import CLEAR_M, EXPORT_RATE
from mgjax.cli import main
from mgjax.core import planar
from mgjax.core.body.capsules import make_capsules
from mgjax.core.errors import ConfigError
from mgjax.core.kinematics import forward
from mgjax.core.motion import sample
from mgjax.graph.files import save_graph
from mgjax.graph.types import MotionGraph
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import load_motion
from tests.avoidance.parry.made import CONFIG, ball_at_chest, joints_of, one_armed, standing
from tests.reference import parry as reference

AHEAD = np.array([0.0, 0.0, 5.0])


@pytest.fixture(scope="module")
def attack(guarding: MotionGraph) -> Attack:
    return ball_at_chest(guarding, side=0.1)


@pytest.fixture(scope="module")
def hit(guarding: MotionGraph, attack: Attack) -> Selection:
    return select(guarding, 0, attack, config=replace(CONFIG, parry="off"))


@pytest.fixture(scope="module")
def parried(guarding: MotionGraph, attack: Attack) -> Selection:
    return select(guarding, 0, attack, config=CONFIG)


def test_off_is_as_it_was_and_on_only_where_nothing_avoids(
    guarding: MotionGraph, hit: Selection
) -> None:
    assert hit.status == Status.HIT
    assert hit.parry is None
    wide = ball_at_chest(guarding, side=1.0)  # passes beside the body
    off, on = (select(guarding, 0, wide, config=replace(CONFIG, parry=p)) for p in ("off", "on"))
    assert off.status == on.status == Status.AVOIDED
    assert on.parry is None
    np.testing.assert_array_equal(off.motion.local_rotations, on.motion.local_rotations)


def test_only_one_arm_moves_and_only_in_its_window(
    guarding: MotionGraph, hit: Selection, parried: Selection
) -> None:
    parry = parried.parry
    assert parried.status == Status.PARRIED == "parried"
    assert parry is not None
    count = hit.motion.num_frames
    old, new = (np.asarray(x.motion.local_rotations)[:count] for x in (hit, parried))
    np.testing.assert_array_equal(
        hit.motion.root_translation, parried.motion.root_translation[:count]
    )
    names = guarding.skeleton.names
    names = [name for j, name in enumerate(names) if (old[:, j] != new[:, j]).any()]
    arm = {"left": ["lhumerus", "lradius"], "right": ["rhumerus", "rradius"]}[parry.side]
    assert names == arm
    times = np.arange(count) / EXPORT_RATE
    still = (times <= parry.start) | (times >= parry.stop)
    np.testing.assert_array_equal(old[still], new[still])
    assert parry.start < parry.time < parry.stop <= (parried.motion.num_frames - 1) / EXPORT_RATE
    np.testing.assert_allclose(parry.values[[0, -1]], 0.0, atol=1e-9)
    assert parry.largest_m == max(parry.moved_m) > 0.1
    assert set(arm) <= set(parry.joints)


def test_the_first_that_is_touched_is_that_limb_in_the_written_file(
    guarding: MotionGraph, attack: Attack, parried: Selection, tmp_path: Path
) -> None:
    parry = parried.parry
    assert parry is not None
    save_bvh(tmp_path / "motion.bvh", guarding.skeleton, parried.motion)
    skeleton, motion = load_motion(tmp_path / "motion.bvh")
    # Each moment of the check, and eight more between two of them.
    frames = np.arange(2 * 9 * (motion.num_frames - 1) + 1) / 18
    moments = np.arange(2 * (motion.num_frames - 1) + 1)
    fine = sample(motion, moments / 2)
    places, _ = forward(skeleton, fine.root_translation, fine.local_rotations)
    places = np.asarray(places, np.float64)
    times = frames / EXPORT_RATE
    dense = np.stack(
        [
            np.interp(frames * 2, moments, places[:, j, x])
            for j in range(skeleton.num_joints)
            for x in range(3)
        ],
        axis=1,
    ).reshape(len(frames), -1, 3)
    capsules = make_capsules(skeleton)
    there = (times >= max(attack.start, 0)) & (times <= attack.end)
    found = reference.touched_first(
        times[there],
        dense[there],
        capsules.joints,
        capsules.radii,
        attack.at(times[there])[:, 0],
        float(attack.radii[0]),
    )
    assert found is not None
    moment, capsule = found
    assert f"{capsules.arms[capsule]}_{capsules.parts[capsule]}" == parry.limb
    assert times[there][moment] == pytest.approx(parry.time, abs=1e-3)
    # No sphere of the body but those of that forearm and hand is touched until then.
    trace, radii = parried.trace, guard_of(guarding).spheres.radii
    (arm,) = [arm for arm in guard_of(guarding).arms if arm.side == parry.side]
    rest = guard_of(guarding).rest(arm)
    before = (trace.times <= parry.time) & (trace.times >= attack.start)
    gaps = np.linalg.norm(attack.at(trace.times[before]) - trace.centres[before], axis=-1) - radii
    assert (gaps - attack.radii)[:, rest].min() >= CLEAR_M
    assert parried.clearance_m == parry.clearance_m >= CLEAR_M


def test_what_shows_else_is_not_called_parried(
    guarding: MotionGraph, attack: Attack, parried: Selection, hit: Selection
) -> None:
    parry, guard = parried.parry, guard_of(guarding)
    assert parry is not None
    mine = next(arm for arm in guard.arms if arm.side == parry.side)
    other = next(arm for arm in guard.arms if arm.side != parry.side)
    assert met(guard, mine, *track_of(guard, parried.motion), attack, 0) is not None
    assert met(guard, other, *track_of(guard, parried.motion), attack, 0) is None
    assert met(guard, mine, *track_of(guard, hit.motion), attack, 0) is None
    # A second ball that nothing turns away is a hit.
    (head,) = joints_of(guarding, "head")
    target = head + np.array([0, 0.1, 0])
    second = ball_attack(target + AHEAD, target, speed=10.0, arrives=1.25)
    both = merge_attacks([attack, second])
    assert met(guard, mine, *track_of(guard, parried.motion), both, 0) is None
    assert find_parry(guarding, standing(guarding), both, CONFIG, -0.1) is None
    assert find_parry(guarding, standing(guarding), attack, CONFIG, -0.1) is not None


def test_limits_are_kept_and_ask_for_what_capture_shows(
    guarding: MotionGraph, attack: Attack, hit: Selection, parried: Selection
) -> None:
    parry, guard = parried.parry, guard_of(guarding)
    assert parry is not None
    arm = next(arm for arm in guard.arms if arm.side == parry.side)
    count = hit.motion.num_frames
    after = replace(
        parried.motion,
        root_translation=parried.motion.root_translation[:count],
        local_rotations=parried.motion.local_rotations[:count],
    )
    old, new = track_of(guard, hit.motion)[0], track_of(guard, after)[0]
    assert keeps_limits(guard, arm, hit.motion, after, old, new)
    slow = replace(guard, fastest=0.5)
    assert not keeps_limits(slow, arm, hit.motion, after, old, new)
    stiff = replace(guard, limits=replace(guard.limits, swing=0.1 * guard.limits.swing))
    assert not keeps_limits(stiff, arm, hit.motion, after, old, new)


def test_two_searches_find_the_same(
    guarding: MotionGraph, attack: Attack, hit: Selection, parried: Selection
) -> None:
    again = select(guarding, 0, attack, config=CONFIG)
    np.testing.assert_array_equal(again.motion.local_rotations, parried.motion.local_rotations)
    # Where the motion ends before the arm is back there is no parry.
    short = replace(
        hit.motion,
        root_translation=hit.motion.root_translation[:140],
        local_rotations=hit.motion.local_rotations[:140],
    )
    assert find_parry(guarding, short, attack, CONFIG, -0.1) is None


def test_what_cannot_be_survived_is_a_hit(guarding: MotionGraph) -> None:
    (chest,) = joints_of(guarding, "chest")
    attack = ball_attack(chest + 4 * AHEAD, chest, speed=50.0, arrives=1.5, radius=1.0)
    found = select(guarding, 0, attack, config=CONFIG)
    assert found.status == Status.HIT
    assert found.parry is None
    assert np.isfinite(found.motion.local_rotations).all()
    small = ball_at_chest(guarding, side=0.1)
    none = select(guarding, 0, small, config=replace(CONFIG, parry_radius_m=0.1))
    assert none.status == Status.HIT


def test_a_body_with_one_arm_uses_that_and_one_without_none(guarding: MotionGraph) -> None:
    left = one_armed(guarding)
    assert [arm.side for arm in find_arms(left.skeleton)] == ["left"]
    assert guard_of(left).note == "the body has no right arm to parry with"
    found = find_parry(left, standing(left), ball_at_chest(left, side=0.1), CONFIG, -0.1)
    assert found is not None
    assert found[0].side == "left"
    none = one_armed(guarding, ("left", "right"))
    assert guard_of(none).note == "the body has no left and no right arm to parry with"
    assert find_parry(none, standing(none), ball_at_chest(none), CONFIG, -0.1) is None
    tables = edge_tables(none, 30.0)  # what searching takes does without arms, too
    assert len(tables.spheres.names) == 20
    assert guard_of(guarding).note is None


def test_settings_out_of_range(guarding: MotionGraph) -> None:
    config = replace(CONFIG, parry_radius_m=-0.1)
    with pytest.raises(ConfigError, match="parry_radius_m"):
        select(guarding, 0, ball_at_chest(guarding), config=config)


def test_the_command_writes_it(
    guarding: MotionGraph, parried: Selection, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_graph(tmp_path / "graph", guarding)
    (tmp_path / "parry.toml").write_text('T_wide = 0.0\nrefine = "off"\nparry = "on"\n')
    chest = joints_of(guarding, "chest")[0] + np.array([0.1, 0, 0])
    out = tmp_path / "ball"
    words = ["avoid", "--graph", str(tmp_path / "graph"), "--node", "0", "--out", str(out)]
    words += ["--config", str(tmp_path / "parry.toml"), "--speed", "10", "--arrives", "1.2"]
    words += ["--from", *(str(x) for x in chest + AHEAD), "--at", *(str(x) for x in chest)]
    assert main(words) == 0
    assert "parried with the" in capsys.readouterr().out
    result = json.loads((out / "result.json").read_text())
    parry = parried.parry
    assert parry is not None
    assert result["status"] == "parried"
    assert result["notes"] == []
    assert result["parry"]["limb"] == parry.limb
    assert result["parry"]["time_s"] == pytest.approx(parry.time, abs=1e-3)
    np.testing.assert_allclose(result["parry"]["place_m"], parry.place, atol=1e-2)
    assert result["parry"]["largest_cm"] == pytest.approx(100 * parry.largest_m, abs=1)
    assert set(result["parry"]["joints"]) == set(parry.joints)
    volumes = np.load(out / "volumes.npz")
    gone = volumes["times"] > result["parry"]["time_s"] + 1e-6
    assert (np.abs(volumes["attack_centres"][gone]).max(axis=-1) > 500).all()


def test_the_planner_plays_it(guarding: MotionGraph, attack: Attack) -> None:
    place = np.array([0.7, 1.0, -2.0])
    planner = Planner(guarding, config=CONFIG, node=0, start=place)
    end = planner.timeline.end  # the search is for the end of the edge that is being played
    world = in_frame(attack, np.asarray(planar.inverse(planner.timeline.frame_at_end())), -end)
    planner.attack(world)
    (found,) = planner.finish()
    assert found.search == found.status == "parried"
    assert not found.hit
    assert found.limb is not None
    assert found.clearance_m >= CLEAR_M
    assert planner.counts()["parried"] == 1
    (change,) = planner.timeline.changes
    assert isinstance(change.change, Parry)
    assert change.change.limb == found.limb
    motion = planner.timeline.sample(np.array([change.begins + change.change.time]))
    guard = guard_of(guarding)
    arm = guard.arm(change.change.side)
    places = np.asarray(
        forward(guarding.skeleton, motion.root_translation, motion.local_rotations)[0]
    )[0]
    at = world.at(np.array([change.begins + change.change.time]))[0, 0]
    bone = (arm.elbow, arm.wrist) if found.limb.endswith("forearm") else (arm.wrist, arm.tip)
    near = reference.to_segment(at, *places[list(bone)].astype(np.float64))
    radii = guard.capsules.radii[guard.limb(arm, found.limb.split("_")[1])]
    assert near == pytest.approx(float(world.radii[0] + radii[0]), abs=0.02)
