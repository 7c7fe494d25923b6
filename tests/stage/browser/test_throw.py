"""The throw application in a browser: clicks, panels, replays, two tabs, and the end of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from mgjax.io.load import load_motion

WAIT = 240_000
"""ms. A first throw may wait for programs that are compiled beside other work."""
BODY = """() => {
  const { stage } = mgjax;
  const actor = stage.scene.actors.get('character0');
  if (!actor || !actor.track.pieces.length) return null;
  const [x, , z] = actor.track.smoothRoot(stage.time, 0.1);
  return stage.project([x, 1.2, z]);
}"""
OUTCOME = "[data-name=outcome]"


@pytest.fixture(scope="module")
def address(chromium: Any, view: Callable[..., str]) -> str:
    return view("throw")


@pytest.fixture
def page(open_app: Callable[[str], Any], address: str) -> Any:
    page = open_app(address)
    page.wait_for_function(BODY, timeout=WAIT)
    return page


def click_on_the_body(page: Any) -> None:
    x, y = page.evaluate(BODY)
    page.locator("#canvas").click(position={"x": x, "y": y})


def throw(page: Any) -> str:
    """Throws a ball, waits until it is over, and gives the sentence on it."""
    page.evaluate(
        """() => {
          mgjax.answers = [];
          mgjax.link.on('note', (note) => note.event === 'answer' && mgjax.answers.push(note));
        }"""
    )
    click_on_the_body(page)
    page.wait_for_function("mgjax.answers.length > 0", timeout=WAIT)
    return page.text_content(OUTCOME)


def test_a_click_on_the_body_throws_a_ball_and_says_what_came_of_it(page: Any):
    assert "Click on the character" in page.text_content(OUTCOME)
    words = throw(page)
    assert any(each in words for each in ("Avoided by", "Hit on", "Passed", "Hit,"))
    assert page.locator("[data-name=figures] dt").count() > 0
    assert page.evaluate("[...mgjax.stage.scene.balls.keys()].length") >= 1


def test_the_character_plays_on_and_the_picture_with_it(page: Any):
    before = page.evaluate("mgjax.stage.time")
    page.wait_for_function(f"mgjax.stage.time > {before} + 1", timeout=WAIT)
    # There are frames for what is shown, sooner or later on a machine that is busy.
    page.wait_for_function(
        """() => {
          const actor = mgjax.stage.scene.actors.get('character0');
          return actor.track.end >= mgjax.stage.time;
        }""",
        timeout=WAIT,
    )


def test_replay_ghosts_and_back_to_live(page: Any):
    throw(page)
    page.click("[data-name=ghosts]")
    page.wait_for_function("!mgjax.player.live && mgjax.player.playing", timeout=WAIT)
    assert page.evaluate("mgjax.player.speed") == 0.25
    looks = page.evaluate("[...mgjax.stage.scene.actors.values()].map(({ look }) => look)")
    assert looks.count("solid") == 1
    page.keyboard.press("Space")
    assert not page.evaluate("mgjax.player.playing")
    page.click("[data-name=back-to-live]")
    page.wait_for_function("mgjax.player.live && mgjax.stage.scene.actors.size === 1", timeout=WAIT)
    now = page.evaluate("mgjax.stage.time")
    page.wait_for_function(f"mgjax.stage.time > {now} + 0.3", timeout=WAIT)


def test_sliders_change_the_ball(page: Any):
    page.locator("[data-name=radius]").fill("0.3")
    throw(page)
    radii = page.evaluate("[...mgjax.stage.scene.balls.values()].map(({ radius }) => radius)")
    assert radii[-1] == pytest.approx(0.3)


def test_a_switch_for_parries_is_of_one_character(page: Any):
    page.evaluate(
        """() => {
          const { link } = mgjax, send = link.send;
          mgjax.sent = [];
          link.send = (message) => { mgjax.sent.push(message); send.call(link, message); };
        }"""
    )
    page.locator("[data-name=search] summary").click()
    page.locator("[data-name=second]").check()
    page.wait_for_function("mgjax.stage.scene.actors.size === 2", timeout=WAIT)
    page.locator("[data-name=settings-of]").locator("label", has_text="B").click()
    page.locator("[data-name=parry]").check()
    sent = page.evaluate("mgjax.sent.filter((message) => 'parry' in message)")
    assert sent == [{"type": "settings", "lane": 1, "parry": True}]
    page.locator("[data-name=settings-of]").locator("label", has_text="A").click()
    assert not page.locator("[data-name=parry]").is_checked()
    words = throw(page)
    assert any(each in words for each in ("Avoided by", "Hit", "Passed", "Parried with"))
    page.locator("[data-name=second]").uncheck()
    page.wait_for_function("mgjax.stage.scene.actors.size === 1", timeout=WAIT)


def test_pause_and_go_on(page: Any):
    page.locator("label", has_text="Pause").click()
    page.wait_for_function(
        """async () => {
          const before = mgjax.stage.time;
          await new Promise((done) => setTimeout(done, 400));
          return mgjax.stage.time === before;
        }""",
        timeout=WAIT,
    )
    page.locator("label", has_text="1×").click()
    before = page.evaluate("mgjax.stage.time")
    page.wait_for_function(f"mgjax.stage.time > {before} + 0.3", timeout=WAIT)


def test_two_characters(page: Any):
    page.locator("[data-name=search] summary").click()
    page.locator("[data-name=second]").check()
    page.wait_for_function("mgjax.stage.scene.actors.size === 2", timeout=WAIT)
    throw(page)
    page.wait_for_function("mgjax.stage.scene.balls.size >= 2", timeout=WAIT)
    page.locator("[data-name=second]").uncheck()
    page.wait_for_function("mgjax.stage.scene.actors.size === 1", timeout=WAIT)


def test_what_is_refused_is_said(page: Any):
    page.click("[data-name=replay]")
    page.wait_for_function(
        f"document.querySelector('{OUTCOME}').textContent.includes('no throw that is over')",
        timeout=WAIT,
    )


def test_two_tabs_and_a_reload_in_the_middle(open_app: Callable[[str], Any], address: str):
    one, two = open_app(address), open_app(address)
    for page in (one, two):
        page.wait_for_function(BODY, timeout=WAIT)
    click_on_the_body(one)
    one.reload()
    one.wait_for_function("document.documentElement.dataset.ready", timeout=WAIT)
    one.wait_for_function(BODY, timeout=WAIT)
    throw(one)
    assert two.evaluate("mgjax.stage.scene.balls.size") == 0, "each tab has a ball of its own"
    throw(two)
    two.close()
    throw(one)


def test_the_page_keeps_to_its_policy(chromium: Any, address: str):
    context = chromium.new_context(viewport={"width": 640, "height": 400})
    page = context.new_page()
    troubles: list[str] = []
    page.on("console", lambda said: troubles.append(said.text) if said.type == "error" else None)
    page.on("pageerror", lambda error: troubles.append(str(error)))
    page.goto(address)
    page.locator("html[data-ready=throw]").wait_for(timeout=WAIT)
    page.locator("[data-name=replay]").click()
    page.locator(OUTCOME, has_text="no throw that is over").wait_for(timeout=WAIT)
    context.close()
    assert not troubles


def test_what_is_seen_is_saved(page: Any, tmp_path: Path):
    throw(page)
    page.locator("[data-name=export] summary").click()
    with page.expect_download(timeout=WAIT) as got:
        page.click("[data-name=picture]")
    got.value.save_as(tmp_path / "picture.png")
    with Image.open(tmp_path / "picture.png") as picture:
        assert picture.size[0] > 100
    page.click("[data-name=film]")
    assert "replay something first" in page.text_content("[data-name=saving]")
    with page.expect_download(timeout=WAIT) as got:
        page.locator("[data-name=export] button[data-name=motion]").click()
    got.value.save_as(tmp_path / "motion.bvh")
    skeleton, motion = load_motion(tmp_path / "motion.bvh")
    assert motion.num_frames > 10
    assert skeleton.num_joints > 20
    with page.expect_download(timeout=WAIT) as got:
        page.click("[data-name=page]")
    got.value.save_as(tmp_path / "throw.html")
    assert "mgjax-payload" in (tmp_path / "throw.html").read_text()
