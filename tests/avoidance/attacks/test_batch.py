from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import (
    AttackBatch,
    AttackColumn,
    active_at,
    centres_at,
    centres_at_frames,
    evaluation_times,
    frame_times,
    make_attack_batch,
)
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.attacks.merge import merge_attacks
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.rates import EXPORT_RATE
from tests.avoidance.made import throw

CROP = Crop(start=0.9, end=1.3)


def batch_of(attack: Attack) -> AttackBatch:
    return jax.tree.map(np.asarray, make_attack_batch(attack, CROP, AvoidanceConfig(), 1.0))


def thrown(kind: str) -> Attack:
    rng = np.random.default_rng(4)
    if kind == "several":
        return merge_attacks([throw(rng, arrives=1.0), throw(rng, arrives=1.3, gravity=True)])
    if kind == "late":
        return throw(rng, arrives=4.0)
    if kind == "long ago":
        ball = throw(rng, arrives=1.0)
        return replace(ball, times=ball.times - 0.9)
    return throw(rng, arrives=1.1, gravity=kind == "falling")


@pytest.mark.parametrize("kind", ["straight", "falling", "several", "late", "long ago"])
def test_frames_are_those_of_the_attack(kind: str) -> None:
    attack = thrown(kind)
    attack_batch = batch_of(attack)
    count = int(attack_batch.number(AttackColumn.FRAME_COUNT)[0])
    index = np.arange(count, dtype=np.int32)[:, None]
    times = np.asarray(frame_times(attack_batch, index))[:, 0].astype(np.float64)
    begin = max(attack.start, 0.0)
    assert times[0] == pytest.approx(begin, abs=1e-6)
    assert times[-1] == pytest.approx(attack.end, abs=1e-6)
    inner = times[1:-1] * EXPORT_RATE
    np.testing.assert_allclose(inner, np.round(inner), atol=1e-3)
    spheres = len(attack.radii)
    there = attack.active(times)
    for got in (
        centres_at_frames(attack_batch, index),
        centres_at(attack_batch, times[:, None].astype(np.float32)),
    ):
        got = np.asarray(got)[:, 0].reshape(count, -1, 3)[:, :spheres]
        np.testing.assert_allclose(got[there], attack.at(times)[there], atol=2e-5)
    got = np.asarray(active_at(attack_batch, times[:, None].astype(np.float32)))[:, 0]
    assert not got[:, spheres:].any()
    # At its first and last moment rounding decides.
    wanted = attack.active(times)
    unlike = np.flatnonzero((got[:, :spheres] != wanted).any(axis=1))
    lives = [x for x in (attack.starts, attack.stops) if x is not None]
    ends = np.concatenate([*lives, [attack.start, attack.end]])
    assert all(np.abs(times[i] - ends).min() < 1e-4 for i in unlike)


def test_between_frames_centres_move_straight() -> None:
    attack = thrown("falling")
    attack_batch = batch_of(attack)
    times = np.random.default_rng(0).uniform(attack.start, attack.end, 200)
    got = np.asarray(centres_at(attack_batch, times[:, None].astype(np.float32)))[:, 0]
    off = np.linalg.norm(got - attack.at(times)[:, 0], axis=-1)
    assert off.max() <= float(attack_batch.number(AttackColumn.SAG)[0]) + 2e-5


def test_evaluated_times_span_the_crop() -> None:
    attack_batch = batch_of(thrown("straight"))
    count = int(attack_batch.number(AttackColumn.EVALUATED)[0])
    wanted = np.linspace(CROP.start, CROP.end, count)
    got = np.asarray(evaluation_times(attack_batch, np.arange(count + 3, dtype=np.int32)))[:, 0]
    np.testing.assert_allclose(got, [*wanted, CROP.end, CROP.end, CROP.end], atol=1e-6)


def test_several_attacks_are_read_each_for_itself() -> None:
    batches = [batch_of(thrown(kind)) for kind in ("straight", "falling", "long ago")]
    both = jax.tree.map(lambda *x: np.concatenate(x), *batches)
    times = np.random.default_rng(1).uniform(0.0, 1.5, (40, 3)).astype(np.float32)
    got = np.asarray(centres_at(both, times))
    for k, attack_batch in enumerate(batches):
        alone = np.asarray(centres_at(attack_batch, times[:, k : k + 1]))[:, 0]
        np.testing.assert_allclose(got[:, k], alone, atol=1e-6)
    again = both.of(np.array([2, 0], np.int32))
    np.testing.assert_array_equal(again.frames[1], batches[0].frames[0])
    np.testing.assert_array_equal(again.numbers[0], batches[2].numbers[0])


def test_corners_outside_a_life_cost_nothing() -> None:
    # The centre stands still before its life and moves in it: a corner at its first moment.
    times = np.array([0.0, 0.5, 1.0])
    centres = np.array([[0.0, 1, 0], [0.0, 1, 0], [5.0, 1, 0]])[:, None]
    attack = Attack(times=times, centres=centres, radii=np.array([0.1]))
    assert batch_of(attack).number(AttackColumn.SAG)[0] > 0.01
    born = replace(attack, starts=np.array([0.5]), stops=np.array([1.0]))
    assert batch_of(born).number(AttackColumn.SAG)[0] == 0


def test_a_life_that_begins_between_two_frames() -> None:
    # Where it is between its first moment and the next frame, however far its knots before are.
    times = np.array([0.0, 1.0037, 1.3051, 2.0])
    centres = np.array([[0.0, 900, 0], [0.0, 1.2, 1.0], [0.6, 1.2, 1.0], [0.0, -900, 0]])[:, None]
    attack = Attack(times=times, centres=centres, radii=np.array([0.1]))
    attack = replace(attack, starts=np.array([1.0037]), stops=np.array([1.3051]))
    attack_batch = batch_of(attack)
    moments = np.linspace(1.0038, 1.305, 300)
    got = np.asarray(centres_at(attack_batch, moments[:, None].astype(np.float32)))[:, 0]
    np.testing.assert_allclose(got, attack.at(moments)[:, 0], atol=2e-5)
    assert np.asarray(active_at(attack_batch, moments[:, None].astype(np.float32))).all()


def test_the_larger_size_holds_the_same() -> None:
    short = batch_of(thrown("falling"))
    longer = short.as_long()
    assert (short.is_long, longer.is_long) == (False, True)
    assert longer.as_long() is longer
    assert longer.numbers is short.numbers
    count = short.frames.shape[1]
    np.testing.assert_array_equal(longer.frames[:, :count], short.frames)
    last = np.asarray(short.frames)[:, -1:]
    np.testing.assert_array_equal(longer.frames[:, count:], np.repeat(last, 31 * count, axis=1))
    ball = thrown("straight")
    assert batch_of(replace(ball, times=np.linspace(0.0, 5.0, len(ball.times)))).is_long
