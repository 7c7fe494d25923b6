"""The page reads and writes the same packets as Python does."""

import base64

import numpy as np
import pytest

from mgjax.stage.packet import TYPES, pack, unpack
from mgjax.stage.show.types import show_value

from .shows import actor, show_of

AGAIN = """bytes => {
  const data = Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0));
  const out = new Uint8Array(bench.packet.pack(bench.packet.unpack(data.buffer)));
  let text = '';
  for (const byte of out) text += String.fromCharCode(byte);
  return btoa(text);
}"""


@pytest.fixture(scope="module")
def page(shared_bench):
    return shared_bench(show_of())


def again(page, value):
    """The value after the page has read and written it."""
    text = page.evaluate(AGAIN, base64.b64encode(pack(value)).decode())
    return unpack(base64.b64decode(text))


def same(a, b):
    if isinstance(a, dict):
        assert isinstance(b, dict)
        assert a.keys() == b.keys()
        for key in a:
            same(a[key], b[key])
    elif isinstance(a, list):
        assert len(a) == len(b)
        for x, y in zip(a, b, strict=True):
            same(x, y)
    elif isinstance(a, np.ndarray):
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    else:
        assert isinstance(a, bool) == isinstance(b, bool)
        assert a == b


def test_packets_come_back_the_same(page):
    arrays = {name: np.arange(7).astype(name).reshape(1, 7) for name in TYPES}
    plain = {"text": "Ä – 球", "none": None, "flag": True, "list": [1, 2.5, -3e-7], "empty": {}}
    nothing = np.zeros((0, 3), np.float32)
    for value in (arrays, plain, {"a": [arrays, plain]}, {"nothing": nothing}):
        same(again(page, value), unpack(pack(value)))
    show = show_value(show_of(actor("duck", look="ghost", note="Übung")))
    same(again(page, show), unpack(pack(show)))


@pytest.mark.parametrize("bad", ["", "XXXXXXXXXXXX", "MGS1\x02\x00\x00\x00{}"])
def test_bytes_that_are_no_packet_are_refused(page, bad):
    said = page.evaluate(
        """bad => {
          const data = Uint8Array.from(bad, (c) => c.charCodeAt(0));
          try {
            bench.packet.unpack(data.buffer);
          } catch (error) {
            return error.message;
          }
          return null;
        }""",
        bad,
    )
    assert said


def test_numbers_that_are_not_finite_are_not_packed(page):
    said = page.evaluate(
        """() => {
          try {
            bench.packet.pack({ a: NaN });
          } catch (error) {
            return error.message;
          }
          return null;
        }"""
    )
    assert "finite" in said
