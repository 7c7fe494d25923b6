"""What an application behind the page is: made once in the worker, and one session for each tab."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

Message = dict[str, Any]
Send = Callable[[Message], None]
"""Sends a record to one tab; with arrays in it (:mod:`mgjax.stage.packet`) it goes as bytes."""
Progress = Callable[[float, str], None]
"""Told how much is done, 0 … 1, and what is being done now, in a few words."""


@runtime_checkable
class Session(Protocol):
    """One tab. All methods are called from the worker's main thread, never at the same time."""

    def receive(self, message: Message) -> None:
        """A message of the page, ``{"type": …}``, of at most 2 MB; nothing in it is trusted.

        Of several that wait with the same type and ``"latest": true`` only the newest is received.

        Raises:
            MgjaxError: its text is shown on the page as one sentence; nothing has changed then.
        """
        ...

    def tick(self) -> None:
        """Called some 60 times a second; takes a few milliseconds at most."""
        ...

    def close(self) -> None:
        """The tab is gone: everything it held is freed."""
        ...


@runtime_checkable
class App(Protocol):
    """What all tabs share."""

    def prepare(self, progress: Progress) -> None:
        """Loads, builds and compiles; called once, before the first session."""
        ...

    def open(self, send: Send) -> Session:
        """A new tab; what it sends here is the first that the page gets."""
        ...

    def close(self) -> None:
        """The worker ends."""
        ...
