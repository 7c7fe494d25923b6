"""A stage lowers what it draws, draws only what changed, and leaves nothing behind."""

import base64
import io

import numpy as np
import pytest
from matplotlib.image import imread

from mgjax.stage.show.types import Line

from .shows import actor, show_of

MANY = """count => {
  const lost = [];
  for (let i = 0; i < count; i += 1) {
    const view = document.createElement('div');
    view.style.cssText = 'position: relative; width: 60px; height: 40px';
    const canvas = document.createElement('canvas');
    canvas.className = 'mg-canvas';
    view.append(canvas);
    document.getElementById('side').append(view);
    const stage = bench.createStage(canvas, {});
    stage.setShow(bench.show);
    stage.snapshot();
    stage.dispose();
    stage.dispose();
    lost.push(canvas.getContext('webgl2').isContextLost());
    view.remove();
  }
  return lost;
}"""


@pytest.fixture(scope="module")
def empty(shared_bench):
    """A page of a show in which there is nothing."""
    return shared_bench(show_of())


def picture(page, time=None):
    """[H,W,3] of the stage, 0 … 1."""
    url = page.evaluate("time => mgjax.stage.snapshot(time ?? undefined)", time)
    data = base64.b64decode(url.split(",")[1])
    return np.asarray(imread(io.BytesIO(data), format="png"))[..., :3]


@pytest.mark.parametrize(
    ("times", "level"),
    [
        ([16.0] * 200, 0),
        ([100.0] * 8, 1),
        ([100.0] * 9 + [80.0] * 8 + [70.0] * 8 + [60.0] * 8, 4),
        ([100.0] * 60, 0),
        ([100.0] * 8 + [95.0] * 8, 0),
        ([100.0] * 8 + [40.0] * 400, 1),
        ([100.0] * 8 + [16.0] * 400, 0),
        ([100.0] * 16 + [16.0] * 1200, 0),
        ([16.0, 16.0, 900.0, 16.0] * 30, 0),
    ],
)
def test_the_level_follows_the_time_between_frames(empty, times, level):
    got = empty.evaluate(
        """times => {
          const quality = bench.quality.createQuality();
          let now = 0;
          quality.frame(now, false);
          for (const time of times) quality.frame(now += time, true);
          return quality.level;
        }""",
        times,
    )
    assert got == level


def test_a_level_is_drawn_with_fewer_pixels(bench):
    page = bench(show_of(actor("duck")))
    page.evaluate("mgjax.stage.level = 0")
    page.wait_for_function("mgjax.stage.canvas.width === mgjax.stage.canvas.clientWidth")
    page.evaluate("mgjax.stage.level = 4")
    page.wait_for_function("mgjax.stage.canvas.width * 2 <= mgjax.stage.canvas.clientWidth + 1")
    assert page.evaluate("mgjax.stage.stats().scale") == 0.5


def test_a_picture_shows_body_and_shadow_whatever_the_level(bench):
    page = bench(show_of(actor("stance", colour="orange")))
    page.evaluate("mgjax.stage.level = 4; mgjax.stage.frameOn('a')")
    image = picture(page, 1.0)
    assert image.shape[1] == page.evaluate("mgjax.stage.canvas.clientWidth")
    orange = (image[..., 0] > 0.5) & (image[..., 2] < 0.35 * image[..., 0])
    assert 0.02 < orange.mean() < 0.5
    bare = page.evaluate("mgjax.stage.clear('actors')") or picture(page)
    darker = bare.sum(axis=-1) - image.sum(axis=-1) > 0.3
    assert (darker & ~orange).mean() > 0.002


def test_nothing_is_drawn_while_nothing_changes(bench):
    page = bench(show_of(actor("duck")))
    page.evaluate(
        """async () => {
          window.count = 0;
          mgjax.stage.onFrame(() => { window.count += 1; });
          const frames = (n) => new Promise((done) => {
            const next = (left) => (left ? requestAnimationFrame(() => next(left - 1)) : done());
            next(n);
          });
          await frames(3);
          window.count = 0;
          await frames(5);
          window.idle = window.count;
          mgjax.stage.time = 1;
          await frames(3);
          window.once = window.count;
        }"""
    )
    assert page.evaluate("[idle, once]") == [0, 1]


def test_many_stages_leave_no_context(bench):
    page = bench(show_of(actor("duck")))
    assert all(page.evaluate(MANY, 20))
    assert page.evaluate("mgjax.stage.snapshot().length") > 1000


def test_a_lost_context_comes_back(bench):
    page = bench(show_of(actor("duck"), lines=[Line(id="l", points=np.zeros((2, 3), np.float32))]))
    before = picture(page, 1.0)
    page.evaluate(
        """() => {
          const { canvas } = mgjax.stage;
          window.seen = [];
          for (const name of ['webglcontextlost', 'webglcontextrestored']) {
            canvas.addEventListener(name, () => seen.push(name));
          }
          window.more = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
          more.loseContext();
        }"""
    )
    page.wait_for_function("seen.length === 1")
    assert page.evaluate("mgjax.stage.snapshot()") is None
    page.evaluate("more.restoreContext()")
    page.wait_for_function("seen.length === 2")
    np.testing.assert_allclose(picture(page, 1.0), before, atol=0.02)


def test_a_hidden_stage_draws_when_it_is_shown(bench):
    page = bench(show_of(actor("duck")))
    page.evaluate("document.getElementById('view').hidden = true; mgjax.stage.time = 1")
    assert page.evaluate("mgjax.stage.snapshot()") is None
    page.evaluate(
        """() => {
          window.count = 0;
          mgjax.stage.onFrame(() => { window.count += 1; });
          document.getElementById('view').hidden = false;
        }"""
    )
    page.wait_for_function("window.count > 0")


def test_dark_is_darker(empty):
    light = picture(empty).mean()
    empty.evaluate("mgjax.stage.dark = true")
    assert picture(empty).mean() < light - 0.4


def test_a_ghost_is_one_surface_through_which_one_sees(bench):
    page = bench(show_of(actor("stance", look="ghost", colour="blue")))
    page.evaluate("mgjax.stage.frameOn('a')")
    ghost = picture(page, 1.0)
    page.evaluate("mgjax.stage.clear('actors')")
    empty = picture(page, 1.0)
    changed = np.abs(ghost - empty).sum(axis=-1) > 0.1
    assert 0.02 < changed.mean() < 0.5
    shares = (empty - ghost)[changed][:, 0] / empty[changed][:, 0]
    assert np.quantile(shares, 0.95) < 0.85
