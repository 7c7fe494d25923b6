import numpy as np
import pytest

from mgjax.core.errors import ConfigError
from mgjax.stage.serve import fields


def test_good_fields():
    message = {"a": 2, "flag": True, "name": "duck", "at": [1, 2.5, -3], "way": [[0, 1], [2, 3]]}
    assert fields.number(message, "a", 0, 2) == 2.0
    assert fields.whole(message, "a", 0, 2) == 2
    assert fields.flag(message, "flag")
    assert fields.text(message, "name", ("duck", "jump")) == "duck"
    assert fields.text(message, "name") == "duck"
    np.testing.assert_array_equal(fields.point(message, "at"), [1, 2.5, -3])
    np.testing.assert_array_equal(fields.points(message, "way", 2, size=2), [[0, 1], [2, 3]])
    assert fields.content({"text": "x,z\n1,2\n"}, "text") == "x,z\n1,2\n"


@pytest.mark.parametrize(
    "value", [None, True, "1", [1], {}, float("nan"), float("inf"), -0.1, 2.1, 10**400]
)
def test_what_is_no_number_in_range(value):
    with pytest.raises(ConfigError, match=r"got speed .*, expected 0 … 2"):
        fields.number({"speed": value}, "speed", 0, 2)


@pytest.mark.parametrize(
    "value",
    [None, [], [1, 2], [1, 2, 3, 4], [1, 2, "3"], [1, 2, None], [0, 0, 1e9], [0, 0, float("nan")]],
)
def test_what_is_no_place(value):
    with pytest.raises(ConfigError, match="got at"):
        fields.point({"at": value}, "at")


def test_too_many_points():
    with pytest.raises(ConfigError, match="expected 1 … 3 points"):
        fields.points({"way": [[0, 0, 0]] * 4}, "way", 3)


@pytest.mark.parametrize("value", [None, 3, "x" * 201, "a\nb", "a\x00"])
def test_what_is_no_text(value):
    with pytest.raises(ConfigError, match="got name"):
        fields.text({"name": value}, "name")


def test_unknown_choice():
    with pytest.raises(ConfigError, match="expected duck or jump"):
        fields.text({"name": "../../etc/passwd"}, "name", ("duck", "jump"))


def test_long_values_are_shortened():
    with pytest.raises(ConfigError) as caught:
        fields.flag({"on": "x" * 100_000}, "on")
    assert len(str(caught.value)) < 120
