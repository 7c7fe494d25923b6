from __future__ import annotations

import json
import math
import re

import hypothesis
import hypothesis.strategies as st
import pytest

from mgjax.core.errors import FileFormatError, LabelError
from mgjax.io.json_text import line_of, lines_of_values, parse_json, shown


def parse(text: str, **more):
    return parse_json("a.json", text, expected="a list", **more)


def test_numbers_are_floats() -> None:
    assert parse('{"a": [1, 2.5, true, null]}') == {"a": [1.0, 2.5, True, None]}
    assert type(parse("1")) is float
    assert parse("9" * 400) == math.inf
    assert parse('{"a": 1, "a": 2}') == {"a": 2.0}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1,\n2,,]", "a.json:2: got no JSON (Expecting value), expected a list"),
        ("[1", "a.json:1: got no JSON (Expecting ',' delimiter), expected a list"),
        ("[NaN]", "a.json: got NaN, expected finite numbers"),
        ("[-Infinity]", "a.json: got -Infinity, expected finite numbers"),
        ("[" * 100_000, "a.json: got JSON nested too deep, expected a JSON object"),
    ],
    ids=["line", "open", "nan", "infinity", "deep"],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(FileFormatError, match=f"^{re.escape(message)}$"):
        parse(text)


def test_the_kind_of_error_is_the_callers() -> None:
    for text in ("[", "[NaN]", "[" * 100_000):
        with pytest.raises(LabelError):
            parse(text, error=LabelError)
    with pytest.raises(FileFormatError, match="nested too deep, expected rows"):
        parse("[" * 100_000, nested="rows")
    assert math.isnan(parse("NaN", finite=False))

    def twice(key: str) -> FileFormatError:
        return LabelError("a.json", 7, f"{key} twice", "it once")

    with pytest.raises(LabelError, match=r"a\.json:7: got b twice, expected it once"):
        parse('{"a": {"b": 1, "b": 1}}', twice=twice)
    assert parse('{"a": {"b": 1}, "b": 1}', twice=twice) == {"a": {"b": 1.0}, "b": 1.0}


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ([1, 2], "a list of 2"),
        ([], "an empty list"),
        ({"a": 1}, "an object"),
        ("word", "'word'"),
        ("ü\n" * 30, ascii(("ü\n" * 30)[:37] + "...")),
        (1.50, "1.5"),
        (True, "true"),
        (None, "null"),
    ],
    ids=str,
)
def test_values_in_messages(value, text: str) -> None:
    assert shown(value) == text
    assert "\n" not in shown(value)


def test_lines() -> None:
    text = '{\n"a": [1,\n 2, {"b":\n 3}],\n\n"c": "x\\"]"\n}\n'
    assert lines_of_values(text) == {
        (): 1,
        ("a",): 2,
        ("a", 0): 2,
        ("a", 1): 3,
        ("a", 2): 3,
        ("a", 2, "b"): 3,
        ("c",): 6,
    }
    assert line_of(text, ("a", 2, "b", 5, "nothing")) == 3
    assert line_of(text, ("d",)) == 1


JSON = st.recursive(
    st.none() | st.booleans() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@hypothesis.given(JSON)
def test_every_value_has_a_line(value) -> None:
    text = json.dumps(value, indent=1)
    assert parse(text) == value
    lines = lines_of_values(text)

    def check(place: tuple, item) -> None:
        assert place in lines
        for key, inner in item.items() if isinstance(item, dict) else ():
            check((*place, key), inner)
            assert json.dumps(key) in text.split("\n")[lines[(*place, key)] - 1]
        for number, inner in enumerate(item) if isinstance(item, list) else ():
            check((*place, number), inner)

    check((), value)
