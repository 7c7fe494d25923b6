"""What is read of packets, and that nothing in a packet can do harm."""

from __future__ import annotations

import math
import struct

import hypothesis
import hypothesis.strategies as st
import pytest
from pythonosc import osc_bundle_builder, osc_message_builder

from mgjax.sensor.packets import MAX_DEPTH, Packet, parse_packet

UPRIGHT = (0.0, 0.0, 0.0, 1.0)
BONE, ROOT = "/VMC/Ext/Bone/Pos", "/VMC/Ext/Root/Pos"
HEAD = b"#bundle\0" + struct.pack(">Q", 1)


def message(path: str, *values: object, kinds: str | None = None) -> bytes:
    """Made by python-osc."""
    builder = osc_message_builder.OscMessageBuilder(path)
    for number, value in enumerate(values):
        usual = {str: "s", int: "i", float: "f"}[type(value)]
        builder.add_arg(value, kinds[number] if kinds else usual)
    return builder.build().dgram


def bundle(*parts: bytes, head: bytes = HEAD) -> bytes:
    return head + b"".join(struct.pack(">i", len(part)) + part for part in parts)


def bone(name: str, place=(0.0, 0.0, 0.0), rotation=UPRIGHT) -> bytes:
    return message(BONE, name, *map(float, place), *map(float, rotation))


def test_reads_what_python_osc_writes() -> None:
    builder = osc_bundle_builder.OscBundleBuilder(1.7e9)  # type: ignore[arg-type]
    for path, values in (
        ("/VMC/Ext/OK", (1, 3, 0)),
        ("/VMC/Ext/T", (12.5,)),
        (ROOT, ("root", 1.0, 2.0, 3.0, 0.6, 0.0, 0.0, 0.8, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0)),
        (BONE, ("Hips", 0.5, -1.0, 2.0, 0.0, 0.0, -1.0, 0.0)),
        (BONE, ("LeftEye", 0.0, 0.0, 0.0, *UPRIGHT)),
        ("/VMC/Ext/Blend/Apply", ()),
    ):
        made = osc_message_builder.OscMessageBuilder(path)
        for value in values:
            made.add_arg(value)
        builder.add_content(made.build())
    packet = parse_packet(builder.build().dgram)
    assert (packet.malformed, packet.unknown, packet.loaded) == (0, 1, True)
    assert packet.time_s == 12.5
    assert packet.tag_s == pytest.approx(1.7e9 + 2208988800, abs=1e-3)  # counted from 1900
    assert packet.root == pytest.approx((1, 2, 3, 0.6, 0, 0, 0.8))
    assert packet.bones.keys() == {"Hips", "LeftEye"}
    assert packet.bones["Hips"] == (0.5, -1.0, 2.0, 0.0, 0.0, -1.0, 0.0)


def test_by_hand() -> None:
    assert parse_packet(b"/VMC/Ext/T\0\0,f\0\0\x3f\x80\0\0") == Packet(time_s=1.0)
    assert parse_packet(b"/VMC/Ext/OK\0,i\0\0\0\0\0\0") == Packet(loaded=False)
    assert parse_packet(HEAD) == Packet()
    assert not parse_packet(HEAD).useful


def test_any_number_type_is_taken_where_a_number_is_expected() -> None:
    assert parse_packet(b"/VMC/Ext/T\0\0,i\0\0\0\0\0\x07") == Packet(time_s=7.0)
    assert parse_packet(b"/VMC/Ext/T\0\0,h\0\0" + struct.pack(">q", 2**40)).time_s == 2.0**40
    assert parse_packet(b"/VMC/Ext/T\0\0,d\0\0" + struct.pack(">d", 0.1)).time_s == 0.1
    assert parse_packet(b"/VMC/Ext/OK\0,F\0\0") == Packet(loaded=False)
    assert parse_packet(b"/VMC/Ext/OK\0,T\0\0") == Packet(loaded=True)
    assert parse_packet(message("/VMC/Ext/OK", 1.0)) == Packet(loaded=True)
    mixed = b"/VMC/Ext/Bone/Pos\0\0\0,sidhfFFT\0\0\0Hips\0\0\0\0"
    mixed += struct.pack(">idqf", -1, 0.25, 2, 0.0)
    assert parse_packet(mixed).bones == {"Hips": (-1.0, 0.25, 2.0, 0.0, 0.0, 0.0, 1.0)}
    assert parse_packet(mixed[:-4]) == Packet(malformed=1)
    assert parse_packet(mixed.replace(b"sid", b"ssd")) == Packet(malformed=1)


BROKEN = {
    "nothing": b"",
    "no packet": b"hello\0\0\0",
    "three bytes": b"/a\0",
    "no end of address": b"/VMC/Ext/T",
    "bundle without a tag": b"#bundle\0",
    "negative size": HEAD + struct.pack(">i", -4),
    "size 0": HEAD + struct.pack(">i", 0),
    "odd size": HEAD + struct.pack(">i", 3) + b"/a\0",
    "too long": HEAD + struct.pack(">i", 2**31 - 1) + b"/a\0\0",
    "half a size": HEAD + b"\0\0",
    "no tags": b"/VMC/Ext/T\0\0",
    "other tags": message("/VMC/Ext/T", "now"),
    "few arguments": message(BONE, "Hips", 1.0, 2.0, 3.0),
    "cut numbers": bone("Hips")[:-4],
    "tags alone": b"/VMC/Ext/Bone/Pos\0\0\0,sfffffff\0\0\0",
    "doubles": message(BONE, "Hips", *(1.0,) * 7, kinds="sddddddd"),
    "long name": bone("H" * 60000),
    "name in another code": bone("HipX").replace(b"HipX", b"Hip\xff"),
    "not a number": bone("Hips", (math.nan, 0, 0)),
    "infinite": bone("Hips", (0, -math.inf, 0)),
    "far": bone("Hips", (0, 0, 1e30)),
    "no rotation": bone("Hips", rotation=(0, 0, 0, 0)),
    "long rotation": bone("Hips", rotation=(0, 0, 0, 2)),
    "rotation not a number": bone("Hips", rotation=(0, math.nan, 0, 1)),
    "huge rotation": bone("Hips", rotation=(3e38, 3e38, 3e38, 3e38)),
    "time not a number": message("/VMC/Ext/T", math.nan),
    "endless time": message("/VMC/Ext/T", math.inf),
}


@pytest.mark.parametrize("kind", BROKEN)
def test_broken_packets_are_counted(kind: str) -> None:
    packet = parse_packet(BROKEN[kind])
    assert packet == Packet(malformed=1)
    # Beside a good message only the bad one is lost, where the structure is sound.
    if BROKEN[kind].startswith(b"/VMC") and len(BROKEN[kind]) % 4 == 0:
        packet = parse_packet(bundle(BROKEN[kind], bone("Head")))
        assert (packet.malformed, list(packet.bones)) == (1, ["Head"])


def test_nested_bundles_end_somewhere() -> None:
    part = bone("Hips")
    for _ in range(MAX_DEPTH):
        part = bundle(part)
    assert list(parse_packet(part).bones) == ["Hips"]
    assert parse_packet(bundle(part)) == Packet(malformed=1)
    for _ in range(2500):
        part = bundle(part)
    assert parse_packet(part) == Packet(malformed=1)


def test_every_cut_of_a_packet_is_harmless() -> None:
    whole = bundle(message("/VMC/Ext/T", 1.0), bundle(bone("Hips"), bone("Head")), bone("Neck"))
    assert list(parse_packet(whole).bones) == ["Hips", "Head", "Neck"]
    for stop in range(len(whole)):
        packet = parse_packet(whole[:stop])
        assert packet.malformed or not set(packet.bones) - {"Hips", "Head"}


@hypothesis.given(st.binary(max_size=400))
def test_random_bytes(noise: bytes) -> None:
    for datagram in (noise, HEAD + noise, b"/VMC/Ext/Bone/Pos\0\0\0,sfffffff\0\0\0" + noise):
        packet = parse_packet(datagram)
        assert all(math.isfinite(v) for bone in packet.bones.values() for v in bone)


@hypothesis.given(st.data())
def test_spoiled_packets(data: st.DataObject) -> None:
    parts = [message("/VMC/Ext/T", 1.0), bone("Hips"), bundle(bone("Head"), bone("Neck"))]
    spoiled = bytearray(bundle(*parts))
    for _ in range(data.draw(st.integers(1, 8))):
        spoiled[data.draw(st.integers(0, len(spoiled) - 1))] = data.draw(st.integers(0, 255))
    packet = parse_packet(bytes(spoiled))
    assert packet.malformed + packet.unknown + len(packet.bones) <= 4
    assert packet.time_s is None or math.isfinite(packet.time_s)


def test_the_longest_packets() -> None:
    """As much as one datagram holds; a reader quadratic in the length would hang here."""
    assert list(parse_packet(bundle(*[bone("Hips")] * 700)).bones) == ["Hips"]
    assert parse_packet(bundle(*[b"/a\0\0"] * 8000)) == Packet(unknown=8000)
    assert parse_packet(bundle(*[b"/aaa"] * 8000)) == Packet(malformed=8000)
    tags = b"/VMC/Ext/Bone/Pos\0\0\0," + b"s" * 64000 + b"\0" * 3
    assert parse_packet(tags) == Packet(malformed=1)
    assert parse_packet(b"/" + b"a" * 65003) == Packet(malformed=1)
