"""One tab of the sketch application: what the page asks for, and what is undone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

from mgjax.core.errors import ConfigError
from mgjax.stage.apps.sketch import edits, files
from mgjax.stage.apps.sketch.drawing import METHODS, Drawing
from mgjax.stage.apps.sketch.picture import (
    actors_of,
    items_of,
    lines_of,
    moments_of,
    show_of,
    spans_of,
    things_of,
)
from mgjax.stage.apps.sketch.ready_made import NAMES, ready_made
from mgjax.stage.apps.sketch.solve import Effort, Solution, Solver, require_motion
from mgjax.stage.apps.sketch.walking import height_of, standing_pose
from mgjax.stage.apps.sketch.words import EMPTY, figures, sentence, target_words
from mgjax.stage.serve.exports import FORMATS, html_file, motion_file
from mgjax.stage.serve.fields import content, flag, number, point, points, text, whole
from mgjax.stage.serve.film import file_message
from mgjax.stage.serve.session import Message, Send
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Show, show_value

MOST_POINTS = 4000
"""Of a stroke of the pen."""
MOST_UNDONE = 60
WHENS = ("start", "passing", "end", "at")
Fresh = Literal["", "drawn", "given"]
"""Whether the path is another one, and then where it comes from."""
LATEST_S = 300.0
HOLD_S = (0.0, 10.0)
RADIUS_M = (0.05, 2.0)


class SketchSession:
    """What one person draws. Each edit is one step that can be undone; a drag is one edit."""

    def __init__(self, solver: Solver, send: Send) -> None:
        self._solver, self._send = solver, send
        self._graph = solver.graph
        self._height = height_of(self._graph.skeleton)
        frames = frames_of(standing_pose(self._graph))
        self._waiting = Actor(id="waiting", body=0, frames=frames)
        self._drawing = Drawing()
        self._solution = Solution(drawing=self._drawing)
        self._before: list[Drawing] = []
        self._dragged = False
        self._version = 0
        self._handlers: dict[str, Callable[[Message], None]] = {
            "path": self._path, "ready_made": self._ready_made, "smooth": self._smooth,
            "closed": self._closed, "method": self._method, "add": self._add, "move": self._move,
            "set": self._set, "remove": self._remove, "clear": self._clear, "undo": self._undo,
            "refine": self._refine, "save": self._save, "open": self._open, "export": self._export,
        }  # fmt: skip
        options = {"ready_made": list(NAMES), "formats": list(FORMATS)}
        send({"type": "ready", "app": "sketch", "title": "Sketch", "options": options})
        send({"type": "show", "show": show_value(self._standing())})

    def receive(self, message: Message) -> None:
        """Does what the page asks for; see :class:`mgjax.stage.serve.session.Session`."""
        kind = text(message, "type", tuple(self._handlers))
        self._handlers[kind](message)

    def tick(self) -> None:
        """Nothing goes on by itself."""

    def close(self) -> None:
        self._before.clear()
        self._solution = Solution(drawing=self._drawing)

    def _standing(self) -> Show:
        """Somebody who waits."""
        skeleton = self._graph.skeleton
        return Show(title="Sketch", seconds=0.0, words=EMPTY, bodies=[body_of(skeleton)],
                    actors=[self._waiting])  # fmt: skip

    # What is drawn and placed.

    def _path(self, message: Message) -> None:
        stroke = points(message, "points", MOST_POINTS, size=2)
        self._change(edits.draw(self._drawing, stroke), fresh="drawn")

    def _ready_made(self, message: Message) -> None:
        name = text(message, "name", NAMES)
        self._change(ready_made(self._drawing, name, self._height), fresh="given")

    def _smooth(self, message: Message) -> None:
        self._change(edits.reshape(self._drawing, smooth=flag(message, "on")))

    def _closed(self, message: Message) -> None:
        self._change(edits.reshape(self._drawing, closed=flag(message, "on")))

    def _method(self, message: Message) -> None:
        name = text(message, "name", METHODS)
        self._change(replace(self._drawing, method="beam" if name == "beam" else "exact"))

    def _add(self, message: Message) -> None:
        kind, place = text(message, "kind", edits.KINDS), point(message, "place")
        self._change(edits.add(self._drawing, kind, place, self._height))

    def _move(self, message: Message) -> None:
        end = None if message.get("end") is None else point(message, "end")
        name, place = text(message, "id"), point(message, "place")
        self._drag(edits.move(self._drawing, name, place, end), flag(message, "done"))

    def _set(self, message: Message) -> None:
        name, done = text(message, "id"), flag(message, "done")
        if "radius" in message:
            radius = round(number(message, "radius", *RADIUS_M), 3)
            self._drag(edits.resize(self._drawing, name, radius), done)
        elif "hold" in message:
            hold = round(number(message, "hold", *HOLD_S), 3)
            self._drag(edits.retime(self._drawing, name, hold_s=hold), done)
        else:
            when: str | float = text(message, "when", WHENS)
            if when == "at":
                when = round(number(message, "seconds", 0.0, LATEST_S), 2)
            self._drag(edits.retime(self._drawing, name, when=when), done)

    def _remove(self, message: Message) -> None:
        self._change(edits.remove(self._drawing, text(message, "id")))

    def _clear(self, _: Message) -> None:
        self._change(replace(self._drawing, path=None, obstacles=(), goals=()))

    def _undo(self, _: Message) -> None:
        if not self._before:
            raise ConfigError(got="nothing to undo", expected="an edit before")
        self._dragged = False
        self._drawing = self._before.pop()
        self._solve("quick")

    # How it is solved.

    def _change(self, drawing: Drawing, *, fresh: Fresh = "") -> None:
        """One edit; solved at once, and better when the page asks for it."""
        self._remember()
        self._dragged = False
        self._drawing = drawing
        self._solve("quick", fresh=fresh)

    def _drag(self, drawing: Drawing, done: bool) -> None:
        """Part of an edit that goes on until it is done."""
        if not self._dragged:
            self._remember()
        self._dragged = not done
        self._drawing = drawing
        self._solve("quick" if done else "drag")

    def _remember(self) -> None:
        self._before.append(self._drawing)
        del self._before[:-MOST_UNDONE]

    def _refine(self, message: Message) -> None:
        """The better walk, unless something was changed meanwhile."""
        if whole(message, "version", 0, 2**53) == self._version and self._solution.better:
            self._solve("full")

    def _solve(self, effort: Effort, *, fresh: Fresh = "") -> None:
        self._version += 1
        self._solution = self._solver.solve(self._drawing, effort)
        self._send(self._note(fresh))

    def _note(self, fresh: Fresh) -> Message:
        solution, drawing = self._solution, self._drawing
        words, tone = sentence(solution)
        motion = solution.motion
        said = [target_words(solution, i) for i in range(len(drawing.goals))]
        return {
            "type": "note",
            "event": "drawn",
            "version": self._version,
            "better": solution.better,
            "dragged": self._dragged,
            "fresh": fresh,
            "words": words,
            "tone": tone,
            "figures": [list(row) for row in figures(solution)],
            "seconds": 0.0 if motion is None else (motion.num_frames - 1) / motion.frame_rate,
            "actors": show_value(actors_of(solution) or [self._waiting]),
            "lines": show_value(lines_of(solution)),
            "things": show_value(things_of(solution)),
            "spans": show_value(spans_of(solution)),
            "moments": [list(row) for row in moments_of(solution)],
            "items": items_of(drawing, said),
            "smooth": drawing.smooth,
            "closed": drawing.path is not None and drawing.path.closed,
            "method": drawing.method,
            "undo": len(self._before),
        }

    # Files.

    def _save(self, message: Message) -> None:
        if text(message, "what", ("path", "targets")) == "path":
            data = files.sketch_text(self._drawing.sketch())
            self._send(file_message("path.json", "application/json", data.encode()))
            return
        if not self._drawing.goals:
            raise ConfigError(got="no targets", expected="a hand, head or bar on the stage")
        data = files.targets_text(self._drawing.targets())
        self._send(file_message("targets.json", "application/json", data.encode()))

    def _open(self, message: Message) -> None:
        name = text(message, "name", most=120)
        read = files.read_upload(name, content(message, "text"))
        if isinstance(read, tuple):
            self._change(edits.with_targets(self._drawing, read))
            return
        drawing = edits.with_sketch(self._drawing, read)
        drawing.sketch()  # one that is too long changes nothing
        self._change(drawing, fresh="given")

    def _export(self, message: Message) -> None:
        form = text(message, "format", FORMATS)
        motion, skeleton = require_motion(self._solution), self._graph.skeleton
        if form == "html":
            self._send(html_file("walk", show_of(self._solution, skeleton)))
        else:
            self._send(motion_file("walk", form, skeleton, motion))
