"""``mgjax view FILE`` in a browser: it plays, and is saved as a film and as a page that plays."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from imageio_ffmpeg import count_frames_and_secs

from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.motion import cut
from mgjax.io.bvh.write import save_bvh

WAIT = 60_000
FRAMES = 16


@pytest.fixture(scope="module")
def address(
    chromium: Any, view: Callable[..., str], tmp_path_factory: pytest.TempPathFactory
) -> str:
    path = tmp_path_factory.mktemp("clip") / "duck.bvh"
    clip = next(clip for clip in synthetic_clips()[0] if clip.name == "duck")
    save_bvh(path, clip.skeleton, cut(clip.motion, 0, FRAMES))
    return view(path)


@pytest.fixture
def page(open_app: Callable[[str], Any], address: str) -> Any:
    page = open_app(address)
    page.wait_for_function("mgjax.stage.scene.actors.size === 1", timeout=WAIT)
    return page


def test_it_plays_and_says_what_it_is(page: Any):
    page.wait_for_function("mgjax.player.playing && mgjax.player.time > 0.1", timeout=WAIT)
    assert page.locator("[data-name=notes] dt").count() > 0
    assert page.locator("h1").text_content()


def test_a_film_and_a_page_are_saved(page: Any, open_page: Callable[..., Any], tmp_path: Path):
    page.locator("[data-name=export] summary").click()
    with page.expect_download(timeout=WAIT) as got:
        page.click("[data-name=film]")
    got.value.save_as(tmp_path / "film.mp4")
    frames, _ = count_frames_and_secs(str(tmp_path / "film.mp4"))
    assert frames == FRAMES
    with page.expect_download(timeout=WAIT) as got:
        page.click("[data-name=page]")
    got.value.save_as(tmp_path / "page.html")
    offline = open_page((tmp_path / "page.html").as_uri())
    offline.wait_for_function("window.mgjax?.player?.seconds > 0.4", timeout=WAIT)


def test_other_messages_are_refused_in_words(page: Any):
    page.evaluate("mgjax.link.send({ type: 'export', format: '../../etc/passwd' })")
    page.evaluate("mgjax.link.send({ type: 'dance' })")
    page.wait_for_function("mgjax.player.seconds > 0", timeout=WAIT)
