from __future__ import annotations

from functools import partial

import chex
import hypothesis
import hypothesis.strategies as st
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.avoidance.body.edge_tables import speed_classes
from mgjax.avoidance.config import SpeedConfig
from mgjax.avoidance.timing.time_scale import NOT_ADJUSTABLE, OK, OUT_OF_RANGE, Timing, time_scale
from mgjax.core.arrays import Array
from mgjax.core.timing.time_warp import scaled_warp
from tests.reference import avoidance as reference

HALF_FRAME = 1 / 60
LENGTH = 6
STATUS = {OK: "ok", NOT_ADJUSTABLE: "not_adjustable", OUT_OF_RANGE: "out_of_range"}


def problem(seed: int) -> tuple:
    """A padded walk: seconds, slow_down, speed_up, length, part_centre, t_attack."""
    rng = np.random.default_rng(seed)
    length = int(rng.integers(1, LENGTH + 1))
    seconds = rng.uniform(0.1, 0.9, LENGTH)
    centre = rng.uniform(0.2, 1.0) * seconds[length - 1]
    slow, fast = rng.random((2, LENGTH)) < 0.5
    t_avoid = seconds[: length - 1].sum() + centre
    t_attack = t_avoid * rng.uniform(0.2, 2.5)
    if seed % 5 == 0:
        t_attack = t_avoid + rng.uniform(-0.9, 0.9) * HALF_FRAME
    return seconds, slow, fast, length, centre, t_attack


def scaled(seconds, slow, fast, length, centre, t_attack, limit: float = 4.0) -> Timing:
    return time_scale(
        np.asarray(seconds, np.float32),
        np.asarray(slow),
        np.asarray(fast),
        np.int32(length),
        np.float32(centre),
        np.float32(t_attack),
        half_frame=HALF_FRAME,
        limits=(np.float32(limit), np.float32(limit)),
    )


def test_agrees_with_the_definition() -> None:
    seen = set()
    for seed in range(300):
        seconds, slow, fast, length, centre, t_attack = problem(seed)
        got = scaled(seconds, slow, fast, length, centre, t_attack)
        s, scales, status = reference.time_scale(
            seconds[:length], slow[:length], fast[:length], centre, t_attack, HALF_FRAME, 4.0
        )
        assert STATUS[int(got.status)] == status, seed
        seen.add((status, s > 1, s < 1))
        if status == "ok":
            np.testing.assert_allclose(got.s_time, s, rtol=1e-4)
            np.testing.assert_allclose(got.scales[:length], scales, rtol=1e-4)
            if s != 1.0:  # the middle of the part now comes at the time of the attack
                counted = [*seconds[: length - 1], centre]
                np.testing.assert_allclose(
                    np.dot(counted, np.asarray(got.scales[:length])), t_attack, rtol=1e-5
                )
        np.testing.assert_array_equal(got.scales[length:], 1.0)
    assert {s for s, *_ in seen} == set(STATUS.values())
    assert ("ok", True, False) in seen
    assert ("ok", False, True) in seen
    assert ("ok", False, False) in seen


def test_by_hand() -> None:
    # 0.5 s fixed, 0.4 s adjustable, the part in the middle (0.2 s) of an adjustable edge of 0.4 s:
    # t_avoid = 1.1; to come at 1.4 the 0.6 adjustable seconds have to last 0.9.
    slow = [False, True, True]
    got = scaled([0.5, 0.4, 0.4], slow, [False] * 3, 3, 0.2, 1.4)
    np.testing.assert_allclose(got.s_time, 1.5, rtol=1e-6)
    np.testing.assert_allclose(got.scales, [1, 1.5, 1.5], rtol=1e-6)
    # Earlier, at 0.8: those that may be sped up count, here only the first: (0.8 − 0.6)/0.5.
    got = scaled([0.5, 0.4, 0.4], slow, [True, False, False], 3, 0.2, 0.8)
    np.testing.assert_allclose(got.scales, [0.4, 1, 1], rtol=1e-6)
    # What is later than the middle of the part does not count, but is scaled with its edge.
    assert int(scaled([0.5, 0.4, 0.4], [False] * 3, [False] * 3, 3, 0.2, 1.4).status) == (
        NOT_ADJUSTABLE
    )


def test_exact_times_need_no_adjustable_edge() -> None:
    fixed = [False, False]
    got = scaled([0.5, 0.4], fixed, fixed, 2, 0.2, 0.7 + 0.9 * HALF_FRAME)
    assert (int(got.status), float(got.s_time)) == (OK, 1.0)
    np.testing.assert_array_equal(got.scales, 1.0)
    got = scaled([0.5, 0.4], fixed, fixed, 2, 0.2, 0.7 + 1.1 * HALF_FRAME)
    assert int(got.status) == NOT_ADJUSTABLE
    # And where edges could be scaled they are left alone.
    got = scaled([0.5, 0.4], [True] * 2, [True] * 2, 2, 0.2, 0.7 + 0.9 * HALF_FRAME)
    np.testing.assert_array_equal(got.scales, 1.0)


@pytest.mark.parametrize(
    ("t_attack", "status"),
    [(0.79, OK), (0.81, OUT_OF_RANGE), (0.051, OK), (0.049, OUT_OF_RANGE), (0.0, OUT_OF_RANGE)],
)
def test_limits(t_attack: float, status: int) -> None:
    # One edge with its part's middle at 0.2 s: factors 1/4 … 4 put it at 0.05 … 0.8 s.
    assert int(scaled([0.5], [True], [True], 1, 0.2, t_attack).status) == status


def test_no_limit_and_no_time_left() -> None:
    yes = [True, True]
    assert int(scaled([0.1, 0.4], yes, yes, 2, 0.1, 10.0, limit=1e6).status) == OK
    # The fixed edge alone lasts longer than there is time: s_time would be negative.
    got = scaled([0.5, 0.4], yes, [False, True], 2, 0.2, 0.4, limit=1e6)
    assert int(got.status) == OUT_OF_RANGE


def test_batch_is_a_loop() -> None:
    problems = [problem(seed) for seed in range(40)]
    columns = [
        np.stack([np.asarray(p[k], dtype) for p in problems])
        for k, dtype in enumerate((np.float32, bool, bool, np.int32, np.float32, np.float32))
    ]
    one = partial(time_scale, half_frame=HALF_FRAME, limits=(np.float32(4), np.float32(4)))
    batch = jax.jit(jax.vmap(one))(*columns)
    for i in range(len(problems)):
        row = one(*(column[i] for column in columns))
        chex.assert_trees_all_close(jax.tree.map(lambda x, i=i: x[i], batch), row, rtol=1e-6)


@hypothesis.given(st.integers(0, 10_000), st.integers(1, 4))
def test_padding_changes_nothing(seed: int, extra: int) -> None:
    seconds, slow, fast, length, centre, t_attack = problem(seed)
    got = scaled(seconds, slow, fast, length, centre, t_attack)
    wide = scaled(
        np.append(seconds, np.full(extra, 7.0)),
        np.append(slow, [True] * extra),
        np.append(fast, [True] * extra),
        length,
        centre,
        t_attack,
    )
    assert int(got.status) == int(wide.status)
    np.testing.assert_allclose(got.s_time, wide.s_time, rtol=1e-6)
    np.testing.assert_allclose(got.scales, wide.scales[:LENGTH], rtol=1e-6)


def test_speed_classes() -> None:
    top = np.array([0.0, 0.05, 0.1, 0.2, 0.3, 0.31, 5.0])
    printed = speed_classes(top, SpeedConfig(V_fast=0.3, V_slow=0.1, V_still=0.0))
    np.testing.assert_array_equal(printed[0], [False] * 5 + [True] * 2)  # may be slowed down
    np.testing.assert_array_equal(printed[1], [False, True, False, False, False, False, False])
    still = speed_classes(top, SpeedConfig(V_fast=0.3, V_slow=0.1, V_still=0.06))
    np.testing.assert_array_equal(still[0], [True, True, False, False, False, True, True])
    np.testing.assert_array_equal(still[1], [True, True, False, False, False, False, False])


def test_slopes_are_finite_differences() -> None:
    """Of the time scale and of what is shown with it; one by hand; finite where nothing may be
    scaled."""
    slow = fast = jnp.array([True, False, True])

    def scaling(seconds: Array, centre: Array, t_attack: Array) -> Timing:
        return time_scale(
            seconds, slow, fast, jnp.int64(3), centre, t_attack,
            half_frame=HALF_FRAME, limits=(jnp.float64(4.0), jnp.float64(4.0)),
        )  # fmt: skip

    def both(seconds: Array, centre: Array, t_attack: Array) -> Array:
        found = scaling(seconds, centre, t_attack)
        shown = scaled_warp(seconds, found.scales).at(jnp.array([0.3, 1.9]))
        return jnp.stack([found.s_time, *shown])

    with jax.enable_x64(True):
        at = (jnp.array([0.5, 0.4, 0.8]), jnp.float64(0.3), jnp.float64(2.0))
        forward = jax.jacfwd(both, argnums=(0, 1, 2))(*at)
        reverse = jax.jacrev(both, argnums=(0, 1, 2))(*at)
        # s = (2.0 − 0.4) / 0.8, so it grows by 1 / 0.8 with the time of the attack.
        np.testing.assert_allclose(both(*at)[0], 2.0)
        np.testing.assert_allclose(forward[2][0], 1.25)
        for number, (one, other) in enumerate(zip(forward, reverse, strict=True)):
            np.testing.assert_allclose(one, other, atol=1e-12)
            for k in range(at[number].size):
                moved = jnp.zeros(at[number].size).at[k].set(1e-6).reshape(at[number].shape)
                more, less = (
                    both(*at[:number], at[number] + sign * moved, *at[number + 1 :])
                    for sign in (1, -1)
                )
                found = np.asarray(one).reshape(3, -1)[:, k]
                np.testing.assert_allclose(found, (more - less) / 2e-6, atol=1e-6)
        still = jnp.zeros(3, bool)
        scale = partial(
            time_scale, at[0], still, still, jnp.int64(3), at[1],
            half_frame=HALF_FRAME, limits=(jnp.float64(4.0), jnp.float64(4.0)),
        )  # fmt: skip
        assert float(jax.grad(lambda t: scale(t).s_time)(at[2])) == 0.0
