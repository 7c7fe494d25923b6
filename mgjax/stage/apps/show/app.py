"""The application: one show, read once, for every tab."""

from __future__ import annotations

from mgjax.core.errors import ConfigError
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
        send({"type": "ready", "app": "show", "title": self._show.title, "options": {}})
        send({"type": "show", "show": show_value(self._show)})
        return ShowSession()

    def close(self) -> None:
        self._show = None


class ShowSession:
    """A tab: it plays, and asks for nothing."""

    def receive(self, message: Message) -> None:
        raise ConfigError(got=f"a message of type {message['type']!r:.40}", expected="none")

    def tick(self) -> None:
        return

    def close(self) -> None:
        return
