from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.clips.synthetic import synthetic_clips
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.pruning.prune import Candidates
from mgjax.graph.pruning.thin import best_per_second

WINDOW = 10
SECOND = 30


def made(
    leave: list[int], arrive: list[int], starts: list[int], stops: list[int], labels: list[int]
) -> Candidates:
    """Candidates in the order of their distance, of windows that begin at ``arrive``."""
    return Candidates(
        leave=np.array(leave),
        arrive=np.array(arrive) + WINDOW,
        distances=np.arange(len(leave)) * 0.01,
        starts=np.array(starts),
        stops=np.array(stops),
        label_starts=np.array(labels, np.int64),
        label_stops=np.array(labels, np.int64) + 20,
    )


def drawn(seed: int, count: int = 400) -> Candidates:
    rng = np.random.default_rng(seed)
    starts = np.array([0, 130, 310, 360])
    stops = np.array([130, 310, 360, 700])
    leave = rng.integers(0, 700 - WINDOW, count)
    arrive = rng.integers(0, 700 - WINDOW, count)
    labels = [40, 90, 200, 400, 500, 660]
    return made(leave.tolist(), arrive.tolist(), starts.tolist(), stops.tolist(), labels)


def plainly(c: Candidates, count: int, most: int) -> np.ndarray:
    """One candidate after the other, as it is defined."""
    stays = np.zeros(len(c.leave), bool)
    seconds: dict[tuple[int, int], dict[tuple[str, int], list[int]]] = {}
    for number in range(count):
        clip = max(k for k, start in enumerate(c.starts) if start <= c.leave[number])
        moment = int(c.leave[number] - c.starts[clip]) // SECOND
        begin = int(c.arrive[number]) - WINDOW
        to = max(k for k, start in enumerate(c.starts) if start <= begin)
        coming = [x for x in c.label_starts.tolist() if begin <= x < c.stops[to]]
        place = ("part", min(coming)) if coming else ("clip", to)
        seconds.setdefault((clip, moment), {}).setdefault(place, []).append(number)
    for places in seconds.values():
        rounds = [
            sorted(numbers[turn] for numbers in places.values() if turn < len(numbers))
            for turn in range(max(map(len, places.values())))
        ]
        chosen = [number for numbers in rounds for number in numbers]
        stays[chosen[:most]] = True
    return stays


def test_by_hand() -> None:
    # Four leave the first second: three for the part at 60, and the farthest for the second clip.
    c = made([0, 5, 29, 10, 30], [50, 51, 52, 110, 50], [0, 100], [100, 200], [60])
    kept = best_per_second(c, 5, WINDOW, most=2, second=SECOND)
    assert kept.tolist() == [True, False, False, True, True]
    kept = best_per_second(c, 5, WINDOW, most=3, second=SECOND)
    assert kept.tolist() == [True, True, False, True, True]


@pytest.mark.parametrize("most", [1, 2, 5, 9])
@pytest.mark.parametrize("count", [1, 250, 400])
def test_agrees_with_the_definition(most: int, count: int) -> None:
    for seed in range(3):
        c = drawn(seed)
        kept = best_per_second(c, count, WINDOW, most=most, second=SECOND)
        np.testing.assert_array_equal(kept, plainly(c, count, most))


def test_none_and_all() -> None:
    c = drawn(0)
    everything = best_per_second(c, 300, WINDOW, most=0, second=SECOND)
    assert everything.tolist() == [True] * 300 + [False] * 100
    np.testing.assert_array_equal(
        best_per_second(c, 300, WINDOW, most=300, second=SECOND), everything
    )
    assert not best_per_second(c, 0, WINDOW, most=3, second=SECOND).any()


def test_a_clip_in_front_changes_nothing() -> None:
    c = drawn(3)
    shift = 77  # frames of a clip that nothing leaves, no whole number of seconds
    later = replace(
        c,
        leave=c.leave + shift,
        arrive=c.arrive + shift,
        starts=np.append(0, c.starts + shift),
        stops=np.append(shift, c.stops + shift),
        label_starts=c.label_starts + shift,
        label_stops=c.label_stops + shift,
    )
    for most in (1, 4):
        np.testing.assert_array_equal(
            best_per_second(c, 400, WINDOW, most=most, second=SECOND),
            best_per_second(later, 400, WINDOW, most=most, second=SECOND),
        )


def test_a_graph_has_no_more_out_of_a_second_and_says_so() -> None:
    clips, labels = synthetic_clips()
    some = [clip for clip in clips if clip.name in sorted(labels)[:3]]
    named = {clip.name: labels[clip.name] for clip in some}
    config = GraphConfig(threshold_m=0.05)
    free = build_graph(some, labels=named, config=replace(config, best_per_s=0))
    few = build_graph(some, labels=named, config=replace(config, best_per_s=5))
    of_transitions = few.edge_clip < 0
    leaves = few.node_frame[few.edge_source[of_transitions]]
    clip = few.node_clip[few.edge_source[of_transitions]]
    moment = (leaves - few.clip_starts[clip]) // round(few.frame_rate)
    _, counts = np.unique(np.stack([clip, moment]), axis=1, return_counts=True)
    assert counts.max() <= 5
    assert free.report["dropped_by_best_per_s"] == 0
    assert few.report["dropped_by_best_per_s"] > 0
    assert few.report["transitions"] < free.report["transitions"]
