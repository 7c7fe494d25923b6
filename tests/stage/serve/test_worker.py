"""The worker's loop on pipes in this process, with an application made for it."""

from __future__ import annotations

import io
import json
from typing import Any

import numpy as np

from mgjax.core.errors import ConfigError
from mgjax.stage.packet import unpack
from mgjax.stage.serve.session import Message, Progress, Send
from mgjax.stage.serve.wire import ALL, Kind, frame, read_frame
from mgjax.stage.serve.worker import Worker, newest


class Echo:
    """An application that answers what it is asked, and remembers what happened."""

    def __init__(self) -> None:
        self.log: list[Any] = []

    def prepare(self, progress: Progress) -> None:
        progress(0.5, "half")

    def open(self, send: Send) -> EchoSession:
        self.log.append("open")
        return EchoSession(self, send)

    def close(self) -> None:
        self.log.append("end")


class EchoSession:
    def __init__(self, app: Echo, send: Send) -> None:
        self.app, self.send = app, send

    def receive(self, message: Message) -> None:
        if message["type"] == "refuse":
            raise ConfigError(got="this", expected="that")
        if message["type"] == "fail":
            raise RuntimeError("a bug")
        if message["type"] == "array":
            self.send({"type": "array", "data": np.arange(3, dtype=np.float32)})
            return
        self.app.log.append(message)
        self.send({"type": "echo", "of": message})

    def tick(self) -> None:
        return

    def close(self) -> None:
        self.app.log.append("close")


def run(*frames: bytes) -> tuple[Echo, list[tuple[int, Kind, bytes]]]:
    """What an application saw of some frames, and what it said."""
    app, target = Echo(), io.BytesIO()
    Worker(app, io.BytesIO(b"".join(frames)), target).run()
    target.seek(0)
    said = []
    while (entry := read_frame(target)) is not None:
        said.append(entry)
    return app, said


def message(tab: int, **fields: Any) -> bytes:
    return frame(tab, Kind.TEXT, json.dumps(fields).encode())


def test_frames_come_back_and_half_a_frame_is_the_end():
    whole = frame(7, Kind.TEXT, b"abc")
    assert read_frame(io.BytesIO(whole)) == (7, Kind.TEXT, b"abc")
    assert read_frame(io.BytesIO(whole[:-1])) is None
    assert read_frame(io.BytesIO(whole[:3])) is None


def test_a_tab_is_opened_answered_and_closed():
    app, said = run(frame(1, Kind.OPEN), message(1, type="hello"), frame(1, Kind.CLOSE))
    assert app.log == ["open", {"type": "hello"}, "close", "end"]
    states = [json.loads(p) for tab, kind, p in said if kind == Kind.STATE and tab == ALL]
    assert [s["share"] for s in states] == [0.0, 0.5, 1.0]
    texts = [(tab, json.loads(p)) for tab, kind, p in said if kind == Kind.TEXT]
    assert texts == [(1, {"type": "echo", "of": {"type": "hello"}})]


def test_the_end_of_the_input_closes_what_is_open():
    app, _ = run(frame(1, Kind.OPEN), frame(2, Kind.OPEN))
    assert app.log == ["open", "open", "close", "close", "end"]


def test_bad_messages_become_sentences_and_nothing_stops(capsys):
    bad = [b"{", b"[]", b'{"a": 1}', b'{"type": 3}', b"[" * 100_000]
    frames = [frame(1, Kind.TEXT, payload) for payload in bad]
    app, said = run(
        frame(1, Kind.OPEN),
        *frames,
        message(1, type="refuse"),
        message(1, type="fail"),
        message(1, type="last"),
    )
    texts = [json.loads(p) for _, kind, p in said if kind == Kind.TEXT]
    sentences = [t["text"] for t in texts if t["type"] == "sentence"]
    assert len(sentences) == len(bad) + 2
    assert sentences[-2] == "got this, expected that"
    assert "log" in sentences[-1]
    assert {"type": "last"} in app.log
    assert "a bug" in capsys.readouterr().err


def test_arrays_go_as_bytes():
    _, said = run(frame(3, Kind.OPEN), message(3, type="array"))
    (payload,) = [p for tab, kind, p in said if kind == Kind.BYTES and tab == 3]
    np.testing.assert_array_equal(unpack(payload)["data"], [0, 1, 2])


def test_messages_to_tabs_that_are_not_open_are_dropped():
    app, _ = run(message(9, type="hello"), frame(9, Kind.CLOSE))
    assert app.log == ["end"]


def test_only_the_newest_of_waiting_messages_counts_where_they_say_so():
    def entry(tab: int, **fields: Any) -> tuple[int, Kind, bytes]:
        return tab, Kind.TEXT, json.dumps(fields).encode()

    entries = [
        entry(1, type="move", latest=True, to=1),
        entry(1, type="click"),
        entry(2, type="move", latest=True, to=2),
        entry(1, type="move", latest=True, to=3),
        entry(1, type="move", to=4),
        (1, Kind.TEXT, b'{"latest"'),
    ]
    assert newest(entries) == [entries[1], entries[2], entries[3], entries[4], entries[5]]
