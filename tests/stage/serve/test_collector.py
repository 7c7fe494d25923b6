import gc
import weakref

import pytest

from mgjax.stage.serve.collector import freeze, waiting_collector


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
