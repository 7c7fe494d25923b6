"""What the page is told: each message as a record."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.selection import Selection
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.graph.types import MotionGraph
from mgjax.stage.apps.edit.labels import LabelBook
from mgjax.stage.apps.edit.library import Entry
from mgjax.stage.apps.edit.seam import Seam
from mgjax.stage.serve.session import Message
from mgjax.stage.show.motion import motion_show
from mgjax.stage.show.selection import selection_show
from mgjax.stage.show.types import Show, Span, show_value


def entry_row(entry: Entry, book: LabelBook) -> dict[str, Any]:
    """A clip of the list."""
    extent = entry.extent
    row: dict[str, Any] = {"name": entry.name, "lines": list(entry.lines), "error": entry.error}
    if extent is not None:
        row |= {"frames": extent.frames, "rate": extent.rate}
        row |= {"parents": entry.parents, "strip": entry.strip}
        row["problem"] = book.problem(entry.name, extent)
    return row


def labels_message(book: LabelBook, clip: str | None, problem: str = "") -> Message:
    """The labels of one clip, or of all, with what can be done to them."""
    clips = [clip] if clip is not None else book.table.clips()
    return {
        "type": "note",
        "event": "labels",
        "all": clip is None,
        "clips": {name: book.rows(name) for name in clips},
        "problem": problem,
        "kinds": book.kinds(),
        "directions": book.directions(),
        "changed": book.table.changed,
        "can_undo": book.table.can_undo,
        "can_redo": book.table.can_redo,
    }


def show_message(show: Show, **more: Any) -> Message:
    """Something to be seen; ``more`` says what it is."""
    return {"type": "show", "show": show_value(show), **more}


def sentence(text: str, tone: str = "plain") -> Message:
    """One sentence on the page."""
    return {"type": "sentence", "text": text, "tone": tone}


def clip_show(name: str, skeleton: Skeleton, motion: Motion) -> Show:
    """A clip."""
    return motion_show(skeleton, motion, title=name)


def seam_show(graph: MotionGraph, seam: Seam) -> Show:
    """A transition, with what goes before and after it."""
    show = motion_show(graph.skeleton, seam.motion, title="Transition")
    one, two = seam.leaves, seam.arrives
    spans = [
        Span(row="plays", start=0.0, end=seam.start, text=one[0], colour="blue"),
        Span(row="plays", start=seam.start, end=seam.stop, text="transition", colour="orange"),
        Span(row="plays", start=seam.stop, end=show.seconds, text=two[0], colour="green"),
    ]
    words = f"{one[0]} at {one[1]:.2f} s leads to {two[0]} at {two[1]:.2f} s"
    spans = [span for span in spans if span.end > span.start]
    return replace(show, words=words, spans=spans, notes=seam_rows(seam))


def seam_rows(seam: Seam) -> list[tuple[str, str]]:
    """The figures of a transition, for a table."""
    rows = [
        ("distance", f"{100 * seam.distance:.1f} cm"),
    ]
    if seam.slide is not None:
        blended, cleaned = (1000 * x for x in seam.slide)
        rows.append(("planted feet slide", f"{cleaned:.1f} mm a frame"))
        rows.append(("before clean-up", f"{blended:.1f} mm a frame"))
    here, own = seam.jerk
    rows.append(("largest jerk", f"{here:.0f} m/s³"))
    rows.append(("of the two clips there", f"{own:.0f} m/s³"))
    return rows


def throw_show(graph: MotionGraph, attack: Attack, selection: Selection, what: str) -> Show:
    """A ball of the coverage map and the answer to it; ``what`` says which ball it is."""
    show = selection_show(graph, attack, selection, title="A ball of the coverage map")
    words = f"{show.words[:1].upper()}{show.words[1:]}: {what}."
    return replace(show, words=words, moments=())  # there is little room, and spans say as much
