"""Why nothing is heard, in one sentence."""

from __future__ import annotations

import re

import pytest

from mgjax.sensor.counts import Counts, why_nothing
from mgjax.sensor.frames import FrameAssembler
from tests.sensor.test_frames import NAMES, legs, settled, stamp
from tests.sensor.test_packets import bone, bundle, message

PLACE = "127.0.0.1:39539"


def after(*datagrams: bytes, source: object = ("127.0.0.1", 5)) -> Counts:
    assembler = FrameAssembler()
    for number, datagram in enumerate(datagrams):
        assembler.feed(datagram, 0.01 * number, source)
    return assembler.counts


CASES = {
    "nothing": ([], "no packet came on 127.0.0.1:39539: expected a sender"),
    "noise": ([b"noise"] * 3, "3 packets came on 127.0.0.1:39539, 3 of them broken: expected OSC"),
    "no bones": (
        [stamp(k) for k in range(4)] + [message("/VMC/Ext/Blend/Apply")],
        "5 packets came on 127.0.0.1:39539, but none had a bone .* .1 messages with other",
    ),
    "other names": (
        [bundle(stamp(k), bone("J_Bip_C_Hips")) for k in range(4)],
        "bones have names such as 'J_Bip_C_Hips', expected those of Unity",
    ),
    "no hips": (
        [bundle(stamp(k), *legs(k, NAMES[1:])) for k in range(30)],
        "30 packets .* with 180 bones, but without Hips: a body",
    ),
    "no body": (
        [bundle(stamp(k), message("/VMC/Ext/OK", 0), *legs(k)) for k in range(30)],
        "in 30 frames the sender says that it has no body loaded",
    ),
    "few frames": ([bundle(stamp(0), *legs(0))], "1 packets .* 7 bones: too few frames"),
}


@pytest.mark.parametrize("kind", CASES)
def test_why(kind: str) -> None:
    datagrams, words = CASES[kind]
    sentence = why_nothing(after(*datagrams), PLACE)
    assert re.search(words, sentence), sentence
    assert "\n" not in sentence


def test_another_sender() -> None:
    assembler = FrameAssembler()
    assembler.feed(stamp(0), 0.0, ("127.0.0.1", 5))
    for k in range(5):
        assembler.feed(bundle(stamp(k), *legs(k)), 0.1, ("127.0.0.1", 6))
    sentence = why_nothing(assembler.counts, PLACE)
    assert "6 packets" in sentence
    assert "5 of them from another address than 127.0.0.1:5, which was first" in sentence


def test_nothing_to_say() -> None:
    assembler = settled()
    assert assembler.counts.frames > 0
    assert why_nothing(assembler.counts, PLACE) == ""
