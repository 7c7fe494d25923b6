"""What a notebook shows of a thing: a player, and a picture that moves where nothing may run."""

from __future__ import annotations

import base64
import html
from typing import Any

from mgjax.core.errors import MgjaxError
from mgjax.core.shown import origin_of
from mgjax.stage.html import page_html
from mgjax.stage.moving import moving_png
from mgjax.stage.show.of import show_of
from mgjax.stage.show.types import Show

_NEEDS_ORIGIN = ("Motion", "Selection", "Walk", "PathResult", "ReachResult", "Coverage")
HEIGHT_PX = 420

_CELL = (
    '<iframe srcdoc="{page}" sandbox="allow-scripts" loading="lazy" title="{title}"'
    ' style="width:100%;height:{height}px;border:1px solid #ccc;border-radius:6px"></iframe>'
    "<div>{text}</div>"
)
"""Each cell carries its whole page: cells stay whole when they are copied, cleared or reordered."""


def mime_bundle(thing: Any) -> dict[str, str]:
    """``text/html`` with the player, ``image/png`` and ``text/plain``.

    A notebook that is not trusted shows the picture, or the sentence under where the player would
    be. A thing that does not know what it was made of has its ``repr`` only.
    """
    if type(thing).__name__ in _NEEDS_ORIGIN and origin_of(thing) is None:
        return {"text/plain": repr(thing)}
    try:
        show = show_of(thing)
    except MgjaxError as error:
        return {"text/plain": f"{type(thing).__name__}: {error}"}
    return {
        "text/plain": sentence(show),
        "text/html": cell_html(show),
        "image/png": base64.b64encode(moving_png(show)).decode(),
    }


def sentence(show: Show) -> str:
    """Title, words and figures of a show in one line."""
    parts = [show.words, *(f"{name} {value}" for name, value in show.notes)]
    text = "; ".join(part for part in parts if part)
    return f"{show.title}: {text}" if text else show.title


def cell_html(show: Show) -> str:
    """The player as one element, without a server, in a frame that may run scripts only."""
    return _CELL.format(
        page=html.escape(page_html(show), quote=True),
        title=html.escape(show.title, quote=True),
        height=HEIGHT_PX,
        text=html.escape(sentence(show)),
    )
