import base64
import html
import io
import itertools
import math
import re

import numpy as np
import pytest
from PIL import Image

from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.body.roles import find_role
from mgjax.core.motion import Motion, cut
from mgjax.graph.walk import random_walk
from mgjax.stage.html import page_html
from mgjax.stage.moving import RATE, SIZE, moving_png
from mgjax.stage.notebook import mime_bundle, sentence
from mgjax.stage.show.motion import motion_show
from mgjax.stage.show.of import show_of
from mgjax.stage.show.types import Ball, Line, Show
from mgjax.stage.still import skinned, still_png
from tests.conftest import make_motion, make_skeleton


@pytest.fixture(scope="module")
def clip():
    return next(clip for clip in synthetic_clips()[0] if clip.name == "walk")


def test_a_motion_plays_in_its_cell(clip):
    motion = cut(clip.motion, 0, 61)
    bundle = motion._repr_mimebundle_()
    assert set(bundle) == {"text/plain", "text/html", "image/png"}
    (page,) = re.findall(r'<iframe srcdoc="([^"]*)"', bundle["text/html"])
    assert html.unescape(page) == page_html(motion_show(clip.skeleton, motion))
    assert 'sandbox="allow-scripts"' in bundle["text/html"]
    assert bundle["text/plain"] in bundle["text/html"]
    assert motion._repr_html_() == bundle["text/html"]


def test_the_picture_shows_something(clip):
    data = base64.b64decode(mime_bundle(clip)["image/png"])
    with Image.open(io.BytesIO(data)) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=int)
    dark = (pixels.sum(axis=-1) < 500).mean()
    assert 0.01 < dark < 0.5
    assert len(data) < 150_000


def test_the_picture_moves(clip):
    show = motion_show(clip.skeleton, cut(clip.motion, 0, 61))
    with Image.open(io.BytesIO(moving_png(show))) as image:
        assert image.info["default_image"]
        assert image.n_frames == 1 + math.ceil(show.seconds * RATE)
        assert image.size == SIZE
        pictures = []
        for number in (1, image.n_frames - 1):
            image.seek(number)
            pictures.append(np.asarray(image.convert("RGB"), int))
            assert image.info["duration"] == 1000 / RATE
    assert (np.abs(pictures[1] - pictures[0]).sum(axis=-1) > 100).mean() > 0.01


def test_a_moment_is_still(clip):
    show = motion_show(clip.skeleton, cut(clip.motion, 0, 3))
    assert moving_png(show) == still_png(show)


def test_a_ball_is_where_it_flies():
    times, places = np.array([0.0, 1.0]), np.array([[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    ball = Ball(id="ball", radius=0.1, times=times, places=places, colour="red", trail=False)
    line = Line(id="line", points=places, colour="grey")
    show = Show(title="", seconds=2.0, balls=[ball], lines=[line])
    with Image.open(io.BytesIO(moving_png(show))) as image:
        columns = []
        for number in range(1, image.n_frames):
            image.seek(number)
            red, green, _ = np.moveaxis(np.asarray(image.convert("RGB"), int), -1, 0)
            where = np.nonzero(red - green > 80)[1]
            columns.append(where.mean() if len(where) else None)
    flying = columns[: len(columns) // 2]
    assert all(a < b for a, b in itertools.pairwise(flying))
    assert columns[-1] is None


def test_ten_seconds_are_a_quarter_of_a_megabyte(clip):
    motion = cut(clip.motion, 0, min(301, clip.motion.num_frames))
    assert motion.seconds > 9
    bundle = mime_bundle(motion)
    assert len(bundle["text/html"].encode()) < 250_000
    assert sum(len(text.encode()) for text in bundle.values()) < 350_000


def test_a_motion_of_nobody_is_text():
    motion = make_motion(make_skeleton(), frames=3)
    bundle = mime_bundle(motion)
    assert set(bundle) == {"text/plain"}
    assert bundle["text/plain"] == repr(motion)
    assert isinstance(motion, Motion)


def test_a_walk_shows_what_it_plays(graph):
    walk = random_walk(graph, 0, 2.0, seed=1)
    show = show_of(walk)
    starts = walk.starts(graph)
    assert show.seconds == pytest.approx(float(starts[-1]), abs=1 / graph.frame_rate)
    assert show.spans[0].start == 0.0
    assert show.spans[-1].end == pytest.approx(float(starts[-1]))
    assert dict(show.notes)["edges"] == str(len(walk.edges))
    assert sentence(show) in mime_bundle(walk)["text/html"]


def test_the_skin_follows_the_joints(clip):
    """What lies on a shin keeps its distances while the shin moves."""
    show = motion_show(clip.skeleton, clip.motion)
    body, frames = show.bodies[0], show.actors[0].frames
    shin = find_role(clip.skeleton, "left_knee")
    chosen = (body.mesh.joints[:, 0] == shin) & (body.mesh.weights[:, 0] >= 252)
    assert chosen.sum() > 20
    first, later = (skinned(body, frames, frame)[chosen] for frame in (0, len(frames.root) // 2))
    apart = [np.linalg.norm(places - places[0], axis=1) for places in (first, later)]
    np.testing.assert_allclose(apart[0], apart[1], atol=4e-3)
    assert np.abs(first - later).max() > 0.05
