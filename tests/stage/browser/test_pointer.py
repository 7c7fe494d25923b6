"""Mouse and touch: turning, shifting, zooming, drawing on the floor, moving things."""

import numpy as np
import pytest

from mgjax.stage.show.types import Thing

from .shows import actor, show_of

CAMERA = """() => {
  const { yaw, pitch, distance, target } = mgjax.stage.camera;
  return { yaw, pitch, distance, target: [...target] };
}"""
PUT = """place => mgjax.stage.put('things', {
  id: 'target', shape: 'sphere', place, drag: 'space' })"""
AFRESH = """() => {
  const { stage } = mgjax;
  Object.values(heard).forEach((list) => { list.length = 0; });
  stage.tool = 'look';
  stage.setShow({ things: bench.show.things.map((thing) => ({ ...thing })) });
  Object.assign(stage.camera, { yaw: 0.6, pitch: 0.26, distance: 5, target: [0, 0.8, 0] });
  stage.snapshot();
}"""
LISTEN = """() => {
  window.heard = { click: [], floor: [], thing: [] };
  mgjax.stage.onClick((event) => heard.click.push(event));
  mgjax.stage.onFloorDrag((event) => heard.floor.push(event));
  mgjax.stage.onThingDrag((event) => heard.thing.push(event));
}"""


def drag(page, start, ways, *, button="left", modifier=None):
    if modifier:
        page.keyboard.down(modifier)
    page.mouse.move(*start)
    page.mouse.down(button=button)
    for way in ways:
        page.mouse.move(*way)
    page.mouse.up(button=button)
    if modifier:
        page.keyboard.up(modifier)


@pytest.fixture(scope="module")
def tab(shared_bench):
    target = Thing(id="target", shape="sphere", place=(0, 1, 0), radius=0.1, drag="space")
    post = Thing(
        id="post", shape="cylinder", place=(1.2, 0, -0.8), end=(1.2, 1, -0.8), radius=0.15,
        drag="floor",
    )  # fmt: skip
    tab = shared_bench(show_of(things=[target, post]))
    tab.evaluate(LISTEN)
    return tab


@pytest.fixture
def page(tab):
    tab.mouse.move(5, 5)
    tab.evaluate(AFRESH)
    return tab


def at(page, place):
    """Pixels of the page (the canvas begins at its corner)."""
    return page.evaluate("place => mgjax.stage.project(place)", list(place))


def test_left_turns_right_turns_shift_left_shifts_wheel_zooms(page):
    before = page.evaluate(CAMERA)
    drag(page, (500, 200), [(540, 210)])
    turned = page.evaluate(CAMERA)
    assert turned["yaw"] < before["yaw"]
    assert turned["pitch"] > before["pitch"]
    assert turned["target"] == before["target"]
    drag(page, (500, 200), [(460, 200)], button="right")
    assert page.evaluate(CAMERA)["yaw"] > turned["yaw"]
    drag(page, (500, 200), [(520, 180)], modifier="Shift")
    shifted = page.evaluate(CAMERA)
    assert shifted["target"] != turned["target"]
    assert shifted["yaw"] == pytest.approx(before["yaw"])
    page.mouse.wheel(0, -100)
    page.wait_for_function("d => mgjax.stage.camera.distance < d", arg=shifted["distance"])
    assert page.evaluate("heard.click.length") == 0


def test_a_click_tells_what_is_there(page):
    page.mouse.click(*at(page, (0, 0, 1.5)))
    page.mouse.click(*at(page, (1.2, 0.5, -0.8)))
    floor, post = page.evaluate("heard.click")
    np.testing.assert_allclose(floor["floor"], (0, 0, 1.5), atol=0.02)
    assert floor["body"] is None
    assert floor["thing"] is None
    assert post["thing"] == "post"


def test_drawing_arrives_whole(page):
    page.evaluate("mgjax.stage.tool = 'draw'")
    before = page.evaluate(CAMERA)
    turns = np.linspace(0, 2 * np.pi, 40)
    path = [(1.6 * np.cos(t) - 1, 0, 0.8 * np.sin(t) - 1.5) for t in turns]
    pixels = [at(page, place) for place in path]
    drag(page, pixels[0], pixels[1:])
    events = page.evaluate("heard.floor")
    assert [event["phase"] for event in events] == ["start", *["move"] * 39, "end"]
    drawn = [event["point"] for event in events[:-1]]
    np.testing.assert_allclose(drawn, path, atol=0.02)
    assert page.evaluate(CAMERA) == before


def test_a_post_is_moved_over_the_floor(page):
    drag(page, at(page, (1.2, 0.0, -0.8)), [at(page, (0.5, 0, 1.2)), at(page, (-0.5, 0, 1.5))])
    events = page.evaluate("heard.thing")
    assert [event["phase"] for event in events] == ["start", "move", "move", "end"]
    assert {event["id"] for event in events} == {"post"}
    np.testing.assert_allclose(events[-1]["place"], (-0.5, 0, 1.5), atol=0.05)
    np.testing.assert_allclose(events[-1]["end"], (-0.5, 1, 1.5), atol=0.05)


def test_a_target_is_moved_across_the_camera(page):
    start = at(page, (0, 1, 0))
    drag(page, start, [(start[0] + 40, start[1] - 20)])
    event = page.evaluate("heard.thing.at(-1)")
    moved_to = at(page, event["place"])
    np.testing.assert_allclose(moved_to, (start[0] + 40, start[1] - 20), atol=0.5)
    arm = page.evaluate("[Math.sin(mgjax.stage.camera.yaw), Math.cos(mgjax.stage.camera.yaw)]")
    across = np.array(event["place"]) - (0, 1, 0)
    pitch = page.evaluate("mgjax.stage.camera.pitch")
    along = np.array([arm[0] * np.cos(pitch), np.sin(pitch), arm[1] * np.cos(pitch)])
    assert abs(across @ along) < 1e-6


def test_a_handle_moves_along_its_axis(page):
    start = at(page, (0, 1, 0))
    page.mouse.move(*start)
    upper = at(page, (0, 1.35, 0))
    page.mouse.move(*upper)
    drag(page, upper, [(upper[0] + 3, upper[1] - 25), (upper[0] + 6, upper[1] - 50)])
    place = page.evaluate("heard.thing.at(-1).place")
    assert place[0] == pytest.approx(0, abs=1e-9)
    assert place[2] == pytest.approx(0, abs=1e-9)
    assert place[1] > 1.1


def test_what_is_held_stays_in_the_hand(page):
    start = at(page, (0, 1, 0))
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(start[0] + 30, start[1])
    held = page.evaluate("[...mgjax.stage.scene.things.get('target').place]")
    page.evaluate(PUT, [9, 9, 9])
    assert page.evaluate("[...mgjax.stage.scene.things.get('target').place]") == held
    page.mouse.up()
    page.evaluate(PUT, [2, 1, 0])
    assert page.evaluate("[...mgjax.stage.scene.things.get('target').place]") == [2, 1, 0]


def test_the_camera_follows_and_keeps_what_was_turned(bench):
    page = bench(show_of(actor("walk"), seconds=10.0))
    page.evaluate(
        "Object.assign(mgjax.stage.camera, { yaw: 1.1, distance: 3 }); mgjax.stage.follow = 'a'"
    )
    page.evaluate("mgjax.player.seek(4)")
    page.wait_for_function(
        """() => {
          const { root } = mgjax.stage.scene.actors.get('a').pose;
          const [x, , z] = mgjax.stage.camera.target;
          return Math.hypot(root[0] - x, root[2] - z) < 0.3 && Math.hypot(root[0], root[2]) > 1;
        }"""
    )
    assert page.evaluate("[mgjax.stage.camera.yaw, mgjax.stage.camera.distance]") == [1.1, 3]


def test_two_fingers_zoom(page):
    before = page.evaluate(CAMERA)
    page.evaluate(
        """() => {
          const fire = (type, id, x) => mgjax.stage.canvas.dispatchEvent(new PointerEvent(type, {
            pointerId: id, pointerType: 'touch', clientX: x, clientY: 200, bubbles: true }));
          mgjax.stage.canvas.setPointerCapture = () => {};
          fire('pointerdown', 1, 280);
          fire('pointerdown', 2, 320);
          fire('pointermove', 2, 400);
          fire('pointerup', 1, 280);
          fire('pointerup', 2, 400);
        }"""
    )
    after = page.evaluate(CAMERA)
    assert after["distance"] == pytest.approx(before["distance"] / 3, rel=1e-6)
    assert after["yaw"] == before["yaw"]
    assert page.evaluate("heard.click.length") == 0
