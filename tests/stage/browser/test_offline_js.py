"""A show in a page of its own: there while it is in view, and as it was left when it comes back."""

import pytest

from mgjax.stage.show.types import Bar

from .shows import actor, show_of

FILL = """async options => {
  mgjax.player.dispose();
  mgjax.stage.dispose();
  document.body.className = '';
  document.body.replaceChildren();
  window.cells = [];
  for (let i = 0; i < 3; i += 1) {
    const root = document.createElement('div');
    root.style.setProperty('--mg-height', '380px');
    root.style.marginBottom = '900px';
    document.body.append(root);
    cells.push(bench.offline.start(root, bench.bytes, options));
  }
}"""


@pytest.fixture
def page(bench):
    show = show_of(
        actor("walk", note="walker"),
        words="Walks and turns.",
        notes=[("steps", "9")],
        bars=[Bar(name="distance", value=0.4)],
    )
    page = bench(show)
    page.evaluate(FILL, {"play": False, "dark": True})
    page.wait_for_function("cells[0].stage")
    return page


def test_only_what_is_in_view_has_a_context(page):
    assert page.evaluate("cells.map((cell) => Boolean(cell.stage))") == [True, False, False]
    assert page.evaluate("document.querySelectorAll('canvas.mg-canvas').length") == 1
    page.evaluate("window.scrollTo(0, 1280)")
    page.wait_for_function("!cells[0].stage && cells[1].stage")
    assert page.evaluate("document.querySelectorAll('canvas.mg-canvas').length") == 1


def test_it_comes_back_as_it_was_left(page):
    page.evaluate(
        "cells[0].player.seek(1.5); cells[0].player.speed = 0.25; cells[0].player.loop = false"
    )
    page.evaluate("cells[0].stage.camera.yaw = 2; cells[0].stage.follow = null")
    page.evaluate("window.scrollTo(0, 1280)")
    page.wait_for_function("!cells[0].stage")
    page.evaluate("window.scrollTo(0, 0)")
    page.wait_for_function("cells[0].stage")
    got = page.evaluate(
        """() => {
          const { player, stage } = cells[0];
          const { time, playing, speed, loop } = player;
          return { time, playing, speed, loop, yaw: stage.camera.yaw, follow: stage.follow };
        }"""
    )
    expected = {"time": 1.5, "playing": False, "speed": 0.25, "loop": False, "yaw": 2}
    assert got == {**expected, "follow": None}


def test_a_walker_is_followed_and_the_words_are_there(page):
    assert page.evaluate("cells[0].stage.follow") == "a"
    said = page.locator(".mg-side").first.inner_text()
    assert "Test" in said
    assert "Walks and turns." in said
    assert page.title() == "Test"
    page.locator(".mg-side summary").first.click()
    assert "steps" in page.locator(".mg-side").first.inner_text()
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"


def test_buttons_over_the_picture(page):
    corner = page.locator(".mg-corner").first
    corner.locator('[data-name="follow"]').click()
    assert page.evaluate("cells[0].stage.follow") is None
    corner.locator('[data-name="theme"]').click()
    assert page.evaluate("cells[0].stage.dark") is False
    with page.expect_download() as saved:
        corner.locator('[data-name="picture"]').click()
    assert saved.value.suggested_filename == "Test.png"
    assert saved.value.path().read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_stop_leaves_nothing(page):
    page.evaluate("cells.forEach((cell) => cell.stop())")
    assert page.evaluate("document.querySelectorAll('canvas, .mg-player').length") == 0
    page.evaluate("window.scrollTo(0, 1280)")
    assert page.evaluate("cells.every((cell) => cell.stage === null)")
