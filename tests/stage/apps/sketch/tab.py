"""A tab of the sketch application without a browser."""

from __future__ import annotations

from typing import Any

from mgjax.stage.apps.sketch.session import SketchSession
from mgjax.stage.apps.sketch.solve import Solver


class Tab:
    """A session, and what it told its page."""

    def __init__(self, solver: Solver) -> None:
        self.told: list[dict[str, Any]] = []
        self.session = SketchSession(solver, self.told.append)

    @property
    def note(self) -> dict[str, Any]:
        """What was drawn last."""
        return next(m for m in reversed(self.told) if m.get("event") == "drawn")

    def send(self, type_: str, /, **fields: Any) -> dict[str, Any]:
        """Sends a message; the last that was told then."""
        self.session.receive({"type": type_, **fields})
        return self.told[-1]

    def refined(self) -> dict[str, Any]:
        """The better walk, as the page asks for it."""
        if self.note["better"]:
            self.send("refine", version=self.note["version"])
        return self.note

    def file(self, type_: str, **fields: str) -> str:
        """The text of a file that is asked for."""
        message = self.send(type_, **fields)
        assert message["type"] == "file"
        return message["data"].tobytes().decode()
