"""The player: buttons, keys, timeline, and several of them on a page."""

import pytest

from mgjax.stage.show.types import Span

from .shows import actor, show_of

STATE = "({ time: mgjax.player.time, playing: mgjax.player.playing, speed: mgjax.player.speed })"


def control(page, name):
    return page.locator(f'[data-name="{name}"]')


@pytest.fixture(scope="module")
def tab(shared_bench):
    show = show_of(
        actor("duck"),
        spans=[Span(row="label", start=1, end=2, text="duck", colour="blue")],
        moments=[("hit", 2.5)],
    )
    tab = shared_bench(show)
    tab.evaluate("window.sought = []; mgjax.player.onSeek((time) => sought.push(time)); 0")
    return tab


@pytest.fixture
def page(tab):
    tab.evaluate(
        """() => {
          const { player } = mgjax;
          document.activeElement.blur();
          Object.assign(player, { live: false, speed: 1, loop: true });
          player.pause();
          player.seek(0);
          sought.length = 0;
        }"""
    )
    return tab


def test_play_goes_on_in_real_time_and_pause_stops(page):
    control(page, "play").click()
    page.wait_for_function("mgjax.player.time > 0.2")
    control(page, "play").click()
    assert not page.evaluate("mgjax.player.playing")
    time = page.evaluate("mgjax.player.time")
    assert page.evaluate("mgjax.stage.time") == time
    assert page.evaluate("sought") == []


def test_keys(page):
    page.mouse.move(300, 100)
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("mgjax.player.time") == pytest.approx(2 / 30)
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("mgjax.player.time") == pytest.approx(1 / 30)
    page.keyboard.press("Shift+ArrowRight")
    assert page.evaluate("mgjax.player.time") == pytest.approx(31 / 30)
    page.keyboard.press("End")
    assert page.evaluate("mgjax.player.time") == 4
    page.keyboard.press("Home")
    assert page.evaluate("mgjax.player.time") == 0
    assert page.evaluate("sought.length") == 6
    page.keyboard.press("Space")
    assert page.evaluate("mgjax.player.playing")
    page.keyboard.press("Space")
    assert not page.evaluate("mgjax.player.playing")


def test_the_slider_seeks_by_keyboard_and_mouse(page):
    scrub = control(page, "scrub")
    scrub.focus()
    page.keyboard.press("ArrowRight")
    assert page.evaluate("mgjax.player.time") == pytest.approx(1 / 30)
    box = scrub.bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert page.evaluate("mgjax.player.time") == pytest.approx(2, abs=0.1)


def test_moments_and_spans_lead_to_their_time(page):
    control(page, "moment").click()
    assert page.evaluate("mgjax.player.time") == 2.5
    page.locator(".mg-span").click(position={"x": 2, "y": 5})
    assert page.evaluate("mgjax.player.time") == pytest.approx(1.0, abs=0.05)
    assert page.locator(".mg-span").inner_text() == "duck"
    assert page.locator(".mg-names").inner_text().strip() == "label"


def test_speed_and_loop(page):
    control(page, "speed").select_option("0.1")
    assert page.evaluate("mgjax.player.speed") == 0.1
    page.evaluate("mgjax.player.speed = 99")
    assert page.evaluate("mgjax.player.speed") == 4
    assert control(page, "speed").input_value() == "4"
    page.evaluate("mgjax.player.seek(3.9); mgjax.player.play()")
    page.wait_for_function("mgjax.player.time < 3")
    control(page, "loop").click()
    assert control(page, "loop").get_attribute("aria-pressed") == "false"
    page.evaluate("mgjax.player.seek(3.9)")
    page.wait_for_function("!mgjax.player.playing")
    assert page.evaluate("mgjax.player.time") == 4


def test_a_live_player_leaves_time_to_the_application(page):
    page.evaluate("mgjax.player.live = true; mgjax.player.play(); mgjax.stage.time = 1.5")
    assert control(page, "play").is_hidden()
    assert not page.evaluate("mgjax.player.playing")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("mgjax.stage.time") == 1.5


SECOND = """() => {
  const [view, bar] = [document.createElement('div'), document.createElement('div')];
  view.style.cssText = 'position: relative; width: 300px; height: 150px';
  const canvas = document.createElement('canvas');
  canvas.className = 'mg-canvas';
  view.append(canvas);
  document.getElementById('side').append(view, bar);
  const stage = bench.createStage(canvas, {});
  const player = bench.createPlayer(stage, bar);
  stage.setShow(bench.show);
  player.setShow(bench.show);
  window.other = { stage, player };
}"""


def test_keys_go_to_the_player_that_is_meant(bench):
    page = bench(show_of(actor("duck")), width=1000)
    page.evaluate(SECOND)
    times = "[mgjax.player.time > 0, other.player.time > 0]"
    page.keyboard.press("ArrowRight")
    assert page.evaluate(times) == [False, False]
    page.mouse.move(300, 100)
    page.keyboard.press("ArrowRight")
    assert page.evaluate(times) == [True, False]
    page.locator('#side [data-name="scrub"]').focus()
    page.keyboard.press("ArrowRight")
    assert page.evaluate(times) == [True, True]
    page.evaluate("document.activeElement.blur(); other.player.dispose(); other.stage.dispose()")
    page.mouse.move(850, 300)
    page.keyboard.press("Home")
    assert page.evaluate("mgjax.player.time") == 0


def test_keys_of_a_text_field_are_left_alone(page):
    page.evaluate(
        """() => {
          const field = document.createElement('input');
          field.id = 'field';
          document.getElementById('side').append(field);
        }"""
    )
    page.locator("#field").fill("a")
    page.locator("#field").press("Space")
    page.locator("#field").press("ArrowRight")
    assert page.locator("#field").input_value() == "a "
    assert page.evaluate("mgjax.player.time") == 0
