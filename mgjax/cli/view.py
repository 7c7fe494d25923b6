"""``mgjax view``."""

from __future__ import annotations

from pathlib import Path

from mgjax.cli.arguments import View
from mgjax.core.errors import ConfigError
from mgjax.stage.serve.options import Options
from mgjax.stage.serve.view import view

APPS = ("throw", "sketch", "match", "edit")


def run(command: View) -> None:
    """Serves a page until it is interrupted, or writes a result to a file."""
    options = options_of(command)
    if command.save is not None:
        if options.result is None:
            raise ConfigError(got=f"--save with {command.what}", expected="a result to save")
        from mgjax.stage.film import save_show
        from mgjax.stage.show.folder import show_of_folder

        save_show(command.save, show_of_folder(options.result))
        print(f"written to {command.save}", flush=True)
        return
    if not 0 <= command.port <= 65535:
        raise ConfigError(got=f"--port {command.port}", expected="0 … 65535")
    view(
        options,
        host=command.host,
        port=command.port,
        browser=not command.no_browser,
        as_json=command.json,
    )


def options_of(command: View) -> Options:
    """What to serve; :class:`ConfigError` for what is neither an application nor a result."""
    for name in ("graph", "clips"):
        folder = getattr(command, name)
        if folder is not None and not folder.is_dir():
            raise ConfigError(got=f"--{name} {folder}", expected="a folder that is there")
    if command.what in APPS:
        return Options(
            app=command.what, graph=command.graph, clips=command.clips, labels=command.labels
        )
    result = Path(command.what).expanduser()
    if not result.exists():
        raise ConfigError(
            got=command.what, expected=f"{', '.join(APPS)}, or the folder or file of a result"
        )
    return Options(app="show", result=result)
