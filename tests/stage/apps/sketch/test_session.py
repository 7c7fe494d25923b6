from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mgjax.cli import walk as command
from mgjax.cli.arguments import Walk
from mgjax.core.errors import MgjaxError
from mgjax.graph.files import save_graph
from mgjax.hybrid.paths.search import follow
from mgjax.io.load import load_motion
from mgjax.stage.apps.sketch import solve
from mgjax.stage.apps.sketch.solve import Solver
from mgjax.stage.packet import pack, unpack
from tests.stage.apps.sketch.tab import Tab

STROKE = [[0.0, 0.03 * i] for i in range(120)]


def only(note: dict[str, Any]) -> dict[str, Any]:
    (item,) = note["items"]
    return item


def places_of(note: dict[str, Any]) -> dict[str, np.ndarray]:
    return {thing["id"]: np.array(thing["place"]) for thing in note["things"]}


@pytest.fixture
def searches(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Methods of the path searches that were made for drawings."""
    made: list[str] = []

    def counted(*args: Any, **kwargs: Any) -> Any:
        made.append(kwargs["config"].method)
        return follow(*args, **kwargs)

    monkeypatch.setattr(solve, "follow", counted)
    return made


def test_a_new_page_shows_somebody_who_waits(tab: Tab) -> None:
    ready, shown = tab.told
    assert ready["app"] == "sketch"
    show = unpack(pack(shown))["show"]
    assert [actor["id"] for actor in show["actors"]] == ["waiting"]
    assert show["seconds"] == 0
    assert "Draw on the floor" in show["words"]


def test_a_stroke_is_walked_at_once_and_then_better(tab: Tab, searches: list[str]) -> None:
    note = tab.send("path", points=STROKE)
    assert note["better"]
    assert searches == ["beam"]
    note = tab.refined()
    assert searches == ["beam", "exact"]
    assert not note["better"]
    assert note["words"].startswith("Follows 3.6 m in ")
    assert note["tone"] == "good"
    lines = {line["id"]: line["points"] for line in note["lines"]}
    assert np.abs(lines["track"][:, 0]).max() < 0.1
    assert lines["track"][-1, 2] == pytest.approx(3.57, abs=0.15)
    np.testing.assert_allclose(lines["path"][[0, -1], 2], [0, 3.57], atol=0.01)
    (actor,) = note["actors"]
    frames = actor["frames"]
    assert (len(frames["root"]) - 1) / frames["rate"] == pytest.approx(note["seconds"])
    assert unpack(pack(note))["words"] == note["words"]


def test_a_target_that_is_moved_needs_no_other_walk(tab: Tab, searches: list[str]) -> None:
    tab.send("ready_made", name="line")
    tab.refined()
    note = tab.send("add", kind="right_hand", place=[-0.3, 0, 3])
    item, found = only(note), len(searches)
    track = note["lines"][1]["points"]
    for step in range(3):
        place = [-0.3, 1.2 + 0.05 * step, 3.0]
        note = tab.send("move", id=item["id"], place=place, done=False, latest=True)
        assert only(note)["words"].startswith("reached, ")
        np.testing.assert_allclose(places_of(note)[item["id"]], place)
    note = tab.send("move", id=item["id"], place=[-0.3, 1.3, 3.2], done=True)
    assert len(searches) == found
    np.testing.assert_array_equal(note["lines"][1]["points"], track)
    assert note["spans"][0]["row"] == "right hand"


def test_a_drag_is_one_step_back(tab: Tab) -> None:
    tab.send("ready_made", name="line")
    placed = tab.send("add", kind="left_hand", place=[0.3, 0, 3])
    item = only(placed)["id"]
    for step in range(3):
        tab.send("move", id=item, place=[0.3, 1.0 + 0.1 * step, 3], done=False, latest=True)
    moved = tab.send("move", id=item, place=[0.3, 1.4, 3], done=True)
    assert moved["undo"] == placed["undo"] + 1
    back = tab.send("undo")
    np.testing.assert_allclose(places_of(back)[item], places_of(placed)[item])
    assert tab.send("undo")["items"] == []
    tab.send("undo")
    assert tab.note["lines"] == []
    with pytest.raises(MgjaxError, match="nothing to undo"):
        tab.send("undo")


def test_an_obstacle_is_walked_around(tab: Tab, searches: list[str]) -> None:
    tab.send("ready_made", name="line")
    tab.refined()
    before = len(searches)
    note = tab.send("add", kind="obstacle", place=[0.5, 0, 3])
    item = only(note)["id"]
    tab.send("move", id=item, place=[0.4, 0, 3], done=True)
    note = tab.refined()
    assert len(searches) > before
    track = note["lines"][1]["points"]
    assert np.linalg.norm(track[:, ::2] - [0.4, 3], axis=1).min() > 0.2 + 0.3 - 0.02
    assert note["tone"] == "good"


def test_where_no_walk_leads_it_says_so(tab: Tab) -> None:
    tab.send("ready_made", name="line")
    tab.send("add", kind="obstacle", place=[0, 0, 3])
    item = only(tab.note)["id"]
    tab.send("set", id=item, radius=2.0, done=True)
    note = tab.refined()
    assert note["words"].startswith("Cannot follow beyond (0.0, 0.")
    assert note["tone"] == "bad"
    assert "failed" in places_of(note)
    note = tab.send("move", id=item, place=[0, 0, 0.5], done=True)
    assert note["words"].startswith("Cannot walk there: got an obstacle")
    assert [actor["id"] for actor in note["actors"]] == ["waiting"]


def test_a_bar_lies_across_the_path_and_its_ends_are_moved(tab: Tab) -> None:
    tab.send("ready_made", name="line")
    note = tab.send("add", kind="bar", place=[0, 0, 3])
    item = only(note)
    assert item["words"].startswith("ducked under")
    bar = next(thing for thing in note["things"] if thing["id"] == item["id"])
    np.testing.assert_allclose(np.subtract(bar["end"], bar["place"]), [1.6, 0, 0], atol=1e-3)
    note = tab.send("move", id=f"{item['id']}.to", place=[1.0, 2.2, 3], done=True)
    note = tab.send("move", id=f"{item['id']}.from", place=[-1.0, 2.2, 3], done=True)
    assert only(note)["words"].startswith("passed upright")


def test_while_it_is_dragged_no_way_is_added_to_a_target_out_of_reach(tab: Tab) -> None:
    tab.send("ready_made", name="line")
    tab.refined()
    item = only(tab.send("add", kind="right_hand", place=[0, 0, 3]))["id"]
    note = tab.send("move", id=item, place=[-2, 1.2, 3], done=False, latest=True)
    assert only(note)["words"].startswith("out of reach here")
    note = tab.send("move", id=item, place=[-2, 1.2, 3], done=True)
    assert "of way added" in only(note)["words"]
    assert "aside" in note["words"]


def test_a_target_waits_for_its_time_and_is_held(tab: Tab) -> None:
    tab.send("ready_made", name="line")
    item = only(tab.send("add", kind="right_hand", place=[-0.3, 0, 3]))["id"]
    note = tab.send("set", id=item, hold=0.6, done=True)
    assert only(note)["hold"] == 0.6
    assert "held 0.6" in only(note)["words"]
    note = tab.send("set", id=item, when="at", seconds=2.5, done=True)
    assert only(note)["when"] == 2.5
    assert tab.send("set", id=item, when="end", done=True)["items"][0]["when"] == "end"


def test_saved_files_give_the_command_the_same_walk(
    tab: Tab, solver: Solver, tmp_path: Path
) -> None:
    wave = [[0.8 * math.sin(0.04 * i), 0.04 * i] for i in range(130)]
    tab.send("path", points=wave)
    tab.send("add", kind="obstacle", place=[1.6, 0, 2.5])
    tab.send("add", kind="right_hand", place=[0.2, 0, 2.2])
    tab.send("add", kind="bar", place=[-0.5, 0, 4.2])
    note = tab.refined()
    (tmp_path / "path.json").write_text(tab.file("save", what="path"))
    (tmp_path / "targets.json").write_text(tab.file("save", what="targets"))
    save_graph(tmp_path / "graph", solver.graph)
    command.run(
        Walk(
            graph=tmp_path / "graph",
            path=tmp_path / "path.json",
            reach=tmp_path / "targets.json",
            out=tmp_path / "out",
        )
    )
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    figures = dict(note["figures"])
    assert figures["mean distance"] == f"{100 * result['mean_distance_m']:.1f} cm"
    assert [row["status"] for row in result["targets"]] == ["reached", "cleared"]
    (tmp_path / "walk.bvh").write_text(tab.file("export", format="bvh"))
    names = ("walk.bvh", "out/motion.bvh")
    ours, theirs = (load_motion(tmp_path / name)[1] for name in names)
    np.testing.assert_allclose(ours.root_translation, theirs.root_translation, atol=1e-6)
    np.testing.assert_allclose(ours.local_rotations, theirs.local_rotations, atol=1e-6)


def test_saved_files_are_opened_again(tab: Tab, solver: Solver) -> None:
    tab.send("ready_made", name="reaches")
    note = tab.refined()
    path, targets = tab.file("save", what="path"), tab.file("save", what="targets")
    other = Tab(solver)
    other.send("open", name="path.json", text=path)
    other.send("open", name="targets.json", text=targets)
    again = other.refined()
    assert again["words"] == note["words"]
    assert other.file("save", what="path") == path
    assert other.file("save", what="targets") == targets


@pytest.mark.parametrize(
    "message",
    [
        {"type": "open", "name": "a.json", "text": "{"},
        {"type": "open", "name": "a.json", "text": 7},
        {"type": "open", "name": "a.csv", "text": "0,0\n0,5\n0,90\n"},
        {"type": "open", "name": "a\nb", "text": "0,0\n0,5\n"},
        {
            "type": "open",
            "name": "a.json",
            "text": '[{"limb": "head"}]',
        },
        {"type": "path", "points": [[0, 0]]},
        {"type": "path", "points": [[0, 0], [0, float("nan")]]},
        {"type": "path", "points": [[0, 0, 0], [0, 1, 0]]},
        {"type": "path", "points": [[0, i] for i in range(4001)]},
        {"type": "ready_made", "name": "star"},
        {"type": "add", "kind": "tail", "place": [0, 0, 0]},
        {"type": "add", "kind": "head", "place": [0, 0]},
        {"type": "move", "id": "target-99", "place": [0, 1, 0], "done": True},
        {"type": "move", "id": "target-1", "place": [0, 1, 0]},
        {"type": "set", "id": "target-1", "when": "never", "done": True},
        {"type": "set", "id": "target-1", "hold": -1, "done": True},
        {"type": "set", "id": "target-1", "radius": 1, "done": True},
        {"type": "set", "id": "bar-2", "when": "end", "done": True},
        {"type": "remove", "id": None},
        {"type": "smooth", "on": 1},
        {"type": "method", "name": "magic"},
        {"type": "save", "what": "/etc/passwd"},
        {"type": "export", "format": "exe"},
        {"type": "refine", "version": -1},
        {"type": "fly"},
    ],
)
def test_what_is_wrong_gets_a_sentence_and_changes_nothing(
    tab: Tab, message: dict[str, Any]
) -> None:
    tab.send("ready_made", name="reaches")
    told, before = len(tab.told), tab.file("save", what="targets")
    with pytest.raises(MgjaxError, match=", expected "):
        tab.session.receive(message)
    assert len(tab.told) == told + 1
    assert tab.file("save", what="targets") == before
    assert tab.send("undo")["items"] == []


def test_toggles_read_the_stroke_again(tab: Tab) -> None:
    stroke = [[0.0, 0.02 * i] for i in range(100)] + [[0.02 * i, 2.0] for i in range(100)]
    curved = len(tab.send("path", points=stroke)["lines"][0]["points"])
    cornered = tab.send("smooth", on=False)
    assert not cornered["smooth"]
    corner = np.linalg.norm(cornered["lines"][0]["points"] - [0, 0, 2], axis=1).min()
    assert corner < 0.06
    closed = tab.send("closed", on=True)
    assert closed["closed"]
    assert len(closed["lines"][0]["points"]) > curved
    assert tab.send("method", name="beam")["method"] == "beam"
    assert tab.send("clear")["lines"] == []


def test_it_is_saved_as_a_page_that_plays_elsewhere(tab: Tab) -> None:
    with pytest.raises(MgjaxError, match="no walk yet"):
        tab.send("export", format="html")
    tab.send("ready_made", name="reaches")
    page = tab.file("export", format="html")
    assert page.startswith("<!doctype html>")
    assert tab.told[-1]["name"] == "walk.html"
