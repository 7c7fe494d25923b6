from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgjax.core.errors import GraphError
from mgjax.graph.pruning.prune import (
    Candidates,
    choose_threshold,
    largest_component,
    smallest_useful_threshold,
)
from tests.reference import graph as reference


def make(lengths, jumps, labels=()) -> Candidates:
    """Clips of some lengths, (leave, arrive, distance) and (start, stop) on the axis of frames."""
    stops = np.cumsum(lengths)
    jumps = sorted(jumps, key=lambda x: x[2])
    columns = np.array(jumps, float).reshape(-1, 3).T
    frames = np.array(labels, np.int64).reshape(-1, 2)
    return Candidates(
        leave=columns[0].astype(np.int64),
        arrive=columns[1].astype(np.int64),
        distances=columns[2],
        starts=stops - lengths,
        stops=stops,
        label_starts=frames[:, 0],
        label_stops=frames[:, 1],
    )


@st.composite
def candidates(draw) -> Candidates:
    lengths = draw(st.lists(st.integers(3, 9), min_size=1, max_size=4))
    stops = np.cumsum(lengths)
    inside = [  # as the builder makes them: a frame before the one, a frame after the other
        f for stop, n in zip(stops, lengths, strict=True) for f in range(stop - n + 1, stop)
    ]
    frame, distances = st.sampled_from(inside), st.integers(1, 6).map(lambda x: x / 50)
    jumps = draw(st.lists(st.tuples(frame, frame, distances), max_size=10))
    labels = []
    for stop, n in zip(stops, lengths, strict=True):
        cuts = draw(st.lists(st.integers(stop - n, stop), max_size=4, unique=True))
        labels += list(zip(sorted(cuts)[::2], sorted(cuts)[1::2], strict=False))
    # No transition touches a label.
    jumps = [j for j in jumps if not any(a < f < b for f in j[:2] for a, b in labels)]
    return make(lengths, jumps, [(int(a), int(b)) for a, b in labels])


def by_reachability(c: Candidates, count: int):
    labels = list(zip(c.label_starts.tolist(), c.label_stops.tolist(), strict=True))
    leave, arrive = c.leave[:count].tolist(), c.arrive[:count].tolist()
    return reference.component(c.starts.tolist(), c.stops.tolist(), leave, arrive, labels)


def test_worked_by_hand():
    # One clip of 10 frames and a way back from 7 to 2: the frames 2 … 6 are left.
    c = make([10], [(7, 2, 0.1)], [(2, 4), (6, 8), (0, 2)])
    part = largest_component(c, 1)
    assert part.frames == 5
    np.testing.assert_array_equal(part.kept, [True])
    np.testing.assert_array_equal(part.labels, [True, False, False])
    nothing = largest_component(c, 0)
    assert nothing.frames == 0
    assert not nothing.labels.any()


def test_two_clips_worked_by_hand():
    # From 5 in the first clip (0 … 9) to 12 in the second (10 … 19), from 18 back to 3; the jumps
    # from 9 and from 4 to 19 do not come back.
    c = make([10, 10], [(5, 12, 0.1), (18, 3, 0.1), (9, 19, 0.2), (4, 19, 0.3)], [(12, 18), (8, 9)])
    part = largest_component(c, 4)
    assert part.frames == 2 + 6
    np.testing.assert_array_equal(part.kept, [True, True, False, False])
    np.testing.assert_array_equal(part.labels, [True, False])
    assert largest_component(c, 1).frames == 0


def test_the_end_of_a_clip_is_not_the_beginning_of_the_next():
    # 9 → 1 in the first clip. Were its end and the second clip's start one node, the jump from the
    # second clip into the first would close a larger circle.
    c = make([10, 10], [(8, 1, 0.1), (18, 5, 0.1)])
    part = largest_component(c, 2)
    assert part.frames == 7
    np.testing.assert_array_equal(part.kept, [True, False])


def test_largest_is_by_frames_and_then_by_labels():
    # Many nodes within 4 frames against one circle of 8.
    crowd = [(5, 1, 0.1), (4, 1, 0.1), (4, 2, 0.1), (5, 3, 0.1), (3, 1, 0.1)]
    c = make([10, 10], [*crowd, (19, 11, 0.1)])
    assert largest_component(c, 6).frames == 8
    for labels in ([(2, 4)], [(12, 14)]):
        even = make([10, 10], [(8, 1, 0.1), (18, 11, 0.1)], labels)
        assert largest_component(even, 2).labels.all()


@given(candidates(), st.data())
def test_component_against_reachability(c, data):
    count = data.draw(st.integers(0, len(c.leave)))
    part = largest_component(c, count)
    sizes, kept, labels = by_reachability(c, count)
    assert part.count == count
    assert part.frames == sizes[0]
    if sizes[:2] != [part.frames, part.frames]:  # else either of two may be meant
        assert part.kept.tolist() == kept
        assert part.labels.tolist() == labels


def reachable(c: Candidates, limit: float) -> int:
    """What the share is of: all labels, or else the frames that the largest threshold keeps."""
    below = int((np.nextafter(c.distances, np.inf) <= limit).sum())
    return len(c.label_starts) or (largest_component(c, below).frames if below else 0)


def exhaustive(c: Candidates, keep: float, limit: float) -> tuple[float | None, int]:
    """The smallest threshold that is enough, over all that differ; and the most that is reached."""
    most, total = 0, reachable(c, limit)
    first = None
    for distance in np.unique(c.distances):
        threshold = float(np.nextafter(distance, np.inf))
        if threshold > limit:
            break
        part = largest_component(c, int((c.distances < threshold).sum()))
        value = int(part.labels.sum()) if len(c.label_starts) else part.frames
        most = max(most, value)
        if first is None and value > 0 and value >= keep * total - 1e-9:
            first = threshold
    return first, most


@given(candidates(), st.sampled_from([0.0, 0.3, 0.5, 0.9, 1.0]), st.sampled_from([0.07, 0.2]))
def test_the_threshold_is_the_smallest_that_is_enough(c, keep, limit):
    want, most = exhaustive(c, keep, limit)
    if want is not None:
        assert choose_threshold(c, keep, limit) == want
    else:
        total = reachable(c, limit)
        with pytest.raises(GraphError) as caught:
            choose_threshold(c, keep, limit)
        text = str(caught.value)
        assert f"of {total} " in text
        if len(c.leave) and c.distances[0] < limit:
            assert f"got {most} of" in text


def test_labels_that_a_larger_component_without_them_takes_away():
    # With one jump the first clip's circle holds the label. From 0.10 m on the second clip's is
    # larger; at 0.19 m they join. So 0.05 m is enough, 0.1 is not, and a search by halves from
    # above would end at 0.19.
    jumps = [(8, 1, 0.05), (38, 11, 0.1), (6, 13, 0.15), (35, 2, 0.19)]
    c = make([10, 30], jumps, [(2, 4)])
    assert choose_threshold(c, 0.9, 0.2) == np.nextafter(0.05, 1)
    # The same with the larger one first: only the last jump will do.
    jumps = [(38, 11, 0.02), (8, 1, 0.05), (6, 13, 0.15), (35, 2, 0.19)]
    c = make([10, 30], jumps, [(2, 4)])
    assert choose_threshold(c, 0.9, 0.2) == np.nextafter(0.19, 1)


def test_the_threshold_is_exact():
    """The transition whose distance it is just above is needed, and is below it."""
    c = make([20], [(12, 3, 0.12345), (18, 2, 0.15)], [(4, 6)])
    threshold = choose_threshold(c, 1.0, 0.2)
    assert c.distances[0] < threshold < c.distances[0] + 1e-12
    # Without labels the share is that of the frames.
    frames = make([20], [(12, 3, 0.12345), (18, 2, 0.15)])
    assert choose_threshold(frames, 0.56, 0.2) == threshold  # 9 of 16 frames
    assert choose_threshold(frames, 0.57, 0.2) == np.nextafter(0.15, 1)


def test_an_error_names_the_best_that_can_be_reached():
    c = make(
        [30], [(9, 1, 0.05), (20, 2, 0.11), (28, 1, 0.3)], [(2, 4), (5, 7), (12, 15), (22, 24)]
    )
    with pytest.raises(GraphError) as caught:
        choose_threshold(c, 0.9, 0.2)
    text = str(caught.value)
    assert "got 3 of 4 labels kept at most (at 0.1100 m)" in text
    assert "up to 0.2 m, expected 90%" in text
    assert "\n" not in text
    with pytest.raises(GraphError, match=r"got none of 1 labels .* lower keep"):
        choose_threshold(make([10], [], [(2, 4)]), 0.9, 0.2)
    with pytest.raises(GraphError, match=r"got none of 0 frames"):
        choose_threshold(make([30], []), 0.9, 0.2)


@given(candidates())
def test_smallest_useful_threshold(c):
    useful = [
        float(np.nextafter(d, np.inf))
        for d in np.unique(c.distances)
        if by_reachability(c, int((c.distances <= d).sum()))[0][0]
    ]
    assert smallest_useful_threshold(c) == (useful[0] if useful else None)


def test_many_candidates_take_few_components(monkeypatch):
    """Thousands of transitions, of which the automatic threshold needs a few dozen looks."""
    from mgjax.graph.pruning import prune

    rng = np.random.default_rng(0)
    frames = rng.integers(1, 999, size=(3000, 2))
    jumps = [
        (int(a), int(b), float(d))
        for (a, b), d in zip(frames, rng.uniform(0, 0.2, 3000), strict=True)
    ]
    labels = [(20 * i, 20 * i + 4) for i in range(50)]
    jumps = [j for j in jumps if not any(a < f < b for f in j[:2] for a, b in labels)]
    calls = []
    whole = prune.largest_component
    monkeypatch.setattr(prune, "largest_component", lambda *a: calls.append(1) or whole(*a))
    threshold = choose_threshold(make([1000], jumps, labels), 0.9, 0.2)
    assert len(calls) < 60
    assert re.fullmatch(r"0\.\d+", str(threshold))
