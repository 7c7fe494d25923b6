"""Packets from a motion sensor, read without trust: OSC 1.0 (UDP) that carries the VMC protocol.

The VMC protocol (protocol.vmc.info): ``/VMC/Ext/Root/Pos`` and ``/VMC/Ext/Bone/Pos`` have a name,
a place (x, y, z) and a rotation (x, y, z, w), local to the parent; ``/VMC/Ext/T`` has the sender's
relative time in seconds, ``/VMC/Ext/OK`` whether a body is loaded. Unknown addresses and
arguments in excess are ignored, as it says; so are these messages with other or too few arguments,
which are counted. The protocol has floats (``f``) for places and an integer (``i``) for the state;
senders in scripting languages write what their numbers look like, so that each of the number types
``i h f d T F`` of OSC 1.0 is taken wherever a number is expected.

python-osc sends, but does not read here: its reader does not come to an end on a bundle with an
element of negative size, recurses as deep as bundles are nested, takes missing bytes of a number
for zeros, and writes a log line for each thing that it does not know.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

_BUNDLE = b"#bundle\0"
_HEAD = len(_BUNDLE) + 8
_AT_ONCE = 1
"""Time tag of a bundle that is meant to be handled at once and says nothing of the time."""
MAX_DEPTH = 8
"""Bundles in bundles; VMC senders use one level."""
MAX_NAME = 64
"""Bytes of a bone's name."""
MAX_PLACE_M = 1000.0
"""A place farther away is a broken one."""
MAX_TIME_S = 1e13
"""Milliseconds since 1970 are below it."""

_BONE, _ROOT, _TIME, _OK = (
    b"/VMC/Ext/Bone/Pos",
    b"/VMC/Ext/Root/Pos",
    b"/VMC/Ext/T",
    b"/VMC/Ext/OK",
)
_NUMBERS = {_BONE: 7, _ROOT: 7, _TIME: 1, _OK: 1}
"""How many numbers a message has; with seven of them comes a name before."""
_NUMBER_FORMS = {"i": "i", "h": "q", "f": "f", "d": "d", "T": "", "F": ""}
"""How the number types of OSC are packed; true and false are in the tag alone."""

Transform = tuple[float, ...]
"""Place x, y, z (m) and unit rotation x, y, z, w, as sent."""


@dataclass(kw_only=True)
class Packet:
    """What is of use in one datagram.

    Attributes:
        bones: transforms by name; of two with one name the later.
        root: that of the model, or None.
        time_s: the sender's relative time, or None.
        tag_s: time tag of the outer bundle, s, or None.
        loaded: whether the sender says that it has a body, or None.
        malformed: messages (or one for the whole datagram) that are broken.
        unknown: messages with another address.
    """

    bones: dict[str, Transform] = field(default_factory=dict)
    root: Transform | None = None
    time_s: float | None = None
    tag_s: float | None = None
    loaded: bool | None = None
    malformed: int = 0
    unknown: int = 0

    @property
    def useful(self) -> bool:
        """Whether anything in it was understood."""
        return bool(self.bones) or any(
            value is not None for value in (self.root, self.time_s, self.loaded)
        )


class _Malformed(Exception):
    """A message or a bundle that is not what it claims to be."""


def parse_packet(datagram: bytes) -> Packet:
    """Reads one datagram; never raises. One with a broken structure is dropped whole."""
    try:
        messages = list(_messages(datagram))
    except _Malformed:
        return Packet(malformed=1)
    packet = Packet(tag_s=_time_tag(datagram))
    for message in messages:
        try:
            _take(packet, message)
        except _Malformed:
            packet.malformed += 1
    return packet


def _messages(datagram: bytes) -> Iterator[bytes]:
    """The messages of a datagram, in order, out of bundles of any legal depth."""
    waiting = [(datagram, 0)]
    while waiting:
        part, depth = waiting.pop()
        if len(part) % 4 or depth > MAX_DEPTH:
            raise _Malformed
        if part[:1] == b"/":
            yield part
            continue
        if not part.startswith(_BUNDLE) or len(part) < _HEAD:
            raise _Malformed
        inner: list[tuple[bytes, int]] = []
        at = _HEAD
        while at < len(part):
            (size,) = struct.unpack_from(">i", part, at)
            at += 4
            if size <= 0 or at + size > len(part):
                raise _Malformed
            inner.append((part[at : at + size], depth + 1))
            at += size
        waiting += reversed(inner)


def _time_tag(datagram: bytes) -> float | None:
    if not datagram.startswith(_BUNDLE):
        return None
    (tag,) = struct.unpack_from(">Q", datagram, len(_BUNDLE))
    return None if tag <= _AT_ONCE else tag / 2**32


def _take(packet: Packet, message: bytes) -> None:
    """Adds one message to what is known of its packet."""
    address, at = _string(message, 0, len(message))
    count = _NUMBERS.get(address)
    if count is None:
        packet.unknown += 1
        return
    tags, at = _string(message, at, len(message))
    named = b"s" if count == 7 else b""
    if not tags.startswith(b"," + named):
        raise _Malformed
    kinds = tags[1 + len(named) :][:count].decode("latin-1")
    raw = b""
    if named:
        raw, at = _string(message, at, MAX_NAME)
    values = _numbers(message, at, kinds, count)
    if address == _TIME:
        if not abs(values[0]) <= MAX_TIME_S:
            raise _Malformed
        packet.time_s = values[0]
    elif address == _OK:
        packet.loaded = values[0] != 0
    elif address == _ROOT:
        packet.root = _transform(values)
    else:
        try:
            packet.bones[raw.decode()] = _transform(values)
        except UnicodeDecodeError:
            raise _Malformed from None


def _string(message: bytes, start: int, longest: int) -> tuple[bytes, int]:
    """A string that ends with one to four zeros, and where it is over."""
    end = message.find(b"\0", start, start + longest + 1)
    after = start + (end - start) // 4 * 4 + 4
    if end < 0 or after > len(message):
        raise _Malformed
    return message[start:end], after


def _numbers(message: bytes, start: int, kinds: str, count: int) -> tuple[float, ...]:
    """So many numbers of any of OSC's number types."""
    if len(kinds) < count or not _NUMBER_FORMS.keys() >= set(kinds):
        raise _Malformed
    form = ">" + "".join(_NUMBER_FORMS[kind] for kind in kinds)
    if start + struct.calcsize(form) > len(message):
        raise _Malformed
    packed = iter(struct.unpack_from(form, message, start))
    return tuple(float(kind == "T" if kind in "TF" else next(packed)) for kind in kinds)


def _transform(values: tuple[float, ...]) -> Transform:
    """Checked, with a rotation of unit length to the last digit."""
    place, rotation = values[:3], values[3:]
    # Written so that a value that is not a number fails, too.
    length = math.hypot(*rotation)
    if not (all(abs(v) <= MAX_PLACE_M for v in place) and 0.9 <= length <= 1.1):
        raise _Malformed
    return (*place, *(v / length for v in rotation))
