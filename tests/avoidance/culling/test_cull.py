from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance import choose, select_batch
from mgjax.avoidance.attacks.crop import crop_attack
from mgjax.avoidance.body.edge_tables import edge_tables
from mgjax.avoidance.candidates.enumerate import enumerate_candidates
from mgjax.avoidance.config import AvoidanceConfig, validate_config
from mgjax.avoidance.culling.cull import cull, timing_of, without_culled
from mgjax.avoidance.culling.overlap import overlap_pixels
from mgjax.avoidance.culling.pictures import (
    Slices,
    build_slices,
    picture_bytes,
)
from mgjax.avoidance.energy.evaluate import judge
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.timing.time_scale import OK
from mgjax.core.errors import ConfigError
from mgjax.graph.types import MotionGraph
from tests.avoidance.culling.made import (
    FORMS,
    RATE,
    drawn_of,
    pixel_set,
)
from tests.avoidance.made import throw

CONFIG = AvoidanceConfig(T_wide=0.0, capacity=4096)
"""One window, whose candidates are counted."""


@pytest.mark.parametrize("form", ["paper", "binned"])
def test_what_is_culled_is_left_out(made_graph: MotionGraph, form: str) -> None:
    rng = np.random.default_rng(4)
    config = replace(CONFIG, culling=form)
    prepared = prepared_for(made_graph, config)
    tables, device, slices = prepared.tables, prepared.device, prepared.slices
    assert slices is not None
    rate = made_graph.frame_rate
    culled_at_all = 0
    for _ in range(8):
        node, attack = int(rng.integers(made_graph.num_nodes)), throw(rng)
        crop = crop_attack(attack, radius=1.0, height=2.3)
        assert crop is not None
        every = enumerate_candidates(
            made_graph, tables, node, crop.middle, window=1.0, capacity=CONFIG.capacity
        )
        kept, culled = without_culled(slices, device, every, attack, crop, config, frame_rate=rate)
        assert len(kept.length) + culled == len(every.length)
        culled_at_all += culled
        if not len(every.length):
            continue
        # The same timing as the search's own, and nothing that cannot be timed is dropped.
        status, scales = timing_of(device, every, crop, CONFIG, frame_rate=rate)
        judged = judge(device, every, attack, crop, CONFIG, frame_rate=rate)
        np.testing.assert_array_equal(status, judged["status"])
        np.testing.assert_allclose(scales, judged["scales"][:, : scales.shape[1]], atol=1e-6)
        assert culled <= (status == OK).sum()
        choice = choose(made_graph, node, attack, config=config)
        assert choice.candidates == len(every.length) + every.overflow
        assert choice.dropped.culled == culled
    assert culled_at_all > 0


def test_settings() -> None:
    bad = replace(CONFIG)
    object.__setattr__(bad, "culling", "all")  # past the type check of the tests
    with pytest.raises(ConfigError, match="expected none, paper or binned"):
        validate_config(bad)


def test_many_attacks_are_not_culled(made_graph: MotionGraph) -> None:
    with pytest.raises(ConfigError, match="expected none where attacks are many"):
        select_batch(made_graph, [], [], config=replace(CONFIG, culling="binned"))


def test_cull_keeps_up_to_the_threshold(thrown: tuple[Slices, list]) -> None:
    slices, cases = thrown
    walks, scales, attack, crop = cases[0]
    for form in FORMS:
        counts = overlap_pixels(slices, walks, scales, drawn_of(attack, crop), crop, form=form)
        middle = int(np.median(counts))
        for threshold in (0, middle, int(counts.max())):
            keep = cull(slices, walks, scales, attack, crop, form=form, threshold=threshold)
            assert (keep == (counts <= threshold)).all()
        assert counts.max() > counts.min()


def test_capture(capture, real_graph: MotionGraph) -> None:
    """On real capture: every bin of an edge is within its picture, and the size is modest."""
    slices = build_slices(edge_tables(real_graph, RATE))
    assert picture_bytes(slices.binned) + picture_bytes(slices.paper) < 60e6
    rng = np.random.default_rng(0)
    for edge in rng.integers(0, real_graph.num_edges, 5):
        first = int(slices.first_bin[edge])
        bins = [pixel_set(slices.binned, first + b) for b in range(int(slices.bins[edge]))]
        assert pixel_set(slices.paper, int(edge)) == set().union(*bins)
