"""A browser, a server of the page's files, and pages on which an error fails the test."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

import mgjax.stage
from mgjax.stage.film import ARGUMENTS
from mgjax.stage.packet import pack
from mgjax.stage.show.types import show_value

PAGE = Path(mgjax.stage.__file__).parent / "page"
CHROMIUM = "/usr/bin/chromium"
SIZE = {"width": 640, "height": 400}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """All tests of this folder need a browser."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.browser)


def _absent(reason: str) -> None:
    if os.environ.get("MGJAX_REQUIRE_BROWSER") == "1":
        pytest.fail(f"MGJAX_REQUIRE_BROWSER=1, but {reason}")
    print(f"browser tests are skipped: {reason}")
    pytest.skip(reason)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """The browser; skips where there is none."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _absent("playwright is not installed")
        return
    path = CHROMIUM if Path(CHROMIUM).exists() else shutil.which("chromium")
    if path is None:
        _absent(f"there is no Chromium at {CHROMIUM} (make browser)")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(ARGUMENTS))
        yield browser
        browser.close()


class _Files(SimpleHTTPRequestHandler):
    """Files of the page, and what tests add."""

    added: dict[str, tuple[str, bytes]]

    def do_GET(self) -> None:
        name = self.path.split("?")[0]
        if name not in self.added:
            super().do_GET()
            return
        mime, data = self.added[name]
        self.send_response(200)
        self.send_header("Content-Type", mime)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, format: str, *args: Any) -> None:
        pass


class Served:
    """A server on 127.0.0.1 of the page's modules, to which tests add what they need."""

    def __init__(self) -> None:
        self.added: dict[str, tuple[str, bytes]] = {}
        handler = type("Files", (_Files,), {"added": self.added})
        self.server = ThreadingHTTPServer(("127.0.0.1", 0), partial(handler, directory=str(PAGE)))
        self.server.daemon_threads = True
        self.thread = threading.Thread(target=self.server.serve_forever, daemon=True)
        self.thread.start()
        self.address = f"http://127.0.0.1:{self.server.server_address[1]}"

    def add(self, name: str, mime: str, data: bytes) -> str:
        """The address at which the bytes are from now on."""
        self.added[f"/{name}"] = (mime, data)
        return f"{self.address}/{name}"

    def close(self) -> None:
        self.server.shutdown()
        self.server.server_close()
        self.thread.join()


@pytest.fixture(scope="session")
def served() -> Iterator[Served]:
    """See :class:`Served`."""
    server = Served()
    yield server
    server.close()


@contextmanager
def _tabs(chromium: Any) -> Iterator[Callable[..., Any]]:
    """Opens addresses in new tabs; an error in any of them fails at the end."""
    # What a test waits for is evaluated; one test goes without, so that the policy is tried.
    context = chromium.new_context(viewport=SIZE, bypass_csp=True)
    troubles: list[str] = []

    def hear(said: Any) -> None:
        slow = "GL Driver Message" in said.text and "Performance" in said.text
        if said.type in ("error", "warning") and not slow:
            troubles.append(said.text)

    def watch(page: Any) -> None:
        page.on("pageerror", lambda error: troubles.append(f"page error: {error}"))
        page.on("console", hear)

    context.on("page", watch)

    def open_one(address: str) -> Any:
        page = context.new_page()
        page.goto(address)
        return page

    yield open_one
    for page in context.pages:
        if not page.is_closed():
            page.evaluate("0")
    context.close()
    assert not troubles, "; ".join(troubles)


@pytest.fixture
def open_page(chromium: Any) -> Iterator[Callable[..., Any]]:
    """Opens addresses in new tabs; an error in any of them fails the test at its end."""
    with _tabs(chromium) as open_one:
        yield open_one


@pytest.fixture(scope="module")
def view() -> Iterator[Callable[..., str]]:
    """Starts ``mgjax view`` with some arguments and gives its address.

    At the end it is interrupted, and has to end well with nothing in its log.
    """
    running: list[subprocess.Popen[str]] = []

    def start(*arguments: object) -> str:
        command = [sys.executable, "-m", "mgjax", "view", *map(str, arguments)]
        process = subprocess.Popen(
            [*command, "--port", "0", "--no-browser"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        running.append(process)
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        assert address.startswith("http://127.0.0.1:"), process.communicate()[1]
        return address

    yield start
    logs: list[str] = []
    for process in running:
        process.send_signal(signal.SIGINT)
        logs.append(process.communicate(timeout=60)[1])
    assert [process.returncode for process in running] == [0] * len(running)
    assert not any(logs), logs


@pytest.fixture
def open_app(open_page: Callable[..., Any]) -> Callable[[str], Any]:
    """Opens the page of an application, and waits until it can be used."""

    def open_one(address: str) -> Any:
        page = open_page(address)
        page.wait_for_function("document.documentElement.dataset.ready", timeout=180_000)
        return page

    return open_one


BENCH = b"""<!doctype html><html lang="en"><head><meta charset="utf-8"><title>bench</title>
<link rel="icon" href="data:,"><link rel="stylesheet" href="stage.css">
<script type="module" src="bench.js"></script></head>
<body class="mg-page"><main class="mg-view" id="view">
<canvas class="mg-canvas" id="canvas" tabindex="0"></canvas></main>
<div class="mg-under" id="bar"></div><aside class="mg-side" id="side"></aside></body></html>"""
BENCH_SCRIPT = b"""
import * as body from './body.js';
import * as motion from './motion.js';
import * as offline from './offline.js';
import * as packet from './packet.js';
import * as quality from './quality.js';
import * as ui from './ui.js';
import { createPlayer } from './player.js';
import { createStage } from './stage.js';
const bytes = await (await fetch('show.bin')).arrayBuffer();
const [canvas, bar] = ['canvas', 'bar'].map((id) => document.getElementById(id));
const stage = createStage(canvas, { dark: false });
const player = createPlayer(stage, bar);
const show = packet.unpack(bytes);
stage.setShow(show);
player.setShow(show);
stage.frameAll();
window.bench = { body, motion, offline, packet, quality, ui, bytes, show };
Object.assign(window.bench, { createPlayer, createStage });
window.mgjax = { stage, player };
"""


def _bench(served: Served, open_one: Callable[..., Any], show: Any, **size: int) -> Any:
    served.add("bench.html", "text/html", BENCH)
    served.add("bench.js", "text/javascript", BENCH_SCRIPT)
    served.add("show.bin", "application/octet-stream", pack(show_value(show)))
    page = open_one("about:blank")
    page.set_viewport_size({**SIZE, **size})
    page.goto(f"{served.address}/bench.html")
    page.wait_for_function("window.mgjax && mgjax.stage.camera.width > 1")
    return page


@pytest.fixture
def bench(open_page: Callable[..., Any], served: Served) -> Callable[..., Any]:
    """A page with a stage and a player of a show, and all modules as ``window.bench``."""
    return partial(_bench, served, open_page)


@pytest.fixture(scope="module")
def shared_bench(chromium: Any, served: Served) -> Iterator[Callable[..., Any]]:
    """As ``bench``, for pages that several tests of a module use."""
    with _tabs(chromium) as open_one:
        yield partial(_bench, served, open_one)
