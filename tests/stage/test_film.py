import shutil

import pytest

from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.errors import ConfigError
from mgjax.core.motion import cut
from mgjax.io.load import load_motion
from mgjax.stage.film import find_browser, save_film, save_show
from mgjax.stage.show.motion import motion_show
from mgjax.stage.show.types import Show

imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")


@pytest.fixture(scope="module")
def show() -> Show:
    clip = next(clip for clip in synthetic_clips()[0] if clip.name == "walk")
    return motion_show(clip.skeleton, cut(clip.motion, 60, 67), title="walk")


def test_a_motion_goes_through_its_writers(tmp_path, show):
    save_show(tmp_path / "walk.bvh", show)
    _, motion = load_motion(tmp_path / "walk.bvh")
    assert motion.num_frames == len(show.actors[0].frames.root)


@pytest.mark.parametrize("name", ["walk.gif", "walk"])
def test_another_suffix_is_refused(tmp_path, show, name):
    with pytest.raises(ConfigError, match=r"expected a name that ends with \.html, \.png, \.mp4"):
        save_show(tmp_path / name, show)
    assert not list(tmp_path.iterdir())


def test_nobody_to_write(tmp_path):
    with pytest.raises(ConfigError, match=r"got 0 actors for a \.bvh file"):
        save_show(tmp_path / "nobody.bvh", Show(title="nobody", seconds=1.0))


def test_a_browser_that_is_not_there(monkeypatch, tmp_path):
    monkeypatch.setenv("MGJAX_CHROMIUM", str(tmp_path / "missing"))
    with pytest.raises(ConfigError, match="MGJAX_CHROMIUM="):
        find_browser()
    monkeypatch.delenv("MGJAX_CHROMIUM")
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr("pathlib.Path.is_file", lambda self: False)
    with pytest.raises(ConfigError, match="got no Chromium, expected one on the path"):
        find_browser()


def test_nothing_is_left_of_a_film_that_cannot_be(monkeypatch, tmp_path, show):
    monkeypatch.setenv("MGJAX_CHROMIUM", str(tmp_path / "missing"))
    with pytest.raises(ConfigError):
        save_film(tmp_path / "film.mp4", show)
    assert not list(tmp_path.iterdir())
