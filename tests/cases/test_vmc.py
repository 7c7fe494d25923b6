"""Records of VMC streams, as other senders write them."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import numpy as np
import pytest

from mgjax.sensor.frames import FrameAssembler, SensorFrame
from tests.cases.inputs import case_file, cases

FRAMES = 41
FAULTS = {
    "usual": "",
    "root_with_scale_and_offset": "",
    "single_messages": "",
    "zero_places_as_ints": "",
    "places_as_doubles": "",
    "unix_time": "stands still",
    "time_never_changes": "stands still",
}
"""What is said of the sender's clock; as a float of four bytes the time since 1970 stands still."""


def datagrams(name: str) -> Iterator[tuple[float, bytes]]:
    """Time of arrival and bytes of each."""
    record, at = case_file(f"vmc/{name}.vmcrec").read_bytes(), 0
    while at < len(record):
        arrival, size = struct.unpack_from(">dI", record, at)
        at += struct.calcsize(">dI")
        yield arrival, record[at : at + size]
        at += size


def heard(name: str) -> tuple[FrameAssembler, list[SensorFrame]]:
    assembler = FrameAssembler()
    frames = [f for arrival, data in datagrams(name) for f in assembler.feed(data, arrival)]
    return assembler, frames


@pytest.mark.parametrize("name", FAULTS)
def test_frames_and_joints(name: str) -> None:
    _, wanted = heard("usual")
    assembler, frames = heard(name)
    counts = assembler.counts
    assert len(frames) == len(wanted) == counts.frames == FRAMES
    assert (counts.malformed, counts.stale, counts.streams) == (0, 0, 1)
    assert counts.clock_fault.startswith(FAULTS[name])
    assert bool(counts.clock_fault) == bool(FAULTS[name])
    for frame, same in zip(frames, wanted, strict=True):
        assert frame.body.names == same.body.names
        miss = np.linalg.norm(frame.positions - same.positions, axis=-1)
        head = frame.body.index("head")
        if name == "zero_places_as_ints":
            # The head of the usual stream has a place that its neck, of two joints there, moves by
            # up to 2 mm. A stream without places does not say so.
            assert miss[head] < 2e-3
            miss = np.delete(miss, head)
        assert miss.max() < 1e-4
    steps = np.diff([frame.time_s for frame in frames])
    np.testing.assert_allclose(steps, 1 / 30, atol=1e-3)


def test_all_cases_are_tested() -> None:
    case_file("expected.json")
    assert {entry["input"] for entry in cases("vmc")} == {f"vmc/{n}.vmcrec" for n in FAULTS}
