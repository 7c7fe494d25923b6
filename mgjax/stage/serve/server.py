"""The server of the page: files and messages between pages and the worker; it imports no jax."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from collections.abc import Callable
from http import HTTPStatus

from websockets.asyncio.server import Server as WebSocketServer
from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from mgjax.core.errors import ConfigError, MgjaxError
from mgjax.stage.serve.files import page_files
from mgjax.stage.serve.guard import host_is_own, origin_is_own, own_hosts
from mgjax.stage.serve.options import Options, to_text
from mgjax.stage.serve.tab import Tab
from mgjax.stage.serve.wire import HEAD, Kind, frame

LINK = "/link"
MOST_TABS = 16
LONGEST_MESSAGE = 2**21
"""Bytes of a message of a page."""


class Server:
    """Serves one application to pages.

    Args:
        options: which application, and its folders.
        host: address to listen on.
        port: its port; 0 takes a free one.
    """

    def __init__(self, options: Options, host: str, port: int) -> None:
        self._options, self._host, self._port = options, host, port
        self._files = page_files()
        self._tabs: dict[int, Tab] = {}
        self._opened = 0
        self._state: str | None = None
        self._worker: asyncio.subprocess.Process | None = None
        self._hosts: frozenset[str] = frozenset()

    async def run(self, listening: Callable[[str], None]) -> None:
        """Serves until it is interrupted, or the worker ends.

        Args:
            listening: told the address as soon as pages can be loaded.

        Raises:
            ConfigError: the port is taken, or the host is no address of this machine.
            MgjaxError: what the worker could not read or build.
        """
        server = await self._listen()
        address = server.sockets[0].getsockname()
        self._hosts = own_hosts(self._host, address[1])
        self._worker = await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            "mgjax.stage.serve.worker",
            to_text(self._options),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            env=os.environ | {"TF_CPP_MIN_LOG_LEVEL": "3"},
        )
        stop = asyncio.Event()
        loop = asyncio.get_running_loop()
        for name in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(name, stop.set)
        shown = f"[{address[0]}]" if ":" in address[0] else address[0]
        listening(f"http://{shown}:{address[1]}/")
        try:
            await self._until(stop)
        finally:
            await self._end(server)

    async def _listen(self) -> WebSocketServer:
        try:
            return await serve(
                self._tab,
                self._host,
                self._port,
                process_request=self._request,
                max_size=LONGEST_MESSAGE,
                compression=None,
            )
        except OSError as error:
            raise ConfigError(
                got=f"{self._host}:{self._port}, which cannot be listened on ({error.strerror})",
                expected="a free port and an address of this machine",
            ) from None

    async def _until(self, stop: asyncio.Event) -> None:
        """Waits for an interrupt or the end of the worker."""
        tasks = [asyncio.create_task(stop.wait()), asyncio.create_task(self._relay())]
        done, pending = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in pending:
            task.cancel()
        await asyncio.gather(*pending, return_exceptions=True)
        for task in done:
            task.result()

    async def _end(self, server: WebSocketServer) -> None:
        worker = self._worker
        assert worker is not None
        # A worker that cannot speak does not listen, and that it ended is only noticed once all
        # that it said has been read.
        rest = asyncio.create_task(_discard(worker.stdout))
        server.close()
        await server.wait_closed()
        if worker.stdin is not None:
            worker.stdin.close()
        try:
            await asyncio.wait_for(worker.wait(), 2.0)
        except TimeoutError:
            worker.kill()
            await worker.wait()
        await rest

    async def _relay(self) -> None:
        """Passes on what the worker says, until it ends; raises with what it failed on."""
        assert self._worker is not None
        stream = self._worker.stdout
        assert stream is not None
        while True:
            try:
                head = await stream.readexactly(HEAD.size)
                length, tab, kind = HEAD.unpack(head)
                payload = await stream.readexactly(length)
            except asyncio.IncompleteReadError:
                status = await self._worker.wait()
                raise MgjaxError(
                    f"the process that computes ended with status {status}; what it said is above"
                ) from None
            if kind == Kind.FAILED:
                await self._tell_failure(payload.decode())
                raise MgjaxError(payload.decode())
            if kind == Kind.STATE:
                self._state = payload.decode()
                for each in self._tabs.values():
                    each.send(self._state)
            elif tab in self._tabs:
                self._tabs[tab].send(payload.decode() if kind == Kind.TEXT else payload)

    async def _tell_failure(self, text: str) -> None:
        """The open pages learn why there is nothing to see."""
        message = json.dumps({"type": "sentence", "text": text, "tone": "bad"})
        for tab in list(self._tabs.values()):
            try:
                await tab.connection.send(message)
            except ConnectionClosed:
                continue

    def _request(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answers for a file; None lets a page's connection through."""
        host, origin = request.headers.get("Host"), request.headers.get("Origin")
        if not host_is_own(host, self._hosts, self._host):
            return _plain(HTTPStatus.FORBIDDEN, "got a foreign Host")
        path = request.path.partition("?")[0]
        if path == LINK:
            if not origin_is_own(origin, host):
                return _plain(HTTPStatus.FORBIDDEN, "got a foreign Origin")
            return None
        if path not in self._files:
            return _plain(HTTPStatus.NOT_FOUND, "there is no such file")
        kind, content = self._files[path]
        headers = Headers()
        headers["Content-Type"] = kind
        headers["Content-Length"] = str(len(content))
        headers["Content-Security-Policy"] = _policy(host or "")
        headers["X-Content-Type-Options"] = "nosniff"
        headers["Referrer-Policy"] = "no-referrer"
        headers["Cross-Origin-Resource-Policy"] = "same-origin"
        headers["Cache-Control"] = "no-store"
        return Response(200, "OK", headers, content)

    async def _tab(self, connection: ServerConnection) -> None:
        """One page, from its connection to its end."""
        if len(self._tabs) >= MOST_TABS:
            await connection.close(1013, f"{MOST_TABS} pages are open already")
            return
        self._opened += 1
        tab = Tab(self._opened, connection)
        self._tabs[tab.number] = tab
        if self._state is not None:
            tab.send(self._state)
        sending = asyncio.create_task(tab.run())
        try:
            await self._to_worker(tab.number, Kind.OPEN)
            async for message in connection:
                if isinstance(message, str):
                    await self._to_worker(tab.number, Kind.TEXT, message.encode())
        except ConnectionClosed:
            pass
        finally:
            del self._tabs[tab.number]
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)
            await self._to_worker(tab.number, Kind.CLOSE)

    async def _to_worker(self, tab: int, kind: Kind, payload: bytes = b"") -> None:
        worker = self._worker
        if worker is None or worker.stdin is None:
            return
        try:
            worker.stdin.write(frame(tab, kind, payload))
            await worker.stdin.drain()
        except (BrokenPipeError, ConnectionResetError):
            return  # it has ended, which :meth:`_relay` tells


async def _discard(stream: asyncio.StreamReader | None) -> None:
    """Reads what nobody wants any more."""
    while stream is not None and await stream.read(2**16):
        pass


def _policy(host: str) -> str:
    return (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:;"
        f" media-src blob:; connect-src 'self' ws://{host}; base-uri 'none'; form-action 'none';"
        " frame-ancestors 'none'"
    )


def _plain(status: HTTPStatus, text: str) -> Response:
    body = (text + "\n").encode()
    headers = Headers()
    headers["Content-Type"] = "text/plain; charset=utf-8"
    headers["Content-Length"] = str(len(body))
    return Response(status.value, status.phrase, headers, body)
