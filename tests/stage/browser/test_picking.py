"""What lies under a pixel."""

import numpy as np

from mgjax import global_positions
from mgjax.stage.show.types import Thing

from .shows import actor, clips, moved, show_of


def project(page, place):
    return page.evaluate("place => mgjax.stage.project(place)", [float(x) for x in place])


def test_the_floor_under_a_pixel_is_what_is_drawn_there(bench):
    page = bench(show_of(actor("stance")))
    for place in ((0, 0, 0), (1.5, 0, -2.0), (-3, 0, 0.25)):
        got = page.evaluate("([x, y]) => mgjax.stage.pickFloor(x, y)", project(page, place))
        np.testing.assert_allclose(got, place, atol=1e-5)
    page.evaluate("mgjax.stage.camera.pitch = 0.1; mgjax.stage.camera.update(640, 300)")
    assert page.evaluate("mgjax.stage.pickFloor(320, 1)") is None


def test_the_body_under_a_pixel(bench):
    page = bench(show_of(actor("stance", id="near", at=(0, 1)), actor("stance", id="far")))
    page.evaluate("mgjax.stage.time = 1; mgjax.stage.camera.yaw = 0.9; mgjax.stage.frameAll()")
    clip = clips()["stance"]
    for id, at in (("near", (0, 1)), ("far", (0, 0))):
        places = global_positions(clip.skeleton, moved(clip.motion, *at))[30]
        joint = clip.skeleton.index("head")
        got = page.evaluate("([x, y]) => mgjax.stage.pickBody(x, y)", project(page, places[joint]))
        assert got["actor"] == id
        assert clip.skeleton.names[got["joint"]] == got["name"]
        assert np.linalg.norm(got["place"] - places[got["joint"]]) < 0.3
        assert np.linalg.norm(got["place"] - places[joint]) < 0.25
    assert page.evaluate("mgjax.stage.pickBody(2, 2)") is None
    page.evaluate("Object.assign(mgjax.stage.camera, { yaw: 0, pitch: 0.05 })")
    page.evaluate("mgjax.stage.frameAll()")
    middle = page.evaluate("mgjax.stage.project([0, 1, 1])")
    got = page.evaluate("([x, y]) => mgjax.stage.pickBody(x, y)", middle)
    assert got["actor"] == "near"


def test_things_under_a_pixel(bench):
    things = [
        Thing(id="ball", shape="sphere", place=(0, 1, 0), radius=0.2),
        Thing(id="bar", shape="capsule", place=(1, 1, 0), end=(2, 1, 0), radius=0.03),
        Thing(id="post", shape="cylinder", place=(-2, 0, 0), end=(-2, 1, 0), radius=0.1),
        Thing(id="ring", shape="ring", place=(0, 0, 2), radius=0.5),
        Thing(id="net", shape="net", place=(-2, 1.5, -2), end=(2, 1.5, -2)),
    ]
    page = bench(show_of(things=things))
    for id, place in {
        "ball": (0, 1, 0),
        "bar": (1.5, 1, 0),
        "post": (-2, 0.5, 0),
        "ring": (0.2, 0, 2.1),
        "net": (1, 1.3, -2),
    }.items():
        x, y = project(page, place)
        assert page.evaluate("([x, y]) => mgjax.stage.pickThing(x, y)", [x, y]) == id
    x, y = project(page, (1, 3, -2))
    assert page.evaluate("([x, y]) => mgjax.stage.pickThing(x, y)", [x, y]) is None
