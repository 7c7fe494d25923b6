"""Pages, cells and films that Python writes, in a real browser without a network."""

import gc

import numpy as np
import pytest

import mgjax
from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.motion import cut
from mgjax.stage.film import pixels_of
from mgjax.stage.notebook import mime_bundle
from mgjax.stage.show.motion import motion_show

MOVES = "time => window.mgjax && window.mgjax.stage && window.mgjax.player.time > time"


@pytest.fixture(scope="module")
def clip():
    return next(clip for clip in synthetic_clips()[0] if clip.name == "walk")


@pytest.fixture
def offline(chromium):
    """A context without a network; whatever the page asks for, or complains of, is noted."""
    context = chromium.new_context(
        viewport={"width": 640, "height": 400}, offline=True, bypass_csp=True
    )
    context.noted = []
    context.on("request", lambda request: context.noted.append(request.url))
    context.on("weberror", lambda error: context.noted.append(str(error.error)))
    yield context
    context.close()


def test_a_page_plays_without_a_network(offline, tmp_path, clip):
    mgjax.save_html(tmp_path / "page.html", (clip.skeleton, clip.motion), title="Walking")
    page = offline.new_page()
    page.goto((tmp_path / "page.html").as_uri())
    page.wait_for_function(MOVES, arg=0.1)
    assert page.title() == "Walking"
    others = [url for url in offline.noted if not url.startswith(("data:", "file:", "blob:"))]
    assert others == []
    assert sum(url.startswith("file:") for url in offline.noted) == 1


def test_a_cell_plays_in_its_frame(offline, tmp_path, clip):
    cell = mime_bundle(clip)["text/html"]
    (tmp_path / "cells.html").write_text(f"<!doctype html><body>{cell}{cell}</body>")
    page = offline.new_page()
    page.goto((tmp_path / "cells.html").as_uri())
    page.wait_for_function("document.querySelectorAll('iframe').length === 2")
    frame = page.frames[1]
    frame.wait_for_function(MOVES, arg=0.1)
    assert frame.evaluate("window.origin") == "null"


def test_a_notebook_that_is_run_plays(offline, tmp_path):
    """A cell that ends with a clip, run by a kernel, as the page that nbconvert makes of it."""
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    source = (
        "from mgjax.clips.synthetic import synthetic_clips\n"
        "from mgjax.core.motion import cut\n"
        "clip = next(clip for clip in synthetic_clips()[0] if clip.name == 'walk')\n"
        "cut(clip.motion, 0, 61)"
    )
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(source)])
    nbclient.NotebookClient(notebook, timeout=300).execute()
    (output,) = notebook.cells[0].outputs
    assert {"text/html", "image/png", "text/plain"} <= set(output.data)
    (tmp_path / "run.html").write_text(f"<!doctype html><body>{output.data['text/html']}</body>")
    page = offline.new_page()
    page.goto((tmp_path / "run.html").as_uri())
    page.wait_for_function("document.querySelectorAll('iframe').length === 1")
    page.frames[1].wait_for_function(MOVES, arg=0.1)


def test_what_is_not_trusted_shows_words(offline, tmp_path, clip):
    """Without the frame, which sanitizers take out, and without scripts."""
    bundle = mime_bundle(clip)
    before, after = bundle["text/html"].split("<iframe")[0], bundle["text/html"].split("</iframe>")
    (tmp_path / "plain.html").write_text(f"<!doctype html><body>{before}{after[1]}</body>")
    page = offline.new_page()
    page.goto((tmp_path / "plain.html").as_uri())
    assert bundle["text/plain"] in page.inner_text("body")


# imageio-ffmpeg leaves the pipes of what it read to the garbage collector.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_film_has_all_frames_and_moves(chromium, tmp_path, clip):
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    from mgjax.stage.film import pictures, save_film

    show = motion_show(clip.skeleton, cut(clip.motion, 60, 66))
    first, last = (pixels_of(p) for p in pictures(show, [0.0, show.seconds], size=(320, 180)))
    assert first.shape == (180, 320, 3)
    assert np.abs(first.astype(int) - last).max() > 50
    save_film(tmp_path / "walk.mp4", show, size=(320, 180))
    reader = imageio_ffmpeg.read_frames(str(tmp_path / "walk.mp4"))
    about = next(reader)
    frames = [np.frombuffer(frame, np.uint8).reshape(180, 320, 3) for frame in reader]
    assert about["codec"] == "h264"
    assert about["size"] == (320, 180)
    assert len(frames) == len(show.actors[0].frames.root)
    assert np.abs(frames[0].astype(int) - first).mean() < 6
    assert [path.name for path in tmp_path.iterdir()] == ["walk.mp4"]
    del reader
    gc.collect()
