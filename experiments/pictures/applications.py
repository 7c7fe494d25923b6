"""Photographs of the applications of the page, each at two sizes, in the middle of what they do."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mgjax.stage.film import ARGUMENTS, find_browser

SIZES = {"wide": (1280, 720), "narrow": (900, 600)}
WAIT_MS = 300_000
_BODY = """() => {
  const actor = mgjax.stage.scene.actors.get('character0');
  if (!actor || !actor.track.pieces.length) return null;
  const [x, , z] = actor.track.smoothRoot(mgjax.stage.time, 0.1);
  return mgjax.stage.project([x, 1.2, z]);
}"""


def photograph(folder: Path, apps: tuple[str, ...] = ("throw", "sketch", "match", "edit")) -> None:
    """Starts each application and takes its picture at each size."""
    folder.mkdir(parents=True, exist_ok=True)
    for app in apps:
        command = [sys.executable, "-m", "mgjax", "view", app, "--no-browser", "--port", "0"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            try:
                assert server.stdout is not None
                _take(folder, app, server.stdout.readline().strip())
            finally:
                server.send_signal(signal.SIGINT)


def _take(folder: Path, app: str, address: str) -> None:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(find_browser()), args=list(ARGUMENTS)
        )
        for name, (width, height) in SIZES.items():
            scheme = "light" if name == "wide" else "dark"
            context = browser.new_context(
                viewport={"width": width, "height": height}, bypass_csp=True, color_scheme=scheme
            )
            page = context.new_page()
            page.set_default_timeout(WAIT_MS)
            page.goto(address)
            page.wait_for_function("document.documentElement.dataset.ready")
            DEEDS[app](page)
            page.screenshot(path=folder / f"{app}_{name}.png")
            print(f"{app}_{name}.png", flush=True)
            context.close()
        browser.close()


def _throw(page: Any) -> None:
    """Throws until a ball is avoided, then shows it again with the other ways out."""
    page.evaluate(
        "() => { mgjax.link.on('note', (n) => n.event === 'answer' && (mgjax.last = n)); }"
    )
    for _ in range(12):
        page.wait_for_function(_BODY)
        page.evaluate("mgjax.last = null")
        page.mouse.click(*page.evaluate(_BODY))
        page.wait_for_function("mgjax.last")
        if page.evaluate("!mgjax.last.hit && mgjax.last.words.startsWith('avoided')"):
            break
    page.click("[data-name=ghosts]")
    page.wait_for_function("!mgjax.player.live && mgjax.player.seconds > 1")
    page.evaluate(
        """() => {
          const { player, stage } = mgjax;
          player.pause();
          const [ball] = stage.scene.balls.values();
          player.seek(ball.times[0] + 1.4);
        }"""
    )
    page.wait_for_timeout(2500)


def _sketch(page: Any) -> None:
    """The ready-made path with a hand's target and a bar, at the bar."""
    page.click("[data-name=ready-reaches]")
    page.wait_for_function("mgjax.player.seconds > 2")
    page.wait_for_timeout(4000)
    page.evaluate("() => { mgjax.player.pause(); mgjax.player.seek(0.42 * mgjax.player.seconds); }")
    page.wait_for_timeout(2500)


def _match(page: Any) -> None:
    """After some passes."""
    page.wait_for_function("mgjax.player.time > 9")
    page.evaluate("() => mgjax.player.pause()")
    page.wait_for_timeout(2500)


def _edit(page: Any) -> None:
    """A clip with labels, and the graph below."""
    page.locator("[data-name=clip-duck]").click()
    page.wait_for_function("document.querySelector('[data-name=work]').parentElement.hidden")
    page.wait_for_timeout(1500)
    page.click("[data-name=tab-graph]")
    page.wait_for_timeout(3000)


DEEDS: dict[str, Callable[[Any], None]] = {
    "throw": _throw,
    "sketch": _sketch,
    "match": _match,
    "edit": _edit,
}
"""What is done before the picture is taken."""
