"""Photographs of the applications of the page, each at two sizes."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mgjax.stage.film import ARGUMENTS, find_browser

APPS = ("throw", "sketch", "match", "edit")
SIZES = {"wide": (1280, 720), "narrow": (760, 900)}
READY_MS = 300_000


def photograph(folder: Path) -> None:
    """Starts each application and takes its picture at each size."""
    folder.mkdir(parents=True, exist_ok=True)
    for app in APPS:
        command = [sys.executable, "-m", "mgjax", "view", app, "--no-browser", "--port", "0"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            try:
                assert server.stdout is not None
                _take(folder, app, server.stdout.readline().strip())
            finally:
                server.terminate()


def _take(folder: Path, app: str, address: str) -> None:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(find_browser()), args=list(ARGUMENTS)
        )
        for name, (width, height) in SIZES.items():
            page = browser.new_page(viewport={"width": width, "height": height}, bypass_csp=True)
            page.goto(address)
            page.wait_for_function(
                "app => document.documentElement.dataset.ready === app", arg=app, timeout=READY_MS
            )
            DEEDS.get(app, lambda page: None)(page)
            page.wait_for_timeout(3000)
            page.screenshot(path=folder / f"{app}_{name}.png")
            page.close()
        browser.close()


def _throw(page: Any) -> None:
    """Clicks where the character stands, and waits for the ball to fly."""
    page.wait_for_timeout(3000)
    box = page.locator("#canvas").bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + 0.45 * box["height"])
    page.wait_for_timeout(1500)


def _sketch(page: Any) -> None:
    """Draws a bow over the floor."""
    box = page.locator("#canvas").bounding_box()
    places = [(0.3, 0.8), (0.35, 0.7), (0.45, 0.62), (0.55, 0.6), (0.65, 0.66), (0.7, 0.75)]
    x, y = places[0]
    page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"])
    page.mouse.down()
    for x, y in places[1:]:
        page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"], steps=4)
    page.mouse.up()
    page.wait_for_timeout(8000)


DEEDS: dict[str, Callable[[Any], None]] = {"throw": _throw, "sketch": _sketch}
"""What is done before the picture is taken."""
