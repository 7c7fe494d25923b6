"""A live body from a motion sensor: frames received over UDP by the VMC protocol."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from types import TracebackType

from mgjax.core.errors import ConfigError
from mgjax.sensor.clock import Clock, clock
from mgjax.sensor.config import HOST, PORT
from mgjax.sensor.counts import Counts
from mgjax.sensor.frames import SensorFrame
from mgjax.sensor.inbox import FrameInbox

_LONGEST = 65535
"""Bytes of a UDP datagram."""
_BUFFER = 1 << 20
"""Bytes that the system keeps while the thread does something else."""
_POLL_S = 0.05


def address(host: str, port: int) -> tuple[str, int]:
    """A host and port to send to or to listen on.

    Raises:
        ConfigError: the host is not known, or there is no such port.
    """
    if not 0 <= port <= 65535:
        raise ConfigError(f"got port {port}, expected 0 … 65535")
    try:
        known = socket.getaddrinfo(host, port, socket.AF_INET, socket.SOCK_DGRAM)
    except (OSError, UnicodeError):
        raise ConfigError(f"got the host {host!r}, expected a name or an IPv4 address") from None
    return str(known[0][4][0]), port


class SensorReceiver:
    """Listens for a sender; a context manager.

    A thread of its own reads the socket, so that frames are stamped when they arrive. Whatever
    arrives, it keeps at most a fixed number of frames; see :class:`mgjax.sensor.inbox.FrameInbox`.

    Args:
        host: of this machine, on which to listen. Packets carry nothing that says who sent them:
            anything but loopback lets everybody on that network move the body.
        port: 0 takes a free one.
        clock: stamps arrivals and ends the waiting.

    Raises:
        ConfigError: the port is taken, or the host is not one of this machine.
    """

    def __init__(self, host: str = HOST, port: int = PORT, *, clock: Clock = clock) -> None:
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
        self._inbox = FrameInbox(clock=clock)
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
        return self._inbox.counts

    def frames(self, seconds: float) -> Iterator[SensorFrame]:
        """The frames that come within so many seconds, as they come."""
        return self._inbox.frames(seconds)

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
            self._inbox.put(datagram, source)
