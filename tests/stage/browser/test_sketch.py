"""The sketch application in a browser: drawing, placing, dragging, files, keyboard."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mgjax.hybrid.paths.sketch import load_sketch
from mgjax.hybrid.reaching.targets import load_targets
from mgjax.io.load import load_motion

WAIT = 120_000
THREE_FRAMES = """() => new Promise((done) => {
  let left = 3;
  const stop = mgjax.stage.onFrame(() => {
    left -= 1;
    if (left) { mgjax.stage.wake(); return; }
    stop();
    done();
  });
  mgjax.stage.wake();
})"""
"""By then the camera stands where it begins, and knows the size of the picture."""
OUTCOME = "[data-name=outcome]"
NOTES = """() => {
  mgjax.notes = [];
  mgjax.link.on('note', (note) => mgjax.notes.push(note));
}"""
LAST = "mgjax.notes[mgjax.notes.length - 1]"
SETTLED = f"mgjax.notes.length > 0 && !{LAST}.better && !{LAST}.dragged"


@pytest.fixture(scope="module")
def address(chromium: Any, view: Callable[..., str]) -> str:
    return view("sketch")


@pytest.fixture
def page(open_app: Callable[[str], Any], address: str) -> Any:
    page = open_app(address)
    page.set_viewport_size({"width": 900, "height": 540})  # the panel beside the picture
    page.evaluate(NOTES)
    page.evaluate(THREE_FRAMES)
    return page


def after(page: Any, act: Callable[[], Any]) -> dict[str, Any]:
    """Does something, and waits for the last note on what came of it; without its arrays."""
    page.evaluate("mgjax.notes.length = 0")
    act()
    page.wait_for_function(SETTLED, timeout=WAIT)
    said = page.evaluate(f"JSON.stringify({{...{LAST}, actors: null, lines: null}})")
    return json.loads(said)


def ready_made(page: Any, name: str) -> dict[str, Any]:
    return after(page, lambda: page.click(f"[data-name=ready-{name}]"))


def floor(page: Any, x: float, z: float) -> tuple[float, float]:
    """Where on the page a place of the floor is."""
    return on_page(page, [x, 0, z])


def on_page(page: Any, place: list[float]) -> tuple[float, float]:
    box = page.locator("#canvas").bounding_box()
    x, y = page.evaluate(f"mgjax.stage.project({place})")
    return box["x"] + x, box["y"] + y


def drag(page: Any, places: list[tuple[float, float]]) -> None:
    page.mouse.move(*places[0])
    page.mouse.down()
    for place in places[1:]:
        page.mouse.move(*place)
    page.mouse.up()


def downloaded(page: Any, name: str, folder: Path) -> Path:
    with page.expect_download() as waiting:
        page.click(f"[data-name={name}]")
    path = folder / waiting.value.suggested_filename
    waiting.value.save_as(path)
    return path


def test_a_drag_on_the_floor_is_walked(page: Any) -> None:
    assert "Draw on the floor" in page.text_content(OUTCOME)
    places = [floor(page, 0.3 * (i % 2) / 10, -1.5 + 0.15 * i) for i in range(21)]
    note = after(page, lambda: drag(page, places))
    assert note["words"].startswith("Follows ")
    assert page.text_content(OUTCOME) == note["words"]
    scene = page.evaluate("[...mgjax.stage.scene.lines.keys()]")
    assert set(scene) == {"path", "track"}
    assert page.evaluate("[...mgjax.stage.scene.actors.keys()]") == ["walker"]
    page.wait_for_function("mgjax.player.playing && mgjax.stage.time > 0.2", timeout=WAIT)
    track = page.evaluate("[...mgjax.stage.scene.lines.get('track').points]")
    assert abs(track[-1] - 1.5) < 0.2
    assert page.locator("[data-name=figures] dt").count() >= 5


def test_a_target_is_placed_by_a_click_and_moved_by_its_handle(page: Any) -> None:
    ready_made(page, "line")
    page.click("[data-name=tool-right-hand]")
    note = after(page, lambda: page.mouse.click(*floor(page, -0.3, 3)))
    (item,) = note["items"]
    assert item["words"].startswith("reached, ")
    page.evaluate("mgjax.player.pause()")
    place = next(t["place"] for t in note["things"] if t["id"] == item["id"])
    at = on_page(page, place)
    searched = page.evaluate("mgjax.notes.length")
    note = after(page, lambda: drag(page, [at, *((at[0], at[1] - 4 * i) for i in range(1, 6))]))
    moved = next(t["place"] for t in note["things"] if t["id"] == item["id"])
    assert searched >= 1
    assert moved[1] > place[1] + 0.02
    assert note["items"][0]["words"].startswith("reached, ")
    note = after(page, lambda: page.keyboard.press("Control+z"))
    back = next(t["place"] for t in note["things"] if t["id"] == item["id"])
    assert back == pytest.approx(place, abs=1e-6)
    note = after(page, lambda: page.keyboard.press("Delete"))
    assert note["items"] == []


def test_a_bar_and_an_obstacle_are_placed_and_set(page: Any) -> None:
    ready_made(page, "line")
    page.click("[data-name=tool-bar]")
    note = after(page, lambda: page.mouse.click(*floor(page, 0, 4)))
    assert note["items"][0]["words"].startswith("ducked under")
    page.click("[data-name=tool-obstacle]")
    note = after(page, lambda: page.mouse.click(*floor(page, 0.9, 2)))
    assert [item["kind"] for item in note["items"]] == ["obstacle", "bar"]
    note = after(page, lambda: page.locator("[data-name=radius]").fill("0.3"))
    assert note["items"][0]["radius"] == pytest.approx(0.3)
    note = after(page, lambda: page.click("[data-name=remove]"))
    assert [item["kind"] for item in note["items"]] == ["bar"]
    note = after(page, lambda: page.click("[data-name=clear]"))
    assert page.evaluate("[...mgjax.stage.scene.actors.keys()]") == ["waiting"]


def test_when_and_how_long_a_target_is_held(page: Any) -> None:
    ready_made(page, "line")
    page.click("[data-name=tool-left-hand]")
    after(page, lambda: page.mouse.click(*floor(page, 0.3, 3)))
    note = after(page, lambda: page.locator("[data-name=hold]").fill("1"))
    assert note["items"][0]["hold"] == 1
    note = after(page, lambda: page.locator("[data-name=when] label", has_text="At").click())
    assert note["items"][0]["when"] == pytest.approx(2.0)
    assert page.locator("[data-name=at-seconds]").is_visible()


def test_what_is_saved_is_what_the_command_reads_and_what_is_opened(
    page: Any, tmp_path: Path
) -> None:
    note = ready_made(page, "reaches")
    path = downloaded(page, "save-path", tmp_path)
    targets = downloaded(page, "save-targets", tmp_path)
    assert load_sketch(path).spline
    assert [target.limb for target in load_targets(targets)] == ["right_hand", "head"]
    page.locator("[data-name=export] summary").click()
    page.locator("[data-name=motion-format]").select_option("bvh")
    skeleton, motion = load_motion(downloaded(page, "motion", tmp_path))
    assert motion.num_frames == round(note["seconds"] * motion.frame_rate) + 1
    assert "root" in skeleton.names
    picture = downloaded(page, "picture", tmp_path)
    assert picture.read_bytes().startswith(b"\x89PNG")
    after(page, lambda: page.click("[data-name=clear]"))
    for name in (path, targets):
        again = after(page, lambda name=name: page.set_input_files("[data-name=open-file]", name))
    assert again["words"] == note["words"]


def test_a_bad_upload_gets_a_sentence_and_changes_nothing(page: Any, tmp_path: Path) -> None:
    ready_made(page, "line")
    bad = tmp_path / "broken.json"
    bad.write_text('{"points": [[0, 0], [0, "x"]]}')
    before = page.evaluate("mgjax.notes.length")
    page.set_input_files("[data-name=open-file]", bad)
    page.locator(OUTCOME, has_text="broken.json: got points of another form").wait_for(timeout=WAIT)
    assert page.evaluate("mgjax.notes.length") == before
    assert page.evaluate("[...mgjax.stage.scene.actors.keys()]") == ["walker"]


def test_toggles_and_the_method(page: Any) -> None:
    ready_made(page, "s-curve")
    note = after(page, lambda: page.locator("[data-name=smooth]").uncheck())
    assert not note["smooth"]
    note = after(page, lambda: page.locator("[data-name=closed]").check())
    assert note["closed"]
    note = after(page, lambda: page.locator("[data-name=search] label", has_text="Beam").click())
    assert note["method"] == "beam"


def test_two_tabs_have_drawings_of_their_own(open_app: Callable[[str], Any], address: str) -> None:
    one, two = open_app(address), open_app(address)
    for page in (one, two):
        page.evaluate(NOTES)
    ready_made(one, "circle")
    assert two.evaluate("mgjax.notes.length") == 0
    two.reload()
    two.wait_for_function("document.documentElement.dataset.ready", timeout=WAIT)
    two.evaluate(NOTES)
    assert ready_made(two, "line")["words"].startswith("Follows 6.0 m")
    assert one.evaluate("[...mgjax.stage.scene.actors.keys()]") == ["walker"]
