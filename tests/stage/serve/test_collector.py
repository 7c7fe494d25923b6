import gc
import sys
import threading
import weakref
from pathlib import Path

import numpy as np
import pytest

from mgjax.stage.serve.collector import freeze, give_back, waiting_collector


class Knot:
    """Refers to itself, so that only the collector frees it."""

    def __init__(self) -> None:
        self.me = self


@pytest.fixture(autouse=True)
def as_before():
    yield
    gc.unfreeze()
    gc.enable()


def test_garbage_is_collected_before_the_rest_is_frozen():
    knot = weakref.ref(Knot())
    kept = Knot()
    freeze()
    assert knot() is None
    assert gc.get_freeze_count() > 0
    assert gc.isenabled()
    del kept


def test_nothing_is_collected_within_and_all_is_frozen_after():
    gc.collect()
    with waiting_collector():
        assert not gc.isenabled()
        knot = weakref.ref(Knot())
        for _ in range(5000):
            Knot()
        assert knot() is not None
    assert gc.isenabled()
    assert gc.get_freeze_count() > 5000
    later = weakref.ref(Knot())
    gc.collect()
    assert later() is None, "what comes afterwards is collected as ever"


def test_the_collector_works_again_after_a_failure():
    with pytest.raises(ZeroDivisionError), waiting_collector():
        _ = 1 / 0
    assert gc.isenabled()


@pytest.mark.skipif(sys.platform != "linux", reason="memory is counted and returned on Linux only")
def test_holes_go_back_to_the_system():
    def resident_mb() -> float:
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20

    kept = []

    def holes() -> None:  # too small to be mapped one by one, and held by what comes after them
        blocks = [np.ones(12_000) for _ in range(1000)]
        kept.append([blocks[k].copy() for k in range(0, 1000, 50)])

    other = threading.Thread(target=holes)
    other.start()
    other.join()
    before = resident_mb()
    give_back()
    assert resident_mb() < before - 40
    assert np.sum(kept[0]) == 20 * 12_000
