from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mgjax.core.errors import FileFormatError, ReachError
from mgjax.hybrid.reaching.targets import load_targets, make_target

HAND = {"limb": "right_hand", "place": [0, 1, 2], "when": 1.5}


def test_file(tmp_path: Path) -> None:
    file = tmp_path / "reach.json"
    rows = [
        {**HAND, "hold_s": 0.2},
        {"limb": "left_hand", "track": [[0, 0, 1, 2], [1, 0, 1.5, 2]], "when": "end"},
        {"limb": "head", "bar": {"from": [-1, 1.4, 3], "to": [1, 1.4, 3], "radius": 0.05}},
    ]
    file.write_text(json.dumps({"targets": rows}))
    hand, moving, bar = load_targets(file)
    assert (hand.limb, hand.when, hand.hold_s) == ("right_hand", 1.5, 0.2)
    np.testing.assert_array_equal(hand.at(np.array([-1.0, 0, 9])), [[0, 1, 2]] * 3)
    assert (moving.when, moving.hold_s) == ("end", 1.0)
    np.testing.assert_allclose(moving.at(np.array([-1, 0.5, 2]))[:, 1], [1, 1.25, 1.5])
    assert bar.bar is not None
    assert bar.bar.radius == 0.05
    file.write_text(json.dumps(rows))
    assert len(load_targets(file)) == 3


@pytest.mark.parametrize(
    ("row", "word"),
    [
        ({**HAND, "limb": "tail"}, "'tail'"),
        ({**HAND, "place": [0, -0.1, 2]}, "under the floor"),
        ({**HAND, "place": [0, 1]}, "expected numbers"),
        ({**HAND, "place": "here"}, "expected numbers"),
        ({**HAND, "place": [0, 1, 2e6]}, "finite"),
        ({"limb": "right_hand", "place": [0, 1, 2]}, "no time"),
        ({**HAND, "when": "soon"}, "when = 'soon'"),
        ({**HAND, "when": -1}, "when = -1"),
        ({**HAND, "when": True}, "when = True"),
        ({**HAND, "hold_s": "long"}, "hold_s"),
        ({**HAND, "hold_s": 1e9}, "hold_s"),
        ({**HAND, "speed": 1}, "'speed'"),
        ({"limb": "right_hand", "when": 1}, "no place"),
        ({**HAND, "track": [[0, 1, 1, 1]]}, "place and track"),
        ({"limb": "left_hand", "track": [[1, 1, 1, 1]], "when": 1}, "times"),
        ({"limb": "left_hand", "bar": {"from": [0, 1, 0], "to": [1, 1, 0]}}, "a bar for the left"),
        ({"limb": "head", "bar": {"from": [0, 1, 0]}}, "the bar"),
        ({"limb": "head", "bar": {"from": [0, 1, 0], "to": [0, 1, 0]}}, "no length"),
        ({"limb": "head", "bar": {"from": [0, 1, 0], "to": [1, 1, 0]}, "when": 2}, "no time"),
        (
            {"limb": "head", "bar": {"from": [0, 1, 0], "to": [1, 1, 0], "radius": -1}},
            "radius",
        ),
        ({"place": [0, 1, 2]}, "without a limb"),
        (3, "without a limb"),
    ],
)
def test_bad_targets(tmp_path: Path, row: object, word: str) -> None:
    file = tmp_path / "reach.json"
    file.write_text(json.dumps([row]))
    with pytest.raises(FileFormatError, match="expected") as caught:
        load_targets(file)
    assert word in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"a": 1}', "[1", "[" * 5000, '[{"limb": NaN}]'])
def test_bad_files(tmp_path: Path, text: str) -> None:
    file = tmp_path / "reach.json"
    file.write_text(text)
    with pytest.raises(FileFormatError, match="expected"):
        load_targets(file)


def test_numbers_that_are_not_finite() -> None:
    with pytest.raises(ReachError, match="finite"):
        make_target("head", place=[0, np.nan, 0], when=1.0)
