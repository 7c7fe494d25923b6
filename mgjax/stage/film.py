"""Pictures and films of a show, drawn by its own page in a browser that nobody sees."""

from __future__ import annotations

import base64
import io
import os
import shutil
import tempfile
from collections.abc import Generator, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from mgjax.core.errors import ConfigError, OutputError
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.output import replace_file
from mgjax.io.save import WRITERS, save_motion
from mgjax.io.text import reason
from mgjax.io.user_path import user_path
from mgjax.stage.html import page_html, save_html
from mgjax.stage.show.types import Show

SIZE = (1280, 720)
RATE = 30
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
ARGUMENTS = (
    "--no-sandbox",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
_START_MS = 60_000
_PLAIN = ".mg-under, .mg-corner { display: none !important; }"
"""A picture has no buttons and no timeline."""
_AS_HIGH_AS = "height => document.querySelector('.mg-canvas').clientHeight === height"
_SEEK = """time => {
  window.mgjax.player.seek(time);
  return window.mgjax.stage.snapshot(time);
}"""


def save_show(path: str | Path, show: Show, *, time: float | None = None) -> None:
    """Writes a show as ``.html``, ``.png``, ``.mp4``, or its one motion in a format for motion.

    Args:
        path: of the file; its suffix says the format.
        show: what is to be seen.
        time: of a picture, s; default: when the ball passes, else the middle.

    Raises:
        ConfigError: the suffix is none of these; the show has several actors for a format that has
            one motion; what draws pictures or writes films is not installed.
        OutputError: the file cannot be written.
    """
    path = user_path(path)
    suffix = path.suffix.lower()
    if suffix == ".html":
        save_html(path, show)
    elif suffix == ".png":
        (picture,) = pictures(show, [_moment(show) if time is None else time])
        replace_file(path, picture)
    elif suffix == ".mp4":
        save_film(path, show)
    elif suffix in WRITERS:
        save_motion(path, *_only_motion(show, suffix))
    else:
        expected = ", ".join((".html", ".png", ".mp4", *WRITERS))
        raise ConfigError(got=f"--save {path.name}", expected=f"a name that ends with {expected}")


def save_film(
    path: str | Path, show: Show, *, size: tuple[int, int] = SIZE, rate: int = RATE
) -> None:
    """Writes a film (H.264) of the whole show; see :func:`save_show`."""
    try:
        import imageio_ffmpeg
    except ImportError:
        got, expected = "no imageio-ffmpeg, which writes films", "pip install 'mgjax[video]'"
        raise ConfigError(got=got, expected=expected) from None
    find_browser()  # before anything is started or made
    count = int(np.floor(show.seconds * rate + 1e-6)) + 1
    path = Path(path)
    try:
        folder = tempfile.TemporaryDirectory(dir=path.parent, prefix=".part-")
    except OSError as error:
        raise OutputError(
            got=f"{path.parent}, which cannot be written ({reason(error)})",
            expected="a writable folder",
        ) from None
    with folder as place:
        part = Path(place) / "film.mp4"
        writer = imageio_ffmpeg.write_frames(
            str(part), size, fps=rate, codec="libx264", quality=7, macro_block_size=2
        )
        writer.send(None)
        try:
            for picture in pictures(show, [number / rate for number in range(count)], size=size):
                writer.send(pixels_of(picture).tobytes())
        finally:
            writer.close()
        os.replace(part, path)


def pictures(
    show: Show, times: list[float], *, size: tuple[int, int] = SIZE, plain: bool = True
) -> Iterator[bytes]:
    """A PNG for each moment of a show.

    Args:
        show: what is to be seen.
        times: s.
        size: of the pictures, pixels.
        plain: the picture alone, without words, buttons and timeline.

    Raises:
        ConfigError: there is no browser, or it cannot draw.
    """
    with ThreadPoolExecutor(max_workers=1) as one:  # where a notebook has a loop of its own
        drawn = _pictures(show, times, size, plain)
        try:
            while (picture := one.submit(next, drawn, None).result()) is not None:
                yield picture
        finally:
            one.submit(drawn.close).result()


def _pictures(
    show: Show, times: list[float], size: tuple[int, int], plain: bool
) -> Generator[bytes, None, None]:
    shown = replace(show, title="", words="", notes=(), bars=()) if plain else show
    with _page(page_html(shown, play=False, dark=False), size, plain) as page:
        for time in times:
            data = page.evaluate(_SEEK, float(time))
            if not data:
                got = "a browser that lost its picture"
                raise ConfigError(got=got, expected="one with WebGL 2")
            yield base64.b64decode(data.split(",", 1)[1]) if plain else page.screenshot()


def pixels_of(picture: bytes) -> np.ndarray:
    """Red, green and blue of a PNG. [H,W,3]"""
    with Image.open(io.BytesIO(picture)) as image:
        return np.asarray(image.convert("RGB"))


@contextmanager
def _page(text: str, size: tuple[int, int], plain: bool) -> Iterator[Any]:
    """The page in a browser without a window, drawn once."""
    try:
        from playwright.sync_api import Error, sync_playwright
    except ImportError:
        got, expected = "no playwright, which drives a browser", "pip install 'mgjax[film]'"
        raise ConfigError(got=got, expected=expected) from None
    browser_path = find_browser()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        file = Path(folder) / "show.html"
        file.write_text(text, encoding="utf-8")
        try:
            browser = playwright.chromium.launch(
                executable_path=str(browser_path), args=list(ARGUMENTS)
            )
            page = browser.new_page(viewport={"width": size[0], "height": size[1]}, bypass_csp=True)
            page.goto(file.as_uri())
            page.wait_for_function("window.mgjax && window.mgjax.stage", timeout=_START_MS)
            if plain:
                page.add_style_tag(content=_PLAIN)
                page.wait_for_function(_AS_HIGH_AS, arg=size[1], timeout=_START_MS)
            page.evaluate("window.mgjax.stage.frameAll()")
            yield page
            browser.close()
        except Error as error:
            why = str(error).splitlines()[0][:100]
            got = f"{browser_path}, which does not draw ({why})"
            raise ConfigError(got=got, expected="a Chromium with WebGL 2") from None


def find_browser() -> Path:
    """``MGJAX_CHROMIUM``, else a Chromium on the path or in the usual places.

    Raises:
        ConfigError: there is none.
    """
    named = os.environ.get("MGJAX_CHROMIUM")
    if named:
        if not Path(named).is_file():
            raise ConfigError(got=f"MGJAX_CHROMIUM={named}", expected="a browser that is there")
        return Path(named)
    usual = (
        *(found for name in _BROWSERS if (found := shutil.which(name))),
        "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
        "/Applications/Chromium.app/Contents/MacOS/Chromium",
        r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    )
    for place in usual:
        if Path(place).is_file():
            return Path(place)
    raise ConfigError(
        got="no Chromium", expected="one on the path, or MGJAX_CHROMIUM with its place"
    )


def _moment(show: Show) -> float:
    """When something is to be seen."""
    named = dict(show.moments)
    return named.get("ball passes", show.seconds / 2)


def _only_motion(show: Show, suffix: str) -> tuple[Skeleton, Motion]:
    """The motion of the one actor, as the page has it: at most 30 frames a second."""
    if len(show.actors) != 1:
        got = f"{len(show.actors)} actors for a {suffix} file"
        raise ConfigError(got=got, expected="one, or .html, .png or .mp4")
    frames, body = show.actors[0].frames, show.bodies[show.actors[0].body]
    turns = frames.rotations
    if frames.delta:
        turns = np.cumsum(turns, axis=0, dtype=np.int16)
    unit = turns.astype(np.float64)
    unit /= np.linalg.norm(unit, axis=-1, keepdims=True)
    skeleton = Skeleton(
        names=tuple(body.names),
        parents=tuple(int(parent) for parent in body.parents),
        offsets=np.asarray(body.offsets, np.float32),
    )
    motion = Motion(
        root_translation=np.asarray(frames.root, np.float32),
        local_rotations=unit.astype(np.float32),
        frame_rate=float(frames.rate),
    )
    return skeleton, motion
