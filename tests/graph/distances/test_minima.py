from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgjax.core.motion import cut
from mgjax.graph.distances import tiles
from mgjax.graph.distances.distance import normalised_weights
from mgjax.graph.distances.minima import Minima, find_minima
from tests.graph.made import march, places
from tests.reference import graph as reference

SLACK = 4e-6
"""m². Values nearer to each other than this may change places by rounding."""


@pytest.fixture(params=[16, 23, 1024])
def tile(request, monkeypatch) -> Iterator[int]:
    """Tiles so small that clips and neighbourhoods cross their borders, and the usual ones."""
    tiles._tile.clear_cache()
    monkeypatch.setattr(tiles, "TILE", request.param)
    yield request.param
    tiles._tile.clear_cache()


def search(
    clips: list[np.ndarray], *, window=5, neighbourhood=1, threshold=np.inf, **settings
) -> Minima:
    stops = np.cumsum([len(c) for c in clips])
    return find_minima(
        np.concatenate(clips).astype(np.float32),
        stops - [len(c) for c in clips],
        stops,
        normalised_weights(None, clips[0].shape[1]),
        window=window,
        neighbourhood=neighbourhood,
        threshold=threshold,
        **settings,
    )


def pairs(clips: list[np.ndarray], window: int) -> Iterator[tuple[int, int, np.ndarray]]:
    """First frames of every ordered pair of clips, and D² of their windows."""
    starts = np.cumsum([0] + [len(c) for c in clips[:-1]])
    for i, a in zip(starts, clips, strict=True):
        for j, b in zip(starts, clips, strict=True):
            if min(len(a), len(b)) >= window:
                yield int(i), int(j), reference.distance_matrix(a, b, window)


def check(clips: list[np.ndarray], *, window: int, neighbourhood: int, threshold: float) -> int:
    """All clear minima are found, all that are found are minima; returns how many were clear."""
    found = search(clips, window=window, neighbourhood=neighbourhood, threshold=threshold)
    where = set(zip(found.rows.tolist(), found.columns.tolist(), strict=True))
    assert len(where) == len(found.rows)
    squares = dict(
        zip(zip(found.rows, found.columns, strict=True), found.distances**2, strict=True)
    )
    clear, seen, largest = 0, 0, 0.0
    for i, j, matrix in pairs(clips, window):
        largest = max(largest, float(np.sqrt(matrix.max())))
        for r, c in np.ndindex(*matrix.shape):
            value, here = matrix[r, c], (r + i, c + j)
            if here in where:
                seen += 1
                assert reference.is_minimum(matrix, r, c, neighbourhood, slack=SLACK)
                assert value < threshold**2 + SLACK
                assert abs(squares[here] - value) <= SLACK
            elif value < threshold**2 - SLACK:
                assert not reference.clear_minimum(matrix, r, c, neighbourhood, SLACK), here
            clear += reference.clear_minimum(matrix, r, c, neighbourhood, SLACK)
    assert seen == len(where)  # all of them lie in a pair of clips
    assert (np.diff(found.distances) >= 0).all()
    if np.isinf(threshold):
        assert found.largest == pytest.approx(largest, abs=1e-4)
    else:
        assert found.largest == 0.0
    return clear


def marches(*lengths: int) -> list[np.ndarray]:
    return [
        places(march(n, seed=i, period=14 + 2 * i, noise=0.03, place=(3.0 * i, 0.0)))
        for i, n in enumerate(lengths)
    ]


@pytest.mark.parametrize("neighbourhood", [1, 3])
@pytest.mark.parametrize("threshold", [np.inf, 0.06])
def test_against_an_exhaustive_scan(tile, neighbourhood, threshold):
    clips = marches(31, 24, 17)
    clear = check(clips, window=5, neighbourhood=neighbourhood, threshold=threshold)
    assert clear > 10


@pytest.mark.parametrize("window", [1, 2, 9])
def test_windows(tile, window):
    rng = np.random.default_rng(window)
    clips = [rng.normal(scale=0.4, size=(n, 3, 3)) for n in (21, 12)]
    assert check(clips, window=window, neighbourhood=1, threshold=np.inf) > 5


def test_clips_shorter_than_the_window_or_exactly_as_long(tile):
    clips = marches(4, 5, 20, 1, 6)
    check(clips, window=5, neighbourhood=1, threshold=np.inf)
    assert len(search(marches(4, 3)).rows) == 0
    one = search(marches(5, 5))
    assert set(zip(one.rows, one.columns, strict=True)) == {(0, 0), (0, 5), (5, 0), (5, 5)}


def test_every_length_of_the_axis(monkeypatch):
    """Also where the last frames and the gap after them lie on both sides of a tile's border."""
    tiles._tile.clear_cache()
    monkeypatch.setattr(tiles, "TILE", 16)
    long = march(60, seed=1, period=9, noise=0.05)
    for frames in range(20, 37):
        clip = places(cut(long, 0, frames))
        check([clip], window=3, neighbourhood=3, threshold=0.1)
    tiles._tile.clear_cache()


def test_neighbourhoods_end_with_the_clip():
    """The same motion cut in two: each border of each pair has its own minima."""
    whole = marches(40)[0]
    parts = [whole[:20], whole[20:]]
    check(parts, window=5, neighbourhood=3, threshold=np.inf)
    # What comes right after the first part on the axis of frames plays no part in it.
    moved = [parts[0], parts[1] + np.array([0, 5, 0], np.float32)]
    inner = [
        {
            (int(r), int(c))
            for r, c, d in zip(found.rows, found.columns, found.distances, strict=True)
            if r < 20 and c < 20 and d > 0.01
        }
        for found in (search(parts), search(moved))
    ]
    assert inner[0] == inner[1]
    assert inner[0]


def steps(levels: list[float]) -> np.ndarray:
    """One joint: D between windows of one frame is the difference of heights.

    Where the mean of all heights is a round number, so are all D², and ties are exact.
    """
    p = np.zeros((len(levels), 1, 3), np.float32)
    p[:, 0, 1] = levels
    return p


def across(found: Minima, rows: int) -> set[tuple[int, int]]:
    """Minima of the first clip, of so many rows, with the second."""
    return {
        (int(r), int(c) - rows)
        for r, c in zip(found.rows, found.columns, strict=True)
        if r < rows <= c
    }


def test_worked_by_hand(tile):
    #        2  0  4  2
    #   0    2 (0) 4  2
    #   3    1  3  1  1      (1, 0) and (1, 2) have (0, 1) as neighbour; (1, 3) ties with (1, 2),
    #   1    1  1  3  1      (2, 0) with (1, 0), which come first; (2, 1) and (2, 3) have (3, 2).
    #   4    2  4 (0) 2
    a, b = [0, 3, 1, 4], [2, 0, 4, 2]
    found = search([steps(a), steps(b)], window=1)
    assert across(found, 4) == {(0, 1), (3, 2)}
    assert found.largest == 4.0
    matrix = np.abs(np.subtract.outer(a, b)) ** 2.0
    assert reference.minima(matrix, 1, np.inf) == [(0, 1), (3, 2)]


@pytest.mark.parametrize("neighbourhood", [1, 3])
def test_a_flat_bottom_has_one_winner_the_first(tile, neighbourhood):
    # A comes down, stands at 1 m in the frames 5 … 29 and goes up; B passes 1 m in frames 4 … 6.
    a = steps([3, 2.5, 2.25, 2, 1.75] + [1.0] * 25 + [1.75, 2.0])
    b = steps([0, 0.25, 0.5, 0.75, 1, 1, 1, 1.25, 1.5])
    found = search([a, b], window=1, neighbourhood=neighbourhood, threshold=0.125)
    assert across(found, len(a)) == {(5, 4)}
    # All of one still clip with itself is one basin.
    still = search([steps([1.0] * 40)], window=4, neighbourhood=neighbourhood)
    assert list(zip(still.rows, still.columns, strict=True)) == [(0, 0)]


def test_two_equal_minima_are_one_within_reach_and_two_beyond():
    clips = [steps([1, 0, 1, 0, 1, 1, 4]), steps([0])]  # D: as A
    for neighbourhood, want in ((1, {1, 3}), (2, {1}), (3, {1})):
        found = search(clips, window=1, neighbourhood=neighbourhood, threshold=0.5)
        assert across(found, 7) == {(row, 0) for row in want}


def test_thresholds_only_take_away():
    clips = marches(40, 30)
    everything = search(clips)
    for threshold in (1e-4, 0.02, 0.05, 0.1, 1.0):
        some = search(clips, threshold=threshold)
        keep = everything.distances < threshold
        np.testing.assert_array_equal(some.rows, everything.rows[keep])
        np.testing.assert_array_equal(some.columns, everything.columns[keep])
        np.testing.assert_array_equal(some.distances, everything.distances[keep])


def test_more_neighbours_only_take_away():
    clips = marches(40, 30)
    found = []
    for neighbourhood in (1, 2, 3, 5):
        m = search(clips, neighbourhood=neighbourhood)
        real = m.distances > 0.01  # nearer to 0 rounding decides
        found.append(set(zip(m.rows[real].tolist(), m.columns[real].tolist(), strict=True)))
    assert all(more <= less for less, more in zip(found, found[1:], strict=False))
    assert len(found[-1]) < len(found[0])


def test_windows_that_may_not_be_used(tile):
    #        2  0  4  2
    #   0    2  0  4  2      Without the row of 0 and the column of 0, (1, 0) and (1, 2) have no
    #   3    1  3  1  1      lower neighbour left; (1, 3), (2, 0) and (2, 3) tie with one that comes
    #   1    1  1  3  1      first, or have (3, 2).
    #   4    2  4  0  2
    a, b = [0, 3, 1, 4], [2, 0, 4, 2]
    clips = np.concatenate([steps(a), steps(b)])
    rows, columns = np.ones(8, bool), np.ones(8, bool)
    rows[0], columns[5] = False, False
    found = find_minima(
        clips, np.array([0, 4]), np.array([4, 8]), normalised_weights(None, 1),
        window=1, neighbourhood=1, threshold=np.inf, leave=rows, arrive=columns,
    )  # fmt: skip
    squares = np.abs(np.subtract.outer(np.float64(a), b)) ** 2
    squares[0], squares[:, 1] = np.inf, np.inf
    want = {x for x in reference.minima(squares, 1, np.inf) if np.isfinite(squares[x])}
    assert across(found, 4) == want == {(1, 0), (1, 2), (3, 2)}
    assert found.largest == 4.0  # of all pairs


@pytest.mark.parametrize("size", [3, 4])
def test_lowest_of_blocks(tile, size):
    """Blocks lie on the axis of frames within each tile; the lowest of each, and all minima."""
    clips = marches(31, 24)
    stops = np.cumsum([len(c) for c in clips])
    arguments = np.concatenate(clips), stops - [31, 24], stops, normalised_weights(None, 15)
    settings = {"window": 5, "neighbourhood": 1, "threshold": 0.12}
    plain, dense = (find_minima(*arguments, **settings, thinned=n) for n in (0, size))
    few, many = (set(zip(f.rows.tolist(), f.columns.tolist(), strict=True)) for f in (plain, dense))
    assert few <= many
    margin = settings["neighbourhood"]
    axis = {f: f + margin * (f >= 31) for f in range(55)}  # a gap lies after each clip
    blocks: dict[tuple[int, ...], list[tuple[float, tuple[int, int]]]] = {}
    for i, j, matrix in pairs(clips, 5):
        for r, c in np.ndindex(*matrix.shape):
            if matrix[r, c] < 0.12**2:
                place = [divmod(axis[x], tile) for x in (r + i, c + j)]
                block = tuple(v for t, inner in place for v in (t, inner // size))
                blocks.setdefault(block, []).append((float(matrix[r, c]), (r + i, c + j)))
    for entries in blocks.values():
        first, *others = sorted(entries)
        if first[0] < 0.12**2 - SLACK and all(x[0] > first[0] + SLACK for x in others):
            assert first[1] in many
        beaten = {place for value, place in entries if value > first[0] + SLACK}
        assert not (many - few) & beaten


LEVELS = st.lists(st.integers(0, 4), min_size=8, max_size=8)


@given(LEVELS, LEVELS)
def test_ties_of_small_numbers(a, b):
    """Whole heights of 16 frames make exact ties everywhere; only the rule decides."""
    matrix = np.abs(np.subtract.outer(a, b)) ** 2.0
    for neighbourhood in (1, 3):
        found = search([steps(a), steps(b)], window=1, neighbourhood=neighbourhood)
        assert across(found, 8) == set(reference.minima(matrix, neighbourhood, np.inf))


def test_a_bar_is_shown_and_changes_nothing(capsys):
    clip = marches(20)[0]
    arguments = {"window": 5, "neighbourhood": 1, "threshold": np.inf}
    ends = np.array([0]), np.array([20]), normalised_weights(None, 15)
    quiet = find_minima(clip, *ends, **arguments)
    assert capsys.readouterr().err == ""
    shown = find_minima(clip, *ends, **arguments, progress=True)
    assert "distances" in capsys.readouterr().err
    np.testing.assert_array_equal(quiet.rows, shown.rows)
