"""A film made of the pictures that a page sends, one after another."""

from __future__ import annotations

import base64
import binascii
import subprocess
import tempfile
from pathlib import Path
from typing import IO, Any

import numpy as np

from mgjax.core.errors import ConfigError, MgjaxError
from mgjax.stage.serve.fields import content, whole
from mgjax.stage.serve.session import Message

MOST_FRAMES = 3600
_PREFIX = "data:image/jpeg;base64,"


class Film:
    """Takes the frames of one film of one page; a new first frame begins another.

    A message is ``{"type": "film", "frame": 0 …, "frames", "rate", "data"}`` with a JPEG as a data
    URL; the last one is answered with the file.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._next = 0

    def receive(self, message: Message) -> Message | None:
        """Takes a frame; returns the film after the last.

        Raises:
            MgjaxError: it is no frame, or there is no encoder.
        """
        count = whole(message, "frames", 1, MOST_FRAMES)
        number = whole(message, "frame", 0, count - 1)
        rate = whole(message, "rate", 1, 120)
        picture = _jpeg(content(message, "data"))
        if number == 0:
            self.close()
            self._begin(rate)
        if self._process is None or number != self._next:
            raise ConfigError(got=f"frame {number}", expected=f"frame {self._next} of a film")
        self._write(picture)
        self._next += 1
        return self._end() if number == count - 1 else None

    def close(self) -> None:
        """Gives up a film that is not finished."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
        if self._folder is not None:
            self._folder.cleanup()
        self._process, self._folder, self._next = None, None, 0

    def _begin(self, rate: int) -> None:
        try:
            from imageio_ffmpeg import get_ffmpeg_exe
        except ImportError:
            raise MgjaxError(
                got="no encoder of films", expected="one: pip install 'mgjax[video]'"
            ) from None
        self._folder = tempfile.TemporaryDirectory()
        options = ["-y", "-loglevel", "error", "-f", "image2pipe", "-c:v", "mjpeg"]
        options += ["-framerate", str(rate), "-i", "-"]
        # Both sides have to be even for the colours that every player shows.
        options += ["-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", "-c:v", "libx264"]
        options += ["-pix_fmt", "yuv420p", "-crf", "20", "-movflags", "+faststart"]
        self._process = subprocess.Popen(
            [get_ffmpeg_exe(), *options, str(self._path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )

    @property
    def _path(self) -> Path:
        assert self._folder is not None
        return Path(self._folder.name) / "film.mp4"

    def _write(self, picture: bytes) -> None:
        stream: IO[Any] | None = None if self._process is None else self._process.stdin
        assert stream is not None
        try:
            stream.write(picture)
        except BrokenPipeError:
            self.close()
            raise MgjaxError(got="pictures that cannot be encoded", expected="JPEGs") from None

    def _end(self) -> Message:
        assert self._process is not None
        _, said = self._process.communicate()
        status = self._process.returncode
        data = self._path.read_bytes() if status == 0 and self._path.exists() else b""
        self._process = None
        self.close()
        if not data:
            words = said.decode(errors="replace").strip().split("\n")[-1]
            raise MgjaxError(got=f"a film that cannot be encoded ({words})", expected="JPEGs")
        return file_message("film.mp4", "video/mp4", data)


def file_message(name: str, mime: str, data: bytes) -> Message:
    """A file that the page saves."""
    return {"type": "file", "name": name, "mime": mime, "data": np.frombuffer(data, np.uint8)}


def _jpeg(text: str) -> bytes:
    if not text.startswith(_PREFIX):
        raise ConfigError(got=f"a picture that begins {text[:24]!r}", expected=_PREFIX)
    try:
        data = base64.b64decode(text[len(_PREFIX) :], validate=True)
    except (binascii.Error, ValueError):
        data = b""
    if not data.startswith(b"\xff\xd8"):
        raise ConfigError(got="a picture that is no JPEG", expected="one")
    return data
