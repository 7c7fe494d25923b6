from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mgjax.clips.types import Label
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.distances import pruned
from mgjax.graph.distances.tile_pair import TilePair
from mgjax.graph.pruning import shortlist
from mgjax.graph.pruning.candidates import Conditions
from mgjax.graph.pruning.prune import Candidates
from mgjax.graph.pruning.shortlist import BestOfSeconds
from mgjax.graph.pruning.thin import best_per_second
from mgjax.graph.stages import block
from mgjax.graph.stages.stages import Stages, stage_store
from tests.graph.made import clip, march
from tests.graph.stages.test_build_in_stages import assert_same_graph, counts

WINDOW, SECOND, LIMIT = 10, 30, 1.0
STARTS, STOPS = np.array([0, 130, 310, 360]), np.array([130, 310, 360, 700])
LABELS = np.array([40, 90, 200, 400, 500, 660])


class Every(Conditions):
    """All minima are candidates."""

    def __init__(self, most: int) -> None:
        config = GraphConfig(threshold_m=LIMIT, best_per_s=most)
        known = {"timeline": SimpleNamespace(root=np.zeros(700)), "config": config}
        for name, value in {"window": WINDOW, **known}.items():
            object.__setattr__(self, name, value)

    def candidates(self, rows, columns, distances):
        found = Candidates(
            leave=rows,
            arrive=columns + WINDOW,
            distances=distances,
            starts=STARTS,
            stops=STOPS,
            label_starts=LABELS,
            label_stops=LABELS + 20,
        )
        return found, np.ones(len(rows), bool)


def drawn(seed: int, count: int = 3000) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of windows, none twice, sorted by D²; some are as far apart as others."""
    rng = np.random.default_rng(seed)
    numbers = rng.choice(690 * 690, count, replace=False)
    rows, columns, squared = numbers // 690, numbers % 690, rng.integers(1, 900, count) / 1000.0
    order = np.lexsort((columns, rows, squared))
    return rows[order], columns[order], squared[order]


@pytest.mark.parametrize("most", [1, 3, 8, 40])
@pytest.mark.parametrize("known", [False, True])
def test_what_stays_of_all_in_whatever_order_it_is_found(monkeypatch, most, known):
    monkeypatch.setattr(shortlist, "_FEW", 100)
    lowered = 0
    for seed in range(4):
        rows, columns, squared = drawn(seed)
        conditions = Every(most)
        every, _ = conditions.candidates(rows, columns, np.sqrt(squared))
        stays = best_per_second(every, len(rows), WINDOW, most=most, second=SECOND)
        best = BestOfSeconds(conditions, LIMIT)
        for part in np.array_split(np.random.default_rng(seed).permutation(len(rows)), 23):
            # What the search leaves out by the limits that it is told.
            found = part[squared[part] <= best.limits()[rows[part]]] if known else part
            best.add(rows[found], columns[found], squared[found])
            best.add(rows[found[:2]], columns[found[:2]], squared[found[:2]])  # once more
        for got, want in zip(best.kept(), (rows, columns, squared), strict=True):
            np.testing.assert_array_equal(got, want[stays])
        lowered += int((best.limits() < LIMIT).sum())
    assert lowered > 0 if most <= 8 else lowered == 0  # there are ten places


def test_limits_by_hand():
    # Two may leave a second. The first one has ways to two places, the second one to one.
    best = BestOfSeconds(Every(2), LIMIT)
    rows, columns = np.array([0, 3, 4, 31, 32]), np.array([20, 20, 150, 20, 20])
    best.add(rows, columns, np.array([0.1, 0.2, 0.5, 0.3, 0.4]))
    kept = best.kept()
    assert kept[0].tolist() == [0, 31, 32, 4]
    assert best.limits()[:60].tolist() == [0.5] * 30 + [1.0] * 30
    best.add(np.array([7]), np.array([210]), np.array([0.3]))
    assert best.kept()[0].tolist() == [0, 7, 31, 32]
    assert best.limits()[[0, 29, 30, 130]].tolist() == [0.3, 0.3, 1.0, 1.0]


@pytest.fixture
def many(monkeypatch):
    """Clips that resemble one another, and tiles so small that there are many; all builds are
    large."""
    for module in (pruned, block):
        monkeypatch.setattr(module, "TILE", 64)
    monkeypatch.setattr(shortlist, "MANY", 0)
    monkeypatch.setattr(shortlist, "_FEW", 10)
    clips = [clip(str(k), march(60 + 11 * k, seed=k, noise=0.02)) for k in range(9)]
    labels = {"3": (Label(start_s=1.0, end_s=1.5, kind="duck", direction="left", genuine=True),)}
    return clips, labels


CONFIG = GraphConfig(threshold_m=0.12, best_per_s=3)


def searched(monkeypatch) -> list[int]:
    """How many pairs of windows each pair of tiles compares."""
    opened, of = [], TilePair.minima

    def watched(self, bits):
        opened.append(int(np.bitwise_count(bits).sum()))
        return of(self, bits)

    monkeypatch.setattr(TilePair, "minima", watched)
    return opened


def test_a_build_that_leaves_out_makes_the_same_graph(many, monkeypatch):
    clips, labels = many
    monkeypatch.setattr(shortlist, "MANY", 1 << 30)
    clips = clips[:6]
    whole = build_graph(clips, labels=labels, config=CONFIG, stages=Stages())
    monkeypatch.setattr(shortlist, "MANY", 0)
    part = build_graph(clips, labels=labels, config=CONFIG, stages=Stages(entries=130))
    assert_same_graph(whole, part)
    assert whole.report["dropped_by_best_per_s"] > 100
    for name in ("minima", "candidates", "dropped_by_best_per_s"):
        assert part.report[name] is None
    # Where the threshold follows from the minima, all are needed.
    free = replace(CONFIG, threshold_m=None)
    assert build_graph(clips, labels=labels, config=free).report["minima"] > 300


def test_in_one_piece_less_is_compared(many, monkeypatch):
    clips, labels = many
    monkeypatch.setattr("mgjax.graph.distances.minima._BATCH", 10)
    monkeypatch.setattr("mgjax.graph.distances.minima._SMALL", 0)
    opened = searched(monkeypatch)
    monkeypatch.setattr(shortlist, "MANY", 1 << 30)
    whole = build_graph(clips, labels=labels, config=CONFIG)
    every, once = sum(opened), len(opened)
    opened.clear()
    monkeypatch.setattr(shortlist, "MANY", 0)
    part = build_graph(clips, labels=labels, config=CONFIG)
    assert_same_graph(whole, part)
    assert 0 < sum(opened) < every
    assert len(opened) > once  # near by first, the others later
    assert_same_graph(whole, build_graph(clips, labels=labels, config=CONFIG, stages=Stages()))


@pytest.mark.long
def test_what_is_kept_serves_more_clips_and_not_fewer(many, tmp_path):
    clips, labels = many

    def built(chosen, folder):
        used = Stages(store=stage_store(folder), entries=130)
        named = {name: some for name, some in labels.items() if name in {c.name for c in chosen}}
        return build_graph(chosen, labels=named, config=CONFIG, stages=used), counts(used)

    clips = clips[:6]
    built(clips[:4], tmp_path / "one")
    more, (found, made) = built(clips, tmp_path / "one")
    assert found["minima"] > 0
    assert made["minima"] > 0
    assert_same_graph(built(clips, tmp_path / "another")[0], more)
    # Of fewer clips some were looked for below limits that do not hold now.
    fewer, (_, made) = built(clips[2:5], tmp_path / "one")
    assert_same_graph(built(clips[2:5], tmp_path / "third")[0], fewer)
    assert made["minima"] > 0
    again, (found, made) = built(clips[2:5], tmp_path / "one")
    assert_same_graph(again, fewer)
    assert "minima" not in made
    # A setting that lets more stay asks for more, too.
    used = Stages(store=stage_store(tmp_path / "one"), entries=130)
    config = replace(CONFIG, best_per_s=0)
    every = build_graph(clips, labels=labels, config=config, stages=used)
    assert counts(used)[1]["minima"] > 0
    assert_same_graph(every, build_graph(clips, labels=labels, config=config, stages=Stages()))
