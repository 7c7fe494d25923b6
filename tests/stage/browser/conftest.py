"""A browser, a server of the page's files, and pages on which an error fails the test."""

from __future__ import annotations

import os
import shutil
import threading
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

import mgjax.stage

PAGE = Path(mgjax.stage.__file__).parent / "page"
CHROMIUM = "/usr/bin/chromium"
ARGUMENTS = (
    "--no-sandbox",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
SIZE = {"width": 640, "height": 400}


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


@pytest.fixture
def open_page(chromium: Any, served: Served) -> Iterator[Callable[..., Any]]:
    """Opens addresses in new tabs; an error in any of them fails the test at its end."""
    context = chromium.new_context(viewport=SIZE)
    troubles: list[str] = []

    def watch(page: Any) -> None:
        page.on("pageerror", lambda error: troubles.append(f"page error: {error}"))
        page.on(
            "console",
            lambda said: troubles.append(said.text) if said.type in ("error", "warning") else None,
        )

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
