from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgjax.clips.folder import load_clips
from mgjax.core.errors import ConfigError
from mgjax.graph.build import joint_weights
from mgjax.graph.config import GraphConfig
from mgjax.graph.distances import bounds, components, pruned, tile_pair
from mgjax.graph.distances.axis import Axis, make_axis
from mgjax.graph.distances.distance import normalised_weights
from mgjax.graph.distances.exact import exact_squared
from mgjax.graph.distances.judge import SLACK
from mgjax.graph.distances.minima import Minima, find_minima
from mgjax.graph.timeline import make_timeline
from tests.graph.distances.test_minima import marches, search, steps
from tests.reference import graph as reference

SIDE = 64
"""Of tiles so small that a few hundred frames have several."""


@pytest.fixture(autouse=True)
def small_tiles(monkeypatch) -> None:
    monkeypatch.setattr(pruned, "TILE", SIDE)


def same(one: Minima, other: Minima) -> int:
    """The same pairs at the same distances; how many."""
    pairs = [list(zip(m.rows.tolist(), m.columns.tolist(), strict=True)) for m in (one, other)]
    assert set(pairs[0]) == set(pairs[1])
    assert len(set(pairs[0])) == len(pairs[0]) == len(pairs[1])
    near = [
        dict(zip(p, m.distances, strict=True)) for p, m in zip(pairs, (one, other), strict=True)
    ]
    for pair, distance in near[0].items():
        assert distance == near[1][pair]
    return len(pairs[0])


@pytest.fixture(params=["by one", "by blocks", "either"])
def compared(request, monkeypatch) -> None:
    """Whether open pairs are compared one by one, or all of their blocks."""
    few = {"by one": SIDE**2, "by blocks": 0, "either": 200}[request.param]
    monkeypatch.setattr(tile_pair, "_FEW", few)


def both(clips: list[np.ndarray], **settings) -> int:
    return same(*(search(clips, search=way, **settings) for way in ("all", "pruned")))


@pytest.mark.usefixtures("compared")
@pytest.mark.parametrize("neighbourhood", [1, 3])
@pytest.mark.parametrize("threshold", [0.01, 0.05, 0.15, 3.0])
def test_the_minima_of_all_pairs(threshold, neighbourhood):
    count = both(marches(150, 4, 90, 61), threshold=threshold, neighbourhood=neighbourhood)
    assert count > (3 if threshold > 0.01 else 0)


@pytest.mark.usefixtures("compared")
def test_where_windows_may_not_be_used():
    clips = marches(150, 80)
    rng = np.random.default_rng(3)
    masks = {name: rng.random(230) < 0.8 for name in ("leave", "arrive")}
    masks["leave"][40:120] = True  # blocks with and without a difference
    masks["arrive"][40:120] = True
    assert both(clips, threshold=0.15, **masks) > 20


@pytest.mark.usefixtures("compared")
def test_of_noise():
    rng = np.random.default_rng(1)
    clips = [rng.normal(scale=0.4, size=(n, 3, 3)).astype(np.float32) for n in (70, 130)]
    assert both(clips, threshold=0.6, window=2) > 5


LEVELS = st.lists(st.integers(0, 3), min_size=40, max_size=40)


@pytest.mark.usefixtures("compared")
@given(LEVELS, LEVELS)
def test_ties(a, b):
    """Exact ties everywhere, in both halves of the matrix and across the borders of blocks."""
    found = search([steps(a), steps(b)], window=1, threshold=1.5, search="pruned")
    whole = np.array(a + b, float)
    for i in (0, 40):
        for j in (0, 40):
            matrix = np.abs(np.subtract.outer(whole[i : i + 40], whole[j : j + 40])) ** 2
            here = {
                (r - i, c - j)
                for r, c in zip(found.rows.tolist(), found.columns.tolist(), strict=True)
                if i <= r < i + 40 and j <= c < j + 40
            }
            assert here == set(reference.minima(matrix, 1, 1.5))


@pytest.mark.usefixtures("compared")
def test_motion_that_repeats_and_stands():
    """Copies of a clip, and stillness: whole diagonals and basins are ties."""
    one = marches(90)[0]
    still = np.repeat(one[:1], 50, axis=0)
    assert both([one, still, one + np.float32([3, 0, 1]), one], threshold=0.1) > 5


def axis_of(clips: list[np.ndarray], window: int = 5) -> Axis:
    stops = np.cumsum([len(c) for c in clips])
    return make_axis(
        np.concatenate(clips),
        stops - [len(c) for c in clips],
        stops,
        normalised_weights(None, clips[0].shape[1]),
        window=window,
        margin=1,
        leave=None,
        arrive=None,
    )


def test_single_pairs_against_the_reference():
    clips = marches(30, 20)
    axis = axis_of(clips)
    matrix = reference.distance_matrix(clips[0], clips[1], 5)
    rows, columns = (x.ravel() for x in np.indices(matrix.shape))
    own = exact_squared(axis, rows + 1, columns + 32)
    np.testing.assert_allclose(own, matrix.ravel(), atol=1e-11)
    np.testing.assert_array_equal(own, exact_squared(axis, columns + 32, rows + 1))


def lengths(axis: Axis) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All pairs of windows of an axis, and their D²."""
    valid = np.flatnonzero(axis.valid)
    rows, columns = (x.ravel() for x in np.meshgrid(valid, valid, indexing="ij"))
    return rows, columns, exact_squared(axis, rows, columns)


def test_no_pair_is_closed_that_is_below():
    axis = axis_of(marches(200, 120))
    side = 320 + 64
    parts = components.parts_of(axis.features(0, side), components.principal(axis), axis.window)
    used = np.pad(axis.valid, (0, side - len(axis)))
    projected = bounds.bound_rows(parts, used)
    rows, columns, squared = lengths(axis)
    for limit in (0.02**2, 0.08**2, 0.2**2):
        limits = jnp.full((2, side), limit, jnp.float32)
        begin = jnp.int32(0)
        bits = bounds.open_pairs(jnp.asarray(projected), begin, begin, limits, tile=side)
        left = np.zeros((side, side), bool)
        left[bounds.open_places(np.asarray(bits))] = True
        assert left[rows, columns][squared < limit].all()
        assert left.sum() < 0.9 * side**2  # not all are left open


@pytest.mark.parametrize("count", [1, 4, 48])
def test_components_tell_how_wrong_they_are(count):
    axis = axis_of(marches(120, 60))
    flat, rise, mean = components.principal(axis)
    few = flat[..., :count], rise[:, :count], mean
    parts = components.parts_of(axis.features(0, len(axis)), few, axis.window)
    rows, columns, squared = lengths(axis)
    own, error = components.nearly(parts, rows, parts, columns)
    slack = SLACK * parts.spread[axis.valid].max()
    assert (np.abs(own - squared) <= error + slack).all()
    largest = {1: 1.0, 4: 0.1, 48: 1e-4}[count]
    assert 0 < error.max() < largest


def test_open_pairs_by_hand():
    """Bit k of a number is row k of eight."""
    left = np.zeros((128, 128), bool)
    left[[0, 3, 70, 9], [5, 2, 127, 9]] = True
    bits = np.zeros((16, 128), np.uint8)
    for row, column in np.argwhere(left):
        bits[row // 8, column] |= 1 << row % 8
    rows, columns = bounds.open_places(bits)
    assert {*zip(rows.tolist(), columns.tolist(), strict=True)} == {
        (0, 5),
        (3, 2),
        (70, 127),
        (9, 9),
    }
    assert bounds.open_counts(bits, 64).tolist() == [[3, 0], [0, 1]]
    found = np.stack(bounds.open_places(bounds.upper_half(bits)), axis=1).tolist()
    assert sorted(found) == [[0, 5], [9, 9], [70, 127]]


def test_components_by_hand():
    """Two windows of one frame: 3 and 4 m² in two directions, a quarter turn apart."""
    parts = components.Parts(
        flat=np.array([[3.0, 4j], [3j, -4.0]], np.complex64),
        rise=np.array([[1.0], [2.0]], np.float32),
        rest=np.array([[0.1, 0.2], [0.3, 0.4]], np.float32),
        spread=np.array([26.0, 29.0], np.float32),
    )
    squared, error = components.nearly(parts, np.array([0]), parts, np.array([1]))
    np.testing.assert_allclose(squared, 26 + 29 - 2 * 25 - 2 * 2, rtol=1e-6)
    np.testing.assert_allclose(error, 2 * (0.03 + 0.08), rtol=1e-6)


@pytest.mark.usefixtures("compared")
def test_few_joints_and_frames_have_fewer_components():
    clips = [
        np.cumsum(np.full((80, 1, 3), 0.01, np.float32), axis=0),
        np.zeros((50, 1, 3), np.float32),
    ]
    assert both(clips, window=1, threshold=0.5) >= 1


def test_all_minima_need_all_pairs():
    with pytest.raises(ConfigError, match="infinite"):
        search(marches(20), search="pruned")


@pytest.mark.usefixtures("compared")
def test_real_capture(capture):
    clips, _ = load_clips(capture / "avoidance", exclude=["bvh_converted/*", "cmu49/*"])
    clips = clips[:4]
    timeline, _ = make_timeline(clips, {}, clips[0].skeleton, GraphConfig())
    window = slice(0, 900)
    stops = np.minimum(timeline.stops, 900)
    used = timeline.starts < 900
    weights = joint_weights(timeline.skeleton, "uniform")
    for threshold in (0.05, 0.13, 0.2):
        found = [
            find_minima(
                timeline.positions[window],
                timeline.starts[used],
                stops[used],
                weights,
                window=10,
                neighbourhood=1,
                threshold=threshold,
                search=way,
            )
            for way in ("all", "pruned")
        ]
        assert same(*found) > 0


@pytest.mark.parametrize("square", [1, 3, 24])
def test_each_pair_of_tiles_is_searched_once(monkeypatch, square):
    monkeypatch.setattr(pruned, "_SQUARE", square)
    for length in (20, 70, 500):
        axis = axis_of(marches(length))
        pairs = pruned.tile_pairs(axis)
        count = axis.tiles(SIDE)
        assert sorted(pairs) == [(i, j) for i in range(count) for j in range(i, count)]
