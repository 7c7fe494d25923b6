"""Work in the background: it tells how far it is, can be stopped, and its errors become words."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.coverage.report import coverage_report
from mgjax.core.errors import ConfigError, GraphError
from mgjax.stage.apps.edit.cover import (
    DIRECTIONS,
    HEIGHTS_M,
    ROUND,
    cover,
    coverage_map,
    throw_of_cell,
)
from mgjax.stage.apps.edit.job import Job
from mgjax.stage.apps.edit.rebuild import rebuild
from mgjax.stage.apps.edit.session import EditSession
from mgjax.stage.apps.edit.workbench import Settings
from tests.stage.apps.edit.conftest import SETTINGS, Page, until_idle


def ended(job: Job) -> Job:
    job._thread.join(30)
    assert job.over
    return job


def test_a_job_says_how_far_it_is_and_what_came_of_it():
    go = threading.Event()
    told = threading.Event()

    def work(watch):
        watch(0.5, "half")
        told.set()
        go.wait(30)
        return 7

    job = Job(work, "work")
    told.wait(30)
    assert (job.share, job.text, job.over) == (0.5, "half", False)
    go.set()
    assert ended(job).result == 7
    assert job.error == ""


def test_a_job_stops_when_it_next_tells():
    go = threading.Event()

    def work(watch):
        go.wait(30)
        watch(0.5, "half")
        raise AssertionError("it went on")

    job = Job(work, "work")
    job.stop()
    go.set()
    assert (ended(job).result, job.error, job.stopped) == (None, "", True)


def test_errors_become_words(capfd):
    def bad(watch):
        raise GraphError("got nothing, expected something")

    assert ended(Job(bad, "work")).error == "got nothing, expected something"
    assert ended(Job(lambda watch: 1 / 0, "work")).error.startswith("work failed: ZeroDivision")
    assert "ZeroDivisionError" in capfd.readouterr().err


def test_a_rebuild_tells_its_steps_in_order_and_equals_a_build(library, some, graph):
    told = []
    built = rebuild(library, some[1], (), SETTINGS.config(), None, lambda *x: told.append(x))
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert shares[-1] < 1
    assert {"reading clips", "comparing poses", "blending transitions"} <= {
        text for _, text in told
    }
    for name in ("edge_source", "edge_distance", "label_starts", "local_rotations"):
        np.testing.assert_array_equal(getattr(built.graph, name), getattr(graph, name))


def test_a_rebuild_writes_the_folder_that_the_commands_read(library, some, graph, tmp_path):
    from mgjax.avoidance.index.files import load_index
    from mgjax.graph.files import load_graph

    rebuild(library, some[1], (), SETTINGS.config(), tmp_path / "graph", lambda *x: None)
    there = load_graph(tmp_path / "graph")
    np.testing.assert_array_equal(there.edge_source, graph.edge_source)
    assert load_index(tmp_path / "graph", there) is not None
    assert (tmp_path / "graph" / "build.json").is_file()


def test_an_impossible_build_is_said_and_the_graph_stays(bench, graph):
    page = Page()
    EditSession(bench, page)
    bench.build(Settings(threshold_m=0.0011), write=False)
    until_idle(bench)
    assert page.last("sentence")["tone"] == "bad"
    assert "expected at least" in page.last("sentence")["text"]
    assert bench.graph is graph


def test_coverage_grows_by_rounds_and_its_cells_are_counted(graph):
    config = AvoidanceConfig()
    rounds = []
    whole = cover(graph, config, 2, rounds.append, lambda *x: None)
    assert [len(found) for found in rounds] == [ROUND * DIRECTIONS, 2 * ROUND * DIRECTIONS]
    told = coverage_map(whole)
    counted = {s.value: told[s.value] for s in Status}
    assert (sum(counted.values()) == 2 * ROUND // len(HEIGHTS_M)).all()
    share = counted["avoided"] / sum(counted.values())
    np.testing.assert_allclose(share, coverage_report(graph, whole)["cells"]["avoided"], atol=1e-4)
    direction, height = np.argwhere(counted["avoided"] > 0)[0]
    statuses = []
    for turn in range(6):
        attack, selection, words = throw_of_cell(
            graph, config, whole, int(direction), int(height), turn
        )
        start = attack.centres[0, 0]
        angle = whole.directions[direction]
        np.testing.assert_allclose(start[1], graph.body_scale * HEIGHTS_M[height])
        away = 5.0 if attack.times[0] >= 0 else np.hypot(start[0], start[2])
        np.testing.assert_allclose(
            start[[0, 2]], away * np.array([np.sin(angle), np.cos(angle)]), atol=1e-6
        )
        assert f"ball {turn + 1} of 6" in words
        statuses.append(selection.status)
    assert sum(s == Status.AVOIDED for s in statuses) == counted["avoided"][direction, height]


def test_coverage_of_a_graph_without_parts_or_rounds_is_refused(graph):
    none = np.zeros(0, np.int64)
    frames = dict.fromkeys(("label_edge", "label_starts", "label_stops"), none)
    bare = replace(
        graph, **frames, label_kind=(), label_direction=(), label_genuine=none.astype(bool)
    )
    with pytest.raises(GraphError, match="without avoidance parts"):
        cover(bare, AvoidanceConfig(), 1, lambda found: None, lambda *x: None)
    with pytest.raises(ConfigError, match="0 rounds"):
        cover(graph, AvoidanceConfig(), 0, lambda found: None, lambda *x: None)


def test_a_cell_throws_its_balls_one_after_another(bench):
    page = Page()
    tab = EditSession(bench, page)
    tab.receive({"type": "cover", "rounds": 1})
    until_idle(bench)
    assert page.last("map")["avoided"].shape == (DIRECTIONS, len(HEIGHTS_M))
    for number in (1, 2):
        tab.receive({"type": "throw", "direction": 3, "height": 2})
        shown = page.last("show")
        assert (shown["of"], len(shown["show"]["balls"])) == ("throw", 1)
        assert f"ball {number} of 3" in shown["show"]["words"]
    other = Page()
    EditSession(bench, other)
    assert other.of("map")
    bench.take_graph(bench.graph, {})
    assert bench.coverage is None


def test_stopped_throws_keep_the_map_until_then(bench):
    page = Page()
    tab = EditSession(bench, page)
    tab.receive({"type": "cover", "rounds": 40})
    end = time.monotonic() + 60
    while not page.of("map") and time.monotonic() < end:
        bench.poll()
        time.sleep(0.005)
    tab.receive({"type": "stop", "job": "cover"})
    until_idle(bench)
    assert "stopped" in page.last("sentence")["text"]
    assert len(bench.coverage) < 40 * ROUND * DIRECTIONS
