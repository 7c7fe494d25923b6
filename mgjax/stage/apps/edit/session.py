"""One tab of the editor."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from mgjax.core.errors import ConfigError, OutputError
from mgjax.stage.apps.edit.cover import MOST_ROUNDS, throw_of_cell
from mgjax.stage.apps.edit.messages import (
    clip_show,
    labels_message,
    seam_show,
    sentence,
    show_message,
    throw_show,
)
from mgjax.stage.apps.edit.seam import seam_of
from mgjax.stage.apps.edit.table import Extent
from mgjax.stage.apps.edit.workbench import Settings, Workbench
from mgjax.stage.serve.fields import flag, number, text, whole
from mgjax.stage.serve.session import Message, Send

LONGEST_KIND = 40
MOST_FRAMES = 10**9
_TONES = {"avoided": "good", "parried": "plain"}
"""How it is said what came of a throw; all else is bad."""


class EditSession:
    """Answers one page; what it edits is shared with all others."""

    def __init__(self, bench: Workbench, send: Send) -> None:
        self._bench, self._send = bench, send
        self._throws: dict[tuple[int, int], int] = {}
        self._answers: dict[str, Callable[[Message], None]] = {
            "pick": self._pick,
            "use": self._use,
            "label_add": self._label_add,
            "label_change": self._label_change,
            "label_delete": self._label_delete,
            "undo": self._undo,
            "redo": self._redo,
            "save": self._save,
            "reread": self._reread,
            "build": self._build,
            "cover": self._cover,
            "stop": self._stop,
            "transition": self._transition,
            "throw": self._throw,
        }
        for message in bench.greeting():
            send(message)
        bench.listeners.append(send)

    def receive(self, message: Message) -> None:
        """Does what the page asks for."""
        kind = text(message, "type")
        if kind not in self._answers:
            raise ConfigError(got=f"a message {kind!r:.40}", expected="one of the editor's")
        self._answers[kind](message)

    def tick(self) -> None:
        """Passes on what happened in the background."""
        self._bench.poll()

    def close(self) -> None:
        """The tab is gone."""
        if self._send in self._bench.listeners:
            self._bench.listeners.remove(self._send)

    def _pick(self, message: Message) -> None:
        name = self._clip(message)
        extent = self._bench.library.extent(name)
        skeleton, motion = self._bench.library.motion(name)
        self._send(labels_message(self._bench.book, name, self._bench.book.problem(name, extent)))
        self._send(show_message(clip_show(name, skeleton, motion), of="clip", clip=name))

    def _use(self, message: Message) -> None:
        """A clip is to be in the next graph, or not."""
        change = self._bench.left_out.discard if flag(message, "on") else self._bench.left_out.add
        change(self._clip(message))
        self._bench.tell(self._bench.used_message())

    def _clip(self, message: Message) -> str:
        return self._bench.library.check(text(message, "clip", most=1000))

    def _place(self, message: Message) -> tuple[str, Extent]:
        name = self._clip(message)
        return name, self._bench.library.extent(name)

    def _what(self, message: Message) -> dict[str, Any]:
        """Kind, direction and genuine, as far as they are said."""
        what: dict[str, Any] = {}
        if "kind" in message:
            kind = text(message, "kind", most=LONGEST_KIND).strip()
            if not kind:
                raise ConfigError(got="an empty kind", expected="a word such as duck")
            what["kind"] = kind
        if "direction" in message:
            what["direction"] = text(message, "direction", self._bench.book.directions())
        if "genuine" in message:
            what["genuine"] = flag(message, "genuine")
        return what

    def _label_add(self, message: Message) -> None:
        name, extent = self._place(message)
        start, stop = (whole(message, key, 0, MOST_FRAMES) for key in ("start", "stop"))
        what = {"kind": "duck", **self._what(message)}
        made = self._bench.book.table.add(name, extent, start, stop, **what)
        self._tell_labels(name)
        self._send({"type": "note", "event": "chosen", "clip": name, "label": made.id})

    def _label_change(self, message: Message) -> None:
        name, extent = self._place(message)
        ends = {
            key: whole(message, key, 0, MOST_FRAMES) for key in ("start", "stop") if key in message
        }
        try:
            what = self._what(message)
            self._bench.book.table.change(
                name, extent, whole(message, "label", 0, MOST_FRAMES), **ends, **what
            )
        finally:  # refused: the page has to show again what is
            self._tell_labels(name)

    def _label_delete(self, message: Message) -> None:
        name = self._clip(message)
        self._bench.book.table.delete(name, whole(message, "label", 0, MOST_FRAMES))
        self._tell_labels(name)

    def _undo(self, message: Message) -> None:
        self._tell_labels(self._bench.book.table.undo(), go=True)

    def _redo(self, message: Message) -> None:
        self._tell_labels(self._bench.book.table.redo(), go=True)

    def _tell_labels(self, name: str, *, go: bool = False) -> None:
        """All tabs see the labels of a clip; ``go``: this one shows that clip."""
        book = self._bench.book
        entry = self._bench.library.entry(name)
        problem = "" if entry.extent is None else book.problem(name, entry.extent)
        self._bench.tell(labels_message(book, name, problem))
        if go:
            self._send({"type": "note", "event": "went", "clip": name})

    def _save(self, message: Message) -> None:
        book = self._bench.book
        if book.file is None:
            data = np.frombuffer(book.download().encode(), np.uint8)
            self._send(
                {"type": "file", "name": "labels.json", "mime": "application/json"} | {"data": data}
            )
            self._bench.tell(labels_message(book, None))
            return
        try:
            said = book.save(overwrite="overwrite" in message and flag(message, "overwrite"))
        except OutputError:
            if book.file.changed_on_disk():
                self._send({"type": "note", "event": "conflict"})
            raise
        self._bench.tell(labels_message(book, None))
        self._bench.tell(sentence(said, "good"))

    def _reread(self, message: Message) -> None:
        self._bench.book.read()
        self._bench.tell(labels_message(self._bench.book, None))
        self._bench.tell(sentence("The labels file was read again."))

    def _build(self, message: Message) -> None:
        threshold = message.get("threshold_m")
        self._bench.build(
            Settings(
                threshold_m=None if threshold is None else number(message, "threshold_m", 0.001, 1),
                keep=number(message, "keep", 0, 1),
                retarget=flag(message, "retarget"),
            ),
            write=True,
        )

    def _cover(self, message: Message) -> None:
        self._throws.clear()
        self._bench.cover(whole(message, "rounds", 1, MOST_ROUNDS))

    def _stop(self, message: Message) -> None:
        self._bench.stop(text(message, "job", ("build", "cover")))

    def _transition(self, message: Message) -> None:
        graph = self._bench.need_graph()
        edge = whole(message, "edge", 0, graph.num_edges - 1)
        seam = seam_of(graph, edge)
        show = seam_show(graph, seam)
        self._send(
            {
                "type": "note",
                "event": "seam",
                "edge": edge,
                "words": show.words,
                "rows": show.notes,
            }
        )
        self._send(show_message(show, of="transition", edge=edge))

    def _throw(self, message: Message) -> None:
        graph, found = self._bench.need_graph(), self._bench.coverage
        if found is None:
            raise ConfigError(got="no coverage map", expected="one: press Throw balls")
        cell = (
            whole(message, "direction", 0, len(found.directions) - 1),
            whole(message, "height", 0, len(found.heights) - 1),
        )
        turn = self._throws.get(cell, 0)
        attack, selection, what = throw_of_cell(graph, self._bench.config, found, *cell, turn)
        self._throws[cell] = turn + 1
        show = throw_show(graph, attack, selection, what)
        self._send(show_message(show, of="throw", direction=cell[0], height=cell[1]))
        self._send(sentence(show.words, _TONES.get(selection.status, "bad")))
