"""The editor in a browser: labels by mouse and keys, the graph's picture, the coverage map."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from mgjax.clips.folder import load_clips
from mgjax.clips.labels import load_labels
from mgjax.clips.synthetic import synthetic_clips
from mgjax.io.bvh.write import save_bvh
from tests.stage.serve.test_server import Viewed

SIZE = {"width": 960, "height": 540}
RATE = 30.0
PATIENCE_MS = 120_000
STANDS_STILL = """() => {
  if (!mgjax.graph.shown.length) return false;
  const now = JSON.stringify(mgjax.graph.middleOf(mgjax.graph.shown[0]));
  const same = now === window.before;
  window.before = now;
  return same;
}"""
"""The first transition of the picture lies where it did in the frame before."""


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A folder of two clips and a file that is none, and the text of its labels."""
    folder = tmp_path_factory.mktemp("clips")
    clips, labels = synthetic_clips()
    document: dict[str, Any] = {"_about": "made here", "clips": {}}
    for clip in clips:
        if clip.name in ("duck", "sway"):
            save_bvh(folder / f"{clip.name}.bvh", clip.skeleton, clip.motion)
            document["clips"][f"{clip.name}.bvh"] = [
                {"start_s": x.start_s, "end_s": x.end_s, "kind": x.kind, "seen": n}
                for n, x in enumerate(labels[clip.name])
            ]
    (folder / "bad.bvh").write_text("HIERARCHY\nnothing\n")
    text = json.dumps(document, indent=1)
    (folder / "labels.json").write_text(text)
    return folder, text


@pytest.fixture(scope="module")
def viewed(written: tuple[Path, str]) -> Iterator[Viewed]:
    running = Viewed("edit", "--clips", written[0], "--port", 0)
    yield running
    assert running.end()[0] == 0


@pytest.fixture
def open_tab(
    chromium: Any, viewed: Viewed, written: tuple[Path, str]
) -> Iterator[Callable[[], Any]]:
    """Opens the editor with the labels as they were at first; an error on a page fails the test."""
    folder, text = written
    context = chromium.new_context(viewport=SIZE, bypass_csp=True)
    context.set_default_timeout(PATIENCE_MS)
    troubles: list[str] = []

    def hear(said: Any) -> None:
        if said.type in ("error", "warning") and "GL Driver Message" not in said.text:
            troubles.append(said.text)

    def watch(page: Any) -> None:
        page.on("pageerror", lambda error: troubles.append(f"page error: {error}"))
        page.on("console", hear)

    context.on("page", watch)
    (folder / "labels.json").write_text(text)
    opened: list[Any] = []

    def open_one() -> Any:
        page = context.new_page()
        page.goto(viewed.address)
        page.wait_for_selector("html[data-ready=edit]")
        if not opened:
            page.evaluate("mgjax.link.send({ type: 'reread' })")
            said(page, "read again")
        opened.append(page)
        return page

    yield open_one
    for page in opened:
        if not page.is_closed():
            page.evaluate("0")
    context.close()
    assert not troubles, "; ".join(troubles)


@pytest.fixture
def tab(open_tab: Callable[[], Any]) -> Any:
    return open_tab()


AT_REST = """async (selector) => {
  const look = () => {
    const box = document.querySelector(selector)?.getBoundingClientRect();
    return box ? [box.x + box.width / 2, box.y + box.height / 2] : [-1, -1];
  };
  let [before, same] = [look(), 0];
  while (same < 3) {
    await new Promise((done) => setTimeout(done, 150));
    const now = look();
    same = now[0] > 0 && now.every((each, k) => each === before[k]) ? same + 1 : 0;
    before = now;
  }
  return before;
}"""


def said(page: Any, words: str) -> None:
    """Waits until the page says so."""
    page.wait_for_function(
        "words => document.querySelector('[data-name=said]').textContent.includes(words)", arg=words
    )


def pick(page: Any, name: str) -> list[str]:
    """Picks a clip and waits until it plays; names of its labels."""
    page.click(f"[data-name='clip-{name}']")
    page.wait_for_selector(f"[data-name=timeline][data-playing='{name}']", state="attached")
    page.wait_for_selector(".ed-label")
    return page.eval_on_selector_all(".ed-label", "all => all.map((x) => x.dataset.name)")


def drag(page: Any, x: float, y: float, by: float) -> None:
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + by / 2, y)
    page.mouse.move(x + by, y)
    page.mouse.up()


def middle(page: Any, selector: str) -> tuple[float, float]:
    """Of an element that has come to rest: the timeline is drawn anew while clips are read."""
    page.wait_for_selector(selector)
    return tuple(page.evaluate(AT_REST, selector))


def pixels(page: Any, seconds: float) -> float:
    """Width of so many seconds on the timeline."""
    wide = page.locator("[data-name=lane]").bounding_box()["width"]
    return wide * seconds / page.evaluate("mgjax.player.seconds + 1 / 30")


def read(folder: Path) -> dict[str, Any]:
    clips, _ = load_clips(folder, skip_bad=True)
    return load_labels(folder / "labels.json", clips, folder)


def save(page: Any) -> None:
    page.wait_for_selector("[data-name=unsaved][data-changed=true]", state="attached")
    page.keyboard.press("s")
    # What is said of it another sentence may follow at once.
    page.wait_for_selector("[data-name=unsaved][data-changed=false]", state="attached")


def test_a_label_is_dragged_and_saved(tab: Any, written: tuple[Path, str]) -> None:
    folder, text = written
    before = read(folder)["duck.bvh"]
    first, *_ = pick(tab, "duck.bvh")
    tab.click(f"[data-name={first}]")
    x, y = middle(tab, f"[data-name={first}-stop]")
    drag(tab, x, y, pixels(tab, 0.5))
    save(tab)
    said(tab, "Saved")
    after = read(folder)["duck.bvh"]
    assert after[0].end_s == pytest.approx(before[0].end_s + 0.5, abs=1.5 / RATE)
    assert after[0].start_s == before[0].start_s
    assert after[1:] == before[1:]
    one, two = json.loads((folder / "labels.json").read_text()), json.loads(text)
    assert one["clips"]["duck.bvh"][0]["seen"] == 0
    one["clips"]["duck.bvh"][0]["end_s"] = two["clips"]["duck.bvh"][0]["end_s"]
    assert one == two


def test_a_whole_label_is_dragged_no_farther_than_its_neighbour(tab: Any, written: Any) -> None:
    before = read(written[0])["duck.bvh"]
    first, *_ = pick(tab, "duck.bvh")
    x, y = middle(tab, f"[data-name={first}]")
    drag(tab, x, y, pixels(tab, 4.0))
    said(tab, "Labels may touch, not overlap: duck is at")
    save(tab)
    after = read(written[0])["duck.bvh"]
    assert round(after[0].end_s * RATE) == round(before[1].start_s * RATE)
    length = [round(x.end_s * RATE) - round(x.start_s * RATE) for x in (before[0], after[0])]
    assert length[0] == length[1]


def test_labels_are_made_changed_deleted_and_taken_back(tab: Any, written: Any) -> None:
    folder, _ = written
    before = read(folder)["sway.bvh"]
    names = pick(tab, "sway.bvh")
    box = tab.locator("[data-name=lane]").bounding_box()
    drag(tab, box["x"] + 2, box["y"] + 20, pixels(tab, 0.4))
    tab.wait_for_function(
        "n => document.querySelectorAll('.ed-label').length === n", arg=len(names) + 1
    )
    tab.wait_for_selector(".ed-label[aria-pressed=true]")
    tab.fill("[data-name=kind]", "swerve")
    tab.keyboard.press("Enter")
    tab.locator("[data-name=direction] label", has_text="right").click()
    tab.click("[data-name=genuine]")
    tab.wait_for_selector(".ed-exercise:has-text('swerve')", state="attached")
    tab.locator(".ed-exercise").focus()
    tab.keyboard.press("ArrowRight")
    tab.keyboard.press("ArrowRight")
    save(tab)
    made = next(x for x in read(folder)["sway.bvh"] if x.kind == "swerve")
    assert (made.direction, made.genuine) == ("right", False)
    assert 2 <= round(made.start_s * RATE) <= 4
    tab.locator(".ed-exercise").focus()
    tab.keyboard.press("Delete")
    tab.wait_for_selector(".ed-exercise", state="detached")
    tab.keyboard.press("Control+z")
    tab.wait_for_selector(".ed-exercise")
    tab.keyboard.press("Control+y")
    tab.wait_for_selector(".ed-exercise", state="detached")
    save(tab)
    assert read(folder)["sway.bvh"] == before


def test_a_file_changed_by_somebody_else_is_asked_about(tab: Any, written: Any) -> None:
    folder, _ = written
    first, *_ = pick(tab, "duck.bvh")
    tab.click(f"[data-name={first}]")
    tab.click("[data-name=delete-label]")
    tab.wait_for_selector("[data-name=unsaved][data-changed=true]", state="attached")
    newer = {"clips": {"duck.bvh": [{"start_s": 3.0, "end_s": 4.0, "kind": "jump"}]}}
    (folder / "labels.json").write_text(json.dumps(newer))
    tab.keyboard.press("s")
    tab.wait_for_selector("[data-name=clash]:visible")
    assert json.loads((folder / "labels.json").read_text()) == newer
    tab.click("[data-name=reread]")
    tab.wait_for_selector("[data-name=clash]", state="hidden")
    tab.wait_for_selector(".ed-label[title^=jump]")
    assert tab.locator(".ed-label").count() == 1


def test_edits_outlive_a_reload_and_are_seen_in_another_tab(open_tab: Any) -> None:
    one = open_tab()
    names = pick(one, "duck.bvh")
    other = open_tab()
    pick(other, "duck.bvh")
    one.click(f"[data-name={names[0]}]")
    one.keyboard.press("Delete")
    for page in (one, other):
        page.wait_for_function(
            "n => document.querySelectorAll('.ed-label').length === n", arg=len(names) - 1
        )
    one.reload()
    one.wait_for_selector("html[data-ready=edit]")
    assert len(pick(one, "duck.bvh")) == len(names) - 1
    other.wait_for_selector("[data-name=unsaved][data-changed=true]", state="attached")


def test_a_bad_file_is_listed_with_what_is_wrong(tab: Any) -> None:
    tab.wait_for_selector("[data-name='clip-bad.bvh'].ed-bad")
    assert "bad.bvh" in tab.inner_text("[data-name='clip-bad.bvh'] .mg-entry-detail")
    tab.click("[data-name='clip-bad.bvh']")
    said(tab, "bad.bvh")
    pick(tab, "sway.bvh")
    assert "38 joints" in tab.inner_text("[data-name=info]")


def test_a_transition_that_is_clicked_plays_with_its_figures(tab: Any) -> None:
    pick(tab, "duck.bvh")
    tab.click("[data-name=tab-graph]")
    tab.wait_for_function(STANDS_STILL)
    x, y = tab.evaluate("mgjax.graph.middleOf(mgjax.graph.shown[0])")
    tab.mouse.click(x, y)
    said(tab, "leads to")
    tab.wait_for_function(
        "mgjax.player.playing && mgjax.player.seconds > 0.5 && mgjax.player.seconds < 1.8"
    )
    shown = tab.inner_text("[data-name=seam]")
    for word in ("distance", "planted feet slide", "before clean-up", "largest jerk"):
        assert word in shown
    before = tab.inner_text("[data-name=said]")
    tab.click("[data-name=transition-after]")
    tab.click("[data-name=transition-after]")
    tab.wait_for_function(
        "words => document.querySelector('[data-name=said]').innerText !== words", arg=before
    )


def test_the_graph_is_built_again_with_what_is_asked_for(tab: Any) -> None:
    tab.click("[data-name=tab-labels]")
    tab.click("[data-name='use-sway.bvh']")
    tab.click("[data-name=tab-graph]")
    tab.wait_for_function("!document.querySelector('[data-name=build]').disabled")
    tab.click("[data-name=build]")
    said(tab, "Graph built: 1 clips")
    tab.click("[data-name=tab-labels]")
    tab.click("[data-name='use-sway.bvh']")
    tab.click("[data-name=tab-graph]")
    tab.click("[data-name=build]")
    said(tab, "Graph built: 2 clips")


def test_a_cell_of_the_coverage_map_throws_its_ball(tab: Any) -> None:
    tab.click("[data-name=tab-coverage]")
    tab.wait_for_function("!document.querySelector('[data-name=cover]').disabled")
    tab.wait_for_function("mgjax.graph.counts.all > 0")
    tab.click("[data-name=cover]")
    said(tab, "coverage map is complete")
    tab.click("[data-name=cell-0-3]")
    said(tab, "ball 1 of 6 from ahead at 1.1 m")
    assert tab.evaluate("mgjax.stage.scene.balls.size") == 1
    tab.click("[data-name=cell-0-3]")
    said(tab, "ball 2 of 6 from ahead")
