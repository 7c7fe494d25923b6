"""Serving an application until it is interrupted."""

from __future__ import annotations

import asyncio
import json
import os
import sys
import webbrowser

from mgjax.stage.serve.guard import is_loopback
from mgjax.stage.serve.options import Options
from mgjax.stage.serve.server import Server

HOST, PORT = "127.0.0.1", 8765


def view(
    options: Options,
    *,
    host: str = HOST,
    port: int = PORT,
    browser: bool = True,
    as_json: bool = False,
) -> None:
    """Serves an application, prints its address on one line, and opens it.

    Args:
        options: which application, and its folders.
        host: address to listen on; anything but this machine's own is warned of.
        port: its port; 0 takes a free one.
        browser: opens the page, where there is a display.
        as_json: prints the address as a JSON object.

    Raises:
        ConfigError: the port is taken, or the host is no address of this machine.
        MgjaxError: what could not be read or built.
    """
    if not is_loopback(host):
        print(
            f"mgjax: warning: whoever reaches {host} can use this page and the folders given to it",
            file=sys.stderr,
            flush=True,
        )

    def listening(address: str) -> None:
        print(json.dumps({"address": address}) if as_json else address, flush=True)
        if browser and has_display():
            webbrowser.open(address)

    asyncio.run(Server(options, host, port).run(listening))


def has_display() -> bool:
    """Whether a browser could be seen: on Linux there has to be a screen."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
