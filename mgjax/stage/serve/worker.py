"""The process that computes: it owns jax, and talks to the server through its own pipes.

Started as ``python -m mgjax.stage.serve.worker OPTIONS``; it ends when its input ends.
"""

from __future__ import annotations

import importlib
import json
import os
import queue
import signal
import sys
import threading
import time
import traceback
from collections.abc import Iterator
from io import BufferedIOBase
from typing import Any

from mgjax.core.errors import MgjaxError
from mgjax.stage.packet import pack
from mgjax.stage.serve.collector import freeze, give_back
from mgjax.stage.serve.film import Film
from mgjax.stage.serve.options import from_text
from mgjax.stage.serve.session import App, Message, Session
from mgjax.stage.serve.wire import ALL, Kind, frame, read_frame

TICK_S = 1 / 60
_GIVE_BACK_S = 10.0
"""How often free memory goes back to the system."""
_SWITCH_S = 0.001
"""How soon another thread gets its turn: a search in the background must not hold up a frame."""


class Worker:
    """Runs one application for all tabs; everything but reading happens in the main thread."""

    def __init__(self, app: App, source: BufferedIOBase, target: BufferedIOBase) -> None:
        self._app = app
        self._source, self._target = source, target
        self._writing = threading.Lock()
        self._inbox: queue.SimpleQueue[tuple[int, Kind, bytes] | None] = queue.SimpleQueue()
        self._sessions: dict[int, Session] = {}
        self._films: dict[int, Film] = {}
        self._ended = False
        self._given_back = time.monotonic()

    def run(self) -> None:
        """Prepares the application and serves its tabs until the input ends."""
        threading.Thread(target=self._read, daemon=True, name="mgjax-inbox").start()
        self.state({"type": "progress", "share": 0.0, "text": "starting"})
        self._app.prepare(
            lambda share, text: self.state({"type": "progress", "share": share, "text": text})
        )
        freeze()
        self.state({"type": "progress", "share": 1.0, "text": "ready"})
        try:
            while self._turn():
                pass
        finally:
            for each in (*self._sessions.values(), *self._films.values()):
                each.close()
            self._app.close()

    def state(self, message: Message) -> None:
        """Tells all tabs, and those that come later."""
        self._write(frame(ALL, Kind.STATE, json.dumps(message).encode()))

    def failed(self, text: str) -> None:
        """The last word: why there is nothing to see."""
        self._write(frame(ALL, Kind.FAILED, text.encode()))

    def _read(self) -> None:
        while (entry := read_frame(self._source)) is not None:
            self._inbox.put(entry)
        self._inbox.put(None)

    def _write(self, data: bytes) -> None:
        with self._writing:
            try:
                self._target.write(data)
                self._target.flush()
            except (BrokenPipeError, ValueError):
                return  # the server has ended; so does the input

    def _send(self, tab: int, message: Message) -> None:
        try:
            self._write(frame(tab, Kind.TEXT, json.dumps(message, allow_nan=False).encode()))
        except TypeError:  # it has arrays
            self._write(frame(tab, Kind.BYTES, pack(message)))

    def _turn(self) -> bool:
        """What has come in, then a tick of every session; False at the end of the input."""
        for tab, kind, payload in newest(list(self._waiting())):
            self._handle(tab, kind, payload)
        for tab, session in list(self._sessions.items()):
            self._guarded(tab, session.tick)
        if time.monotonic() >= self._given_back + _GIVE_BACK_S:
            give_back()
            self._given_back = time.monotonic()
        return not self._ended

    def _waiting(self) -> Iterator[tuple[int, Kind, bytes]]:
        """What waits; the first is waited for, with a tab open until the next tick."""
        try:
            entry = self._inbox.get(timeout=TICK_S if self._sessions else None)
            while True:
                if entry is None:
                    self._ended = True
                    return
                yield entry
                entry = self._inbox.get_nowait()
        except queue.Empty:
            return

    def _handle(self, tab: int, kind: Kind, payload: bytes) -> None:
        if kind == Kind.OPEN:
            self._guarded(tab, lambda: self._open(tab))
        elif kind == Kind.CLOSE:
            session, film = self._sessions.pop(tab, None), self._films.pop(tab, None)
            for each in (session, film):
                if each is not None:
                    each.close()
        elif tab in self._sessions:
            self._guarded(tab, lambda: self._receive(tab, _message(payload)))

    def _receive(self, tab: int, message: Message) -> None:
        """A message for a session, or a frame of a film, which every application takes."""
        if message["type"] != "film":
            self._sessions[tab].receive(message)
            return
        made = self._films.setdefault(tab, Film()).receive(message)
        self._send(tab, {"type": "filmed", "frame": message["frame"]})
        if made is not None:
            self._send(tab, made)

    def _open(self, tab: int) -> None:
        self._sessions[tab] = self._app.open(lambda message: self._send(tab, message))

    def _guarded(self, tab: int, call: Any) -> None:
        """Runs a call of a session; what goes wrong becomes a sentence on its page."""
        try:
            call()
        except MgjaxError as error:
            text = " ".join(str(error).split("\n"))
            self._send(tab, {"type": "sentence", "text": text, "tone": "bad"})
        except Exception:
            traceback.print_exc()
            text = "Something went wrong here that should not; the log of mgjax view has more."
            self._send(tab, {"type": "sentence", "text": text, "tone": "bad"})


def newest(entries: list[tuple[int, Kind, bytes]]) -> list[tuple[int, Kind, bytes]]:
    """Without messages that say ``"latest": true`` and are followed by one of their type."""
    seen: set[tuple[int, str]] = set()
    kept: list[tuple[int, Kind, bytes]] = []
    for entry in reversed(entries):
        tab, kind, payload = entry
        if kind == Kind.TEXT and b'"latest"' in payload:
            try:
                message = _message(payload)
            except MgjaxError:
                message = {}
            key = (tab, str(message.get("type")))
            if message.get("latest") is True:
                if key in seen:
                    continue
                seen.add(key)
        kept.append(entry)
    return kept[::-1]


def _message(payload: bytes) -> Message:
    """A message of a page; :class:`MgjaxError` unless it is a JSON object with a type."""
    try:
        message = json.loads(payload)
    except (ValueError, RecursionError):
        raise MgjaxError(got="a message that is no JSON", expected="an object") from None
    if not isinstance(message, dict) or not isinstance(message.get("type"), str):
        raise MgjaxError(got="a message without a type", expected='{"type": …}')
    return message


def main() -> None:
    """Runs the worker on this process's pipes; what is printed goes to the log."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the server, and so the input
    source = os.fdopen(os.dup(0), "rb")
    target = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    sys.setswitchinterval(_SWITCH_S)
    os.environ.setdefault("PJRT_NPROC", "1")  # searches are too small for a second thread
    from mgjax.core.xla.compilation import enable_cache

    enable_cache()
    options = from_text(sys.argv[1])
    module = importlib.import_module(f"mgjax.stage.apps.{options.app}.app")
    try:
        Worker(module.make_app(options), source, target).run()
    except MgjaxError as error:
        text = " ".join(str(error).split("\n"))
        target.write(frame(ALL, Kind.FAILED, text.encode()))
        target.flush()
        os._exit(2)
    os._exit(0)  # the reader may still block on its pipe


if __name__ == "__main__":
    main()
