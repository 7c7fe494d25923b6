"""The application: one show, read once, for every tab."""

from __future__ import annotations

from mgjax.core.errors import ConfigError
from mgjax.stage.serve.exports import html_file
from mgjax.stage.serve.fields import text
from mgjax.stage.serve.options import Options
from mgjax.stage.serve.session import Message, Progress, Send
from mgjax.stage.show.folder import show_of_folder
from mgjax.stage.show.types import Show, show_value


def make_app(options: Options) -> ShowApp:
    """The application behind ``mgjax view DIR``."""
    return ShowApp(options)


class ShowApp:
    """A folder or file of a result."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._show: Show | None = None

    def prepare(self, progress: Progress) -> None:
        """Reads it."""
        if self._options.result is None:
            raise ConfigError(got="nothing to show", expected="the folder or file of a result")
        progress(0.3, "reading the result")
        self._show = show_of_folder(self._options.result)

    def open(self, send: Send) -> ShowSession:
        assert self._show is not None
        options = {"formats": ["html"]}
        send({"type": "ready", "app": "show", "title": self._show.title, "options": options})
        send({"type": "show", "show": show_value(self._show)})
        return ShowSession(self._show, send)

    def close(self) -> None:
        self._show = None


class ShowSession:
    """A tab: it plays, and asks for nothing but a page of its own."""

    def __init__(self, show: Show, send: Send) -> None:
        self._show, self._send = show, send

    def receive(self, message: Message) -> None:
        if message["type"] != "export":
            raise ConfigError(got=f"a message of type {message['type']!r:.40}", expected="export")
        text(message, "format", ("html",))
        self._send(html_file("show", self._show))

    def tick(self) -> None:
        return

    def close(self) -> None:
        return
