"""A live body from a motion sensor: frames received over UDP by the VMC protocol."""

from __future__ import annotations

import contextlib
import queue
import socket
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from types import TracebackType

from mgjax.core.errors import ConfigError
from mgjax.sensor.config import HOST, PORT
from mgjax.sensor.frames import Counts, FrameAssembler, SensorFrame

_LONGEST = 65535
"""Bytes of a UDP datagram."""
_QUEUE = 512
"""Frames that wait to be taken; when there are more, the oldest is dropped."""
_BUFFER = 1 << 20
"""Bytes that the system keeps while the thread does something else."""
_POLL_S = 0.05


def clock() -> float:
    """The receiver's clock, s; it never goes back."""
    return time.perf_counter()


def address(host: str, port: int) -> tuple[str, int]:
    """A host and port to send to or to listen on.

    Raises:
        ConfigError: the host is not known, or there is no such port.
    """
    if not 0 <= port <= 65535:
        raise ConfigError(f"got port {port}, expected 0 … 65535")
    try:
        found = socket.getaddrinfo(host, port, socket.AF_INET, socket.SOCK_DGRAM)
    except (OSError, UnicodeError):
        raise ConfigError(f"got the host {host!r}, expected a name or an IPv4 address") from None
    return str(found[0][4][0]), port


class SensorReceiver:
    """Listens for a sender; a context manager.

    A thread of its own reads the socket, so that frames are stamped when they arrive. Whatever
    arrives, it keeps at most a fixed number of frames; see :class:`FrameAssembler` for the rest.

    Args:
        host: of this machine, on which to listen. Packets carry nothing that says who sent them:
            anything but loopback lets everybody on that network move the body.
        port: 0 takes a free one.

    Raises:
        ConfigError: the port is taken, or the host is not one of this machine.
    """

    def __init__(self, host: str = HOST, port: int = PORT) -> None:
        place = address(host, port)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind(place)
        except OSError as error:
            self._socket.close()
            raise ConfigError(
                f"got {host}:{port} to listen on ({error.strerror}), expected a free port of this"
                " machine"
            ) from None
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
        self._socket.settimeout(_POLL_S)
        self._assembler = FrameAssembler()
        self._frames: queue.Queue[SensorFrame] = queue.Queue(_QUEUE)
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="sensor", daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        """On which it listens."""
        return int(self._socket.getsockname()[1])

    @property
    def counts(self) -> Counts:
        """What became of all packets so far."""
        return replace(self._assembler.counts)

    def frames(self, seconds: float) -> Iterator[SensorFrame]:
        """The frames that come within so many seconds, as they come."""
        end = clock() + seconds
        while (left := end - clock()) > 0:
            try:
                yield self._frames.get(timeout=left)
            except queue.Empty:
                return

    def close(self) -> None:
        """Stops listening."""
        self._stopping.set()
        self._thread.join()
        self._socket.close()

    def __enter__(self) -> SensorReceiver:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _listen(self) -> None:
        while not self._stopping.is_set():
            try:
                datagram, source = self._socket.recvfrom(_LONGEST)
            except TimeoutError:
                continue
            for frame in self._assembler.feed(datagram, clock(), source):
                if self._frames.full():
                    with contextlib.suppress(queue.Empty):  # it may just have been taken
                        self._frames.get_nowait()
                        self._assembler.counts.overrun += 1
                self._frames.put_nowait(frame)
