"""One file that plays a show in any browser, without a server and without a network."""

from __future__ import annotations

import base64
import html
import json
import struct
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

from mgjax.io.output import replace_file
from mgjax.io.user_path import user_path
from mgjax.stage.bundle import bundle, short_text
from mgjax.stage.packet import pack
from mgjax.stage.show.of import show_of
from mgjax.stage.show.types import Show, show_value

_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' data:; style-src 'unsafe-inline';"
    " img-src data: blob:; media-src blob:; base-uri 'none'; form-action 'none'"
)
"""The page loads nothing, from nowhere."""

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<link rel="icon" href="data:,">
<style>{style}</style>
</head>
<body>
<noscript>This page needs JavaScript.</noscript>
<script type="text/plain" id="mgjax-payload" data-options="{options}">{payload}</script>
<script>{boot}</script>
</body>
</html>
"""


def save_html(path: str | Path, thing: Any, title: str | None = None) -> None:
    """Writes one page that plays a thing offline, in any browser that has WebGL 2.

    Args:
        path: of the file; whole or not at all.
        thing: a motion that was loaded or made from a graph, a (skeleton, motion) pair, a clip, a
            selection, a walk, a result of a path or of reaching, a scene, a coverage, a show, or
            the path of a motion file or of a folder that a command wrote.
        title: over the picture; default: what the thing is.

    Raises:
        MgjaxError: it is nothing that can be shown, or the file cannot be written.
    """
    show = show_of(thing)
    if title is not None:
        show = replace_title(show, title)
    replace_file(user_path(path), page_html(show))


def replace_title(show: Show, title: str) -> Show:
    """The show under another title."""
    return replace(show, title=title)


def page_html(show: Show, **options: Any) -> str:
    """The page as text; options are those of ``offline.js``."""
    return _PAGE.format(
        policy=html.escape(_POLICY, quote=True).replace("&#x27;", "'"),
        title=html.escape(show.title),
        style=short_text("stage.css"),
        options=html.escape(json.dumps(options), quote=True),
        payload=payload(show),
        boot=short_text("boot.js"),
    )


def payload(show: Show) -> str:
    """The modules and the show as text; see ``boot.js``."""
    modules = json.dumps(bundle("offline.js"), ensure_ascii=False).encode()
    data = struct.pack("<I", len(modules)) + modules + pack(show_value(show))
    return base64.b64encode(zlib.compress(data, 9)).decode()
