"""The whole command in a process of its own: its files, its guard, and how it ends."""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosedError, InvalidStatus
from websockets.sync.client import connect

from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.motion import cut
from mgjax.io.bvh.write import save_bvh
from mgjax.stage.packet import unpack
from mgjax.stage.serve.options import Options
from mgjax.stage.serve.server import Server

PATIENCE_S = 120.0


class Viewed:
    """A running ``mgjax view`` and its address."""

    def __init__(self, *arguments: object) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "mgjax", "view", *map(str, arguments), "--no-browser"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()
        self.host = self.address.removeprefix("http://").rstrip("/")

    def get(self, path: str, **headers: str) -> http.client.HTTPResponse:
        """An answer to a request; its body is read."""
        name, port = self.host.split(":")
        connection = http.client.HTTPConnection(name, int(port), timeout=PATIENCE_S)
        connection.request("GET", path, headers=headers)
        response = connection.getresponse()
        response.body = response.read()  # type: ignore[attr-defined]
        connection.close()
        return response

    def link(self, origin: str | None = "own", **options: Any) -> Any:
        """A page's connection."""
        return connect(
            f"ws://{self.host}/link",
            origin=f"http://{self.host}" if origin == "own" else origin,  # type: ignore[arg-type]
            max_size=None,
            **options,
        )

    def end(self) -> tuple[int, str]:
        """Ctrl-C: its exit status, and what it said."""
        self.process.send_signal(signal.SIGINT)
        _, err = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, err


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("clip") / "steps.bvh"
    clips, _ = synthetic_clips()
    save_bvh(path, clips[1].skeleton, cut(clips[1].motion, 0, 30))
    return path


@pytest.fixture(scope="module")
def viewed(clip: Path) -> Iterator[Viewed]:
    running = Viewed(clip, "--port", 0)
    yield running
    status, err = running.end()
    assert (status, err) == (0, "")


def messages_until(link: Any, kind: str) -> list[Any]:
    """Messages of the server, up to the first of a type."""
    found: list[Any] = []
    while not found or found[-1]["type"] != kind:
        data = link.recv(timeout=PATIENCE_S)
        found.append(unpack(data) if isinstance(data, bytes) else json.loads(data))
    return found


def test_the_address_is_one_line_of_this_machine(viewed: Viewed):
    assert viewed.address.startswith("http://127.0.0.1:")


def test_files_come_with_a_policy(viewed: Viewed):
    for path, kind in (("/", "text/html"), ("/stage.css", "text/css"), ("/live.js", "text/javas")):
        response = viewed.get(path)
        assert response.status == 200
        assert response.headers["Content-Type"].startswith(kind)
        policy = response.headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy
        assert "script-src 'self';" in policy
        assert "unsafe" not in policy


@pytest.mark.parametrize(
    "path", ["/../server.py", "/..%2fserver.py", "//etc/passwd", "/draw/", "/nothing.js", "/link/x"]
)
def test_other_paths_are_not_there(viewed: Viewed, path: str):
    assert viewed.get(path).status == 404


def test_foreign_hosts_are_refused(viewed: Viewed):
    assert viewed.get("/", Host="evil.example").status == 403


@pytest.mark.parametrize("origin", [None, "null", "http://evil.example", "http://127.0.0.1:1"])
def test_foreign_pages_are_refused(viewed: Viewed, origin: str | None):
    with pytest.raises(InvalidStatus, match="403"), viewed.link(origin):
        pass


def test_two_pages_each_get_the_show(viewed: Viewed):
    with viewed.link() as one, viewed.link() as two:
        for link in (one, two):
            show = messages_until(link, "show")[-1]["show"]
            assert show["kind"] == "show"
            assert show["actors"][0]["frames"]["rotations"].shape[0] == 30


def test_bad_messages_get_a_sentence_and_the_page_goes_on(viewed: Viewed):
    with viewed.link() as link:
        messages_until(link, "show")
        for text in ("{", "[]", '{"type": 1}', '{"type": "nothing"}'):
            link.send(text)
            assert messages_until(link, "sentence")[-1]["tone"] == "bad"


def test_long_messages_end_the_connection_and_nothing_else(viewed: Viewed):
    with viewed.link() as link:
        messages_until(link, "show")
        link.send("x" * (2**21 + 1))
        with pytest.raises(ConnectionClosedError) as caught:
            messages_until(link, "nothing more")
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == 1009
    with viewed.link() as link:
        messages_until(link, "show")


def test_more_pages_than_there_may_be(viewed: Viewed):
    with contextlib.ExitStack() as open_pages:
        for _ in range(16):
            messages_until(open_pages.enter_context(viewed.link()), "ready")
        with viewed.link() as one_more, pytest.raises(ConnectionClosedError) as caught:
            one_more.recv(timeout=PATIENCE_S)
        assert caught.value.rcvd is not None
        assert "16 pages" in caught.value.rcvd.reason


def failed(*arguments: object) -> tuple[int, str]:
    """Exit status and the last line of a command that cannot serve."""
    done = subprocess.run(
        [sys.executable, "-m", "mgjax", "view", *map(str, arguments), "--no-browser"],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        env=os.environ,
    )
    return done.returncode, done.stderr


def test_a_port_that_is_taken(clip: Path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        status, err = failed(clip, "--port", port)
    assert status == 2
    assert f"127.0.0.1:{port}" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("dance",), "expected throw, sketch, match, edit"),
        (("throw", "--graph", "nowhere"), "a folder that is there"),
        (("throw", "--port", "70000"), "0 … 65535"),
        (("throw", "--save", "a.html"), "a result to save"),
    ],
)
def test_bad_arguments(arguments: tuple[str, ...], words: str):
    status, err = failed(*arguments)
    assert status == 2
    assert words in err
    assert err.count("\n") == 1


def test_what_the_worker_cannot_read_ends_the_command(tmp_path: Path):
    (tmp_path / "bad.bvh").write_text("HIERARCHY\nnonsense\n")
    status, err = failed(tmp_path / "bad.bvh", "--port", 0)
    assert status == 2
    assert "bad.bvh" in err
    assert err.count("\n") == 1


def test_another_address_is_warned_of(clip: Path):
    running = Viewed(clip, "--port", 0, "--host", "0.0.0.0")
    status, err = running.end()
    assert status == 0
    assert err.startswith("mgjax: warning: whoever reaches 0.0.0.0")


def test_it_ends_though_the_worker_says_more_than_is_read() -> None:
    """Nobody reads what the worker says once the page is closed; it fills every buffer."""

    async def end() -> int | None:
        server = Server(Options(app="show"), "127.0.0.1", 0)
        listening = await server._listen()
        server._worker = await asyncio.create_subprocess_exec(
            sys.executable,
            "-c",
            "import sys\nwhile True: sys.stdout.buffer.write(bytes(2**16))",
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
        )
        await asyncio.sleep(0.5)  # until its reader has paused
        await asyncio.wait_for(server._end(listening), PATIENCE_S)
        return server._worker.returncode

    assert asyncio.run(end()) == -signal.SIGKILL
