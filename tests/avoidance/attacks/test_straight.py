"""Many straight balls at once are what each of them is alone, to the last bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.batch import FRAME_BUCKET, make_attack_batch
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.attacks.straight import batch_rows, begins_far, crops_of, straight_balls
from mgjax.avoidance.config import AvoidanceConfig

SIZE = {"radius": 1.0, "height": 2.3}


def bent(rng: np.random.Generator) -> Attack:
    """A ball with corners on its way, past the body, over it or far from it; or one that rests."""
    count = int(rng.integers(2, 9))
    times = rng.uniform(-0.3, 0.5) + np.cumsum(rng.uniform(0.004, 0.4, count))
    spread = rng.choice([0.3, 1.5, 4.0])
    centres = rng.normal(scale=spread, size=(count, 1, 3))
    centres[..., 1] += 1.2
    if rng.random() < 0.1:
        centres[:] = centres[:1]
    if rng.random() < 0.2:
        centres[..., 1] = rng.choice([1.0, 2.3, 2.8])
    return Attack(times=times, centres=centres, radii=rng.uniform(0.05, 0.3, 1))


def thrown(rng: np.random.Generator) -> Attack:
    """A ball that was thrown at the body or beside it."""
    at = (rng.uniform(-1.3, 1.3), rng.uniform(-1.3, 1.3))
    return ball_from(
        rng.uniform(0, 6.28), rng.uniform(0.2, 2.6), at=at, arrives=rng.uniform(0.5, 2.6)
    )


@pytest.mark.parametrize("kind", [bent, thrown])
def test_each_is_what_it_is_alone(kind) -> None:
    rng = np.random.default_rng(4)
    attacks = [kind(rng) for _ in range(300)]
    config = AvoidanceConfig()
    seen, near = 0, 0
    for balls in straight_balls(attacks):
        assert balls.sound.all()
        start, stop = crops_of(balls, **SIZE)
        close = np.isfinite(start)
        frames, numbers, fits = batch_rows(
            balls.some(np.flatnonzero(close)), (start[close], stop[close]), config, 1.1
        )
        row = iter(range(len(fits)))
        for i, attack in enumerate(balls.attacks):
            assert attack is attacks[balls.number[i]]
            crop = crop_attack(attack, **SIZE)
            assert (crop is not None) == close[i]
            seen += 1
            if crop is None:
                continue
            near += 1
            assert crop == Crop(start=start[i], end=stop[i])
            wanted, k = make_attack_batch(attack, crop, config, 1.1), next(row)
            assert fits[k] == (wanted.frames.shape[1] == FRAME_BUCKET)
            np.testing.assert_array_equal(numbers[k], wanted.numbers[0])
            if fits[k]:
                np.testing.assert_array_equal(frames[k], wanted.frames[0])
    assert seen == 300
    assert near > 100


def test_others_are_left_to_those_who_look_at_one() -> None:
    rng = np.random.default_rng(1)
    ball = ball_from(0.3, 1.1)
    two = Attack(times=ball.times, centres=np.repeat(ball.centres, 2, axis=1), radii=np.ones(2))
    comes = replace(ball, starts=ball.times[:1], stops=ball.times[1:2])
    curve = ball_from(0.3, 1.1, gravity=True)
    many = [two, comes, curve, ball, bent(rng)]
    assert sorted(np.concatenate([b.number for b in straight_balls(many)])) == [3, 4]


def test_what_is_wrong_is_not_sound() -> None:
    ball = ball_from(0.3, 1.1)
    wrong = [
        replace(ball, centres=ball.centres * np.nan),
        replace(ball, times=ball.times[::-1].copy()),
        replace(ball, radii=-ball.radii),
        replace(ball, acceleration=np.inf),
        replace(ball, times=ball.times + 100.0),
    ]
    (balls,) = straight_balls([ball, *wrong])
    assert balls.sound.tolist() == [True] + 5 * [False]
    assert begins_far(balls, 1.5)[0]
    assert not begins_far(balls, 50.0)[0]
