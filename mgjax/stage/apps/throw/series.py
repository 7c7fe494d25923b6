"""Ten balls one after another."""

from __future__ import annotations

from mgjax.stage.serve.session import Message, Send

COUNT = 10


class Series:
    """Counts the balls of a series, and tells the page of each."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self._avoided: list[bool] | None = None

    def begin(self) -> bool:
        """Begins a series; False while one is under way."""
        if self._avoided is not None:
            return False
        self._avoided = []
        self._tell()
        return True

    def note(self, avoided: bool) -> None:
        """A ball is over."""
        if self._avoided is not None:
            self._avoided.append(avoided)

    def wants_ball(self, busy: bool) -> bool:
        """Whether it is the next ball's turn; after the last the series ends.

        Args:
            busy: whether a ball is under way.
        """
        if self._avoided is None or busy:
            return False
        self._tell()
        if len(self._avoided) < COUNT:
            return True
        self._avoided = None
        return False

    def _tell(self) -> None:
        over = self._avoided or []
        note: Message = {"type": "note", "event": "series", "of": COUNT}
        self._send(note | {"done": len(over), "avoided": sum(over)})
