"""One connected page, with what waits to be sent to it."""

from __future__ import annotations

import asyncio

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

MOST_WAITING = 2000
MOST_BYTES = 64_000_000
"""A page that does not keep up is closed rather than kept in memory."""


class Tab:
    """A page; what is sent to it goes out in order, and never holds up anybody else."""

    def __init__(self, number: int, connection: ServerConnection) -> None:
        self.number, self.connection = number, connection
        self._waiting: asyncio.Queue[str | bytes] = asyncio.Queue()
        self._bytes = 0
        self._slow = False

    def send(self, data: str | bytes) -> None:
        """Queues a message; a page too far behind gets no more, and is closed by :meth:`run`."""
        self._bytes += len(data)
        if self._bytes > MOST_BYTES or self._waiting.qsize() > MOST_WAITING:
            self._slow = True
            return
        self._waiting.put_nowait(data)

    async def run(self) -> None:
        """Sends what is queued until the page is gone."""
        try:
            while not self._slow:
                data = await self._waiting.get()
                await self.connection.send(data)
                self._bytes -= len(data)
            await self.connection.close(1013, "the page does not keep up")
        except ConnectionClosed:
            return
