from __future__ import annotations

import numpy as np
import pytest

from mgjax.core.errors import MgjaxError
from mgjax.hybrid.paths.sketch import Sketch, make_sketch
from mgjax.hybrid.reaching.targets import make_target
from mgjax.stage.apps.sketch.files import read_upload, sketch_text, targets_text

SKETCHES = [
    make_sketch([[0, 0], [0.125, 3], [2, 5]]),
    make_sketch([[0, 0], [0, 3], [2, 5]], spline=True, closed=True, speed=1.25),
    make_sketch(
        [[0, 0], [0, 3]], speed=[1, 2], end=(0.5, 3, np.radians(90)), obstacles=[[1, 1, 0.2]]
    ),
    make_sketch([[0, 0], [0, 3]], end=(0.5, 3, np.nan)),
]
TARGETS = (
    make_target("right_hand", place=[0.6, 1.9, 4], when="passing", hold_s=0.25),
    make_target("left_hand", track=[[0, 0.3, 1.1, 6], [0.5, 0.3, 1.4, 6.2]], when=4.5),
    make_target("head", bar=([-1, 1.5, 8], [1, 1.5, 8], 0.03)),
    make_target("head", place=[0, 1.4, 1], when="start", hold_s=0),
)


@pytest.mark.parametrize("sketch", SKETCHES)
def test_a_sketch_is_read_back_as_it_was(sketch: Sketch) -> None:
    read = read_upload("path.json", sketch_text(sketch))
    assert isinstance(read, Sketch)
    for name in ("points", "speed", "obstacles"):
        np.testing.assert_array_equal(getattr(read, name), getattr(sketch, name))
    assert (read.spline, read.closed) == (sketch.spline, sketch.closed)
    np.testing.assert_allclose(
        read.end or (0, 0, 0), sketch.end or (0, 0, 0), rtol=1e-12, equal_nan=True
    )


def test_targets_are_read_back_as_they_were() -> None:
    read = read_upload("targets.json", targets_text(TARGETS))
    assert isinstance(read, tuple)
    for one, other in zip(read, TARGETS, strict=True):
        assert (one.limb, one.when, one.hold_s) == (other.limb, other.when, other.hold_s)
        np.testing.assert_array_equal(one.places, other.places)
        np.testing.assert_array_equal(one.seconds, other.seconds)
        if other.bar is not None:
            assert one.bar is not None
            np.testing.assert_array_equal(one.bar.ends, other.bar.ends)
            assert one.bar.radius == other.bar.radius


def test_a_table_of_places_is_a_path_whatever_folder_its_name_claims() -> None:
    read = read_upload("../../etc/points.csv", "x,z\n0,0\n0,3\n")
    assert isinstance(read, Sketch)
    np.testing.assert_array_equal(read.points, [[0, 0], [0, 3]])


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("path.json", "", "path.json: got an empty file"),
        ("path.json", "{", "path.json:1: got no JSON"),
        ("path.json", "[" * 9999, "path.json: got JSON nested too deep"),
        ("path.json", '{"points": [[0, 0]]}', "path.json: got a path of 1 point"),
        ("path.json", '{"pts": []}', "path.json: got no points"),
        ("targets.json", '[{"limb": "tail", "place": [0, 1, 2], "when": 1}]', "the limb 'tail'"),
        ("targets.json", '{"targets": 3}', "targets.json: got something else"),
        ("path.csv", "a,b\n1,2\n", "path.csv:1: got"),
        ("path.csv", "0,0\n\0", "got binary data"),
        ("", "0,0\n", "file: got a path of 1 point"),
    ],
)
def test_what_is_no_path_is_refused_with_its_name(name: str, text: str, said: str) -> None:
    with pytest.raises(MgjaxError) as caught:
        read_upload(name, text)
    assert said in str(caught.value)
