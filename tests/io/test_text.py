from __future__ import annotations

import pytest

from mgjax.core.errors import FileFormatError
from mgjax.io.text import check_size, is_count, parse_number, quoted, read_text, split_lines


@pytest.mark.parametrize("token", ["1", "-1.5", "+.5", "5.", "1e3", "1E-3"])
def test_numbers(token):
    assert parse_number("f", 1, token, "x") == float(token)


@pytest.mark.parametrize("token", ["", "x", "1_0", "٣", "²", "0x1", "1,5", "1e", "--1"])
def test_no_numbers(token):
    with pytest.raises(FileFormatError, match="a number for x"):
        parse_number("f", 3, token, "x")


@pytest.mark.parametrize("token", ["nan", "inf", "-Infinity", "1e999"])
def test_numbers_that_are_not_finite(token):
    with pytest.raises(FileFormatError, match=r"f:3: got .*a finite number for x"):
        parse_number("f", 3, token, "x")


def test_counts():
    assert is_count("0")
    assert is_count("999999999999")
    for token in ("", "-1", "1.0", "²", "٣", "9" * 13, "9" * 5000):
        assert not is_count(token)


def test_lines_end_at_lf_crlf_and_cr_only():
    assert split_lines("a\nb\r\nc\rd\x0be\u2028f\x85g") == ["a", "b", "c", "d\x0be\u2028f\x85g"]


def test_quoted_is_short_and_on_one_line():
    assert quoted("abc") == "'abc'"
    assert quoted("a\nb\x1bc²") == r"'a\nb\x1bc\xb2'"
    assert len(quoted("x" * 10**6)) <= 50


def test_size():
    check_size("f", 100_000, 1000)
    with pytest.raises(FileFormatError, match="100001 frames of 1000 joints"):
        check_size("f", 100_001, 1000)


def test_encodings(tmp_path):
    file = tmp_path / "f"
    for encoding in ("utf-8", "utf-8-sig", "latin-1"):
        file.write_bytes("Rücken".encode(encoding))
        assert read_text(file, "BVH") == "Rücken"
