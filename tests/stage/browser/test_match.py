"""The match in a browser: clicks, buttons, a clip as the user, another pitch, files."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from typing import Any

import pytest

WAIT = 120_000
LISTEN = """() => {
  mgjax.notes = {};
  mgjax.link.on('note', (note) => { mgjax.notes[note.what] = note; });
}"""
AT = """(name) => {
  const { stage } = mgjax;
  const [x, , z] = stage.scene.actors.get(name).track.smoothRoot(stage.time, 0.1);
  return stage.project([x, 1.0, z]);
}"""
PASS = """([by, to]) => mgjax.notes.played.passes.some((made) => (
  made.by === by && made.to === to && made.start > mgjax.since))"""


@pytest.fixture(scope="module")
def address(chromium: Any, view: Callable[..., str]) -> str:
    return view("match")


@pytest.fixture
def page(open_app: Callable[[str], Any], address: str) -> Any:
    """A match that is being played."""
    page = open_app(address)
    page.evaluate(LISTEN)
    page.wait_for_function(
        "mgjax.notes.wishes && mgjax.notes.played && mgjax.player.time > 0.5", timeout=WAIT
    )
    page.evaluate("mgjax.since = mgjax.player.time")
    return page


def others(page: Any) -> tuple[str, str]:
    """Who passes next, and somebody else."""
    holder = page.evaluate("mgjax.notes.wishes.holder")
    return holder, next(name for name in ("Ana", "Ben", "Cem") if name != holder)


def test_a_click_on_a_player_sends_the_ball_there(page: Any):
    holder, wanted = others(page)
    x, y = page.evaluate(AT, wanted)
    page.locator("#canvas").click(position={"x": x, "y": y})
    page.wait_for_function(PASS, arg=[holder, wanted], timeout=WAIT)
    page.wait_for_function(
        f"document.querySelector('[data-name=last-pass]').textContent.startsWith("
        f"'{holder} to {wanted}: ')",
        timeout=WAIT,
    )
    assert "arrives within 0." in page.text_content("[data-name=last-pass]")
    assert page.evaluate("mgjax.stage.scene.things.get('receiver').shape") == "ring"


def test_buttons_say_how(page: Any):
    page.locator("[data-name=kind] label", has_text="attack").click()
    page.locator("[data-name=bounces] label", has_text="2").click()
    page.wait_for_function("mgjax.notes.wishes.bounces === '2'", timeout=WAIT)
    holder, wanted = others(page)
    page.click(f"[data-name=pick-{wanted.lower()}]")
    page.wait_for_function(PASS, arg=[holder, wanted], timeout=WAIT)
    made = page.evaluate(
        "([by, to]) => mgjax.notes.played.passes.findLast((p) => p.by === by && p.to === to)",
        [holder, wanted],
    )
    assert (made["kind"], made["bounces"]) == ("attack", 2)
    rows = page.evaluate("[...document.querySelectorAll('[data-row]')].map((r) => r.dataset.row)")
    assert rows[0] == "ball"
    assert {holder, wanted} <= set(rows)


def test_it_waits_for_a_click(page: Any):
    page.locator("[data-name=on]").uncheck()
    page.wait_for_function(
        "document.querySelector('[data-name=now]').textContent.includes('waits. Click who')",
        timeout=WAIT,
    )
    holder, wanted = others(page)
    page.evaluate("mgjax.since = mgjax.player.time")
    page.click(f"[data-name=pick-{wanted.lower()}]")
    page.wait_for_function(PASS, arg=[holder, wanted], timeout=WAIT)


def test_what_cannot_be_is_said(page: Any):
    holder, _ = others(page)
    page.locator("[data-name=on]").uncheck()
    page.wait_for_function("mgjax.notes.wishes.waits", timeout=WAIT)
    holder = page.evaluate("mgjax.notes.wishes.holder")
    page.click(f"[data-name=pick-{holder.lower()}]")
    page.wait_for_function(
        "document.querySelector('[data-name=trouble-here]').textContent.includes('has the ball')",
        timeout=WAIT,
    )


def test_a_clip_kicks_for_the_user(page: Any):
    page.select_option("[data-name=clip]", "kick_pass_right")
    page.click("[data-name=replay]")
    page.wait_for_function(
        "document.querySelector('[data-name=user]').textContent.includes('matched kick')",
        timeout=WAIT,
    )
    assert page.text_content("[data-name=user]").startswith("Right foot, ")
    actors = page.evaluate("[...mgjax.stage.scene.actors.keys()]")
    assert {"user", "matched"} <= set(actors)
    page.wait_for_function(
        "mgjax.notes.played.passes.some(({ words }) => words.includes('kicked as you did'))",
        timeout=WAIT,
    )


def test_six_players_with_and_without_a_net(page: Any):
    page.locator("[data-name=count] label", has_text="6").click()
    page.wait_for_function("mgjax.stage.scene.actors.size === 6", timeout=WAIT)
    page.wait_for_function("mgjax.notes.played.passes.length > 1", timeout=WAIT)
    page.locator("[data-name=net]").uncheck()
    page.wait_for_function("!mgjax.stage.scene.things.has('net')", timeout=WAIT)
    assert page.locator("[data-name=players] button").count() == 6


def test_the_sensor_is_switched_on_and_off(page: Any):
    page.locator("[data-name=sensor]").check()
    page.wait_for_function(
        "/packet came on|expected a free port/.test(document.body.textContent)", timeout=WAIT
    )
    page.locator("[data-name=sensor]").uncheck()
    page.wait_for_function(
        "document.querySelector('[data-name=user]').textContent === 'The sensor is off'",
        timeout=WAIT,
    )


def test_files_are_saved(page: Any, tmp_path: Any):
    page.wait_for_function("mgjax.notes.played.passes.length > 1", timeout=WAIT)
    with page.expect_download(timeout=WAIT) as saved:
        page.click("[data-name=save-zip]")
    saved.value.save_as(tmp_path / "match.zip")
    with zipfile.ZipFile(tmp_path / "match.zip") as archive:
        assert json.loads(archive.read("timeline.json"))["passes_missed"] == 0
    with page.expect_download(timeout=WAIT) as saved:
        page.click("[data-name=save-html]")
    saved.value.save_as(tmp_path / "match.html")
    assert (tmp_path / "match.html").stat().st_size > 100_000


def test_a_reload_begins_anew(page: Any):
    page.wait_for_function("mgjax.player.time > 2", timeout=WAIT)
    page.reload()
    page.wait_for_function("globalThis.mgjax?.player.time > 0.5", timeout=WAIT)
    assert page.evaluate("mgjax.stage.scene.actors.size") == 3


def test_pausing_and_looking_back(page: Any):
    page.wait_for_function("mgjax.player.time > 3", timeout=WAIT)
    page.click("[data-name=play]")
    page.wait_for_function("!mgjax.player.playing", timeout=WAIT)
    known = page.evaluate("mgjax.player.seconds")
    page.evaluate("mgjax.player.seek(1.0)")
    page.click("[data-name=play]")
    page.wait_for_function("mgjax.player.time > 1.5", timeout=WAIT)
    # A pass that was being planned when the match was paused may still arrive; none is lost.
    assert page.evaluate("mgjax.player.seconds") >= known
