from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from mgjax.core.errors import FileFormatError, PathError
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.sketch import load_sketch, make_sketch

STROKE = [[0.05 * i, 0.0] for i in range(40)]


def test_csv(tmp_path: Path) -> None:
    file = tmp_path / "path.csv"
    file.write_text("x,z\n0,0\n# a corner\n0, 3\r\n4,3\n\n")
    sketch = load_sketch(file)
    assert sketch.points.tolist() == [[0, 0], [0, 3], [4, 3]]
    assert np.isnan(sketch.speed).all()
    assert not sketch.closed
    file.write_text("0,0,1.5\n0,3,2\n4,3,1\n0,0,1.5\n")
    sketch = load_sketch(file, spline=True)
    assert (sketch.closed, sketch.spline, len(sketch.points)) == (True, True, 3)
    assert sketch.speed.tolist() == [1.5, 2, 1]


@pytest.mark.parametrize(
    "text",
    [
        "x\tz\tspeed\n0\t0\t1\n0.5\t1\t1\n1.25\t2.5\t2\n",
        "0 0 1\n 0.5  1 1\n1.25 2.5 2 # the end\n",
        "0;0;1\n0.5;1;1\n1.25; 2.5; 2\n",
        "X;Z;Speed\n0;0;1\n0,5;1;1\n1,25;2,5;2\n",
        "'x','z','speed'\n\"0\",\"0\",\"1\"\n'0.5', '1' ,1\n1.25,2.5,2\n",
        '"0";"0";"1"\n"0,5";"1";"1"\n"1,25";"2,5";"2"\n',
        "0,0,1\n0,0,3\n0.5,1,1\n0.5,1,1\n0.5,1,1\n1.25,2.5,2\n1.25,2.5,2\n",
    ],
)
def test_csv_of_other_tools(tmp_path: Path, text: str) -> None:
    file = tmp_path / "path.csv"
    file.write_text(text)
    sketch = load_sketch(file)
    assert sketch.points.tolist() == [[0, 0], [0.5, 1], [1.25, 2.5]]
    assert sketch.speed.tolist() == [1, 1, 2]


def test_a_closed_path_that_rests_where_it_began() -> None:
    sketch = make_sketch([[0, 0], [0, 0], [2, 0], [2, 2], [0, 0], [0, 0]])
    assert sketch.closed
    assert sketch.points.tolist() == [[0, 0], [2, 0], [2, 2]]


def test_json(tmp_path: Path) -> None:
    file = tmp_path / "path.json"
    document = {
        "points": [[0, 0], [0, 3], [2, 5]], "spline": True, "speed": 1.2,
        "end": {"place": [2, 5], "heading_deg": 90}, "obstacles": [[1, 4, 0.3]],
    }  # fmt: skip
    file.write_text(json.dumps(document))
    sketch = load_sketch(file)
    assert sketch.end == (2, 5, math.pi / 2)
    assert sketch.obstacles.tolist() == [[1, 4, 0.3]]
    assert sketch.speed.tolist() == [1.2] * 3
    file.write_text("[[0, 0], [1, 1]]")
    assert load_sketch(file, closed=True).closed


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0,0\n", ("1 point", "at least two")),
        ("x,z\n", ("no points",)),
        ("0,0\n0,0\n0,0\n", ("1 point", "at least two that are apart")),
        ("0,0\n0,5 1,5\n", (":2:", "'0,5 1,5'", "x;z with decimal commas")),
        ("0,0\n0,5\t1,5\n", (":2:", "x;z with decimal commas")),
        ('"0,5","1"\n0,2\n', (":1:", "x;z with decimal commas")),
        ("0;0\n0.5;1\n1,5;2\n", (":3:", "'1,5'", "the decimal mark of the lines before")),
        ("0;0\n1.234,5;2\n", (":2:", "one decimal mark")),
        ("0;0\n1,234,5;2\n", (":2:", "one decimal mark")),
        ("0\t0\n0\t1\t2\n", (":2:", "3 values")),
        ("0,0\n0,nan\n", (":2:", "finite")),
        ("0,0\n0,inf\n", (":2:", "finite")),
        ("0,0\n1\n", (":2:", "1 value")),
        ("0,0\n1,2,3\n", (":2:", "3 values")),
        ("x,z,time\n0,0,1\n", (":1:", "x,z,speed")),
        ("0,0\na,1\n", (":2:", "a number")),
        ("0,0\n0,1\n0,500\n0,501\n", ("jump", "point 2")),
        ("".join(f"{x},{z}\n" for x, z in [*STROKE, (5, 0)]), ("jump of 3.05 m", "point 40")),
        ("".join(f"{x},{z}\n" for x, z in [*STROKE[:9], (9, 9), *STROKE[9:]]), ("jump",)),
        ("0,0\n0,2000\n", ("2e+03 m",)),
        ("0,0,-1\n0,3,1\n", ("speed -1 at point 1",)),
        ("", ("empty",)),
    ],
)
def test_bad_csv(tmp_path: Path, text: str, words: tuple[str, ...]) -> None:
    file = tmp_path / "bad.csv"
    file.write_text(text)
    with pytest.raises(FileFormatError) as caught:
        load_sketch(file)
    message = str(caught.value)
    assert "\n" not in message
    for word in (str(file), "got ", ", expected ", *words):
        assert word in message


@pytest.mark.parametrize(
    ("document", "word"),
    [
        ({"points": [[0, 0], [0, 1, 2]]}, "lists of 2 numbers"),
        ({"points": [[0, 0], [0, "a"]]}, "lists of 2 numbers"),
        ({"points": [[0, 0], [0, 3]], "spede": 1}, "spede"),
        ({"points": [[0, 0], [0, 3]], "speed": [1]}, "one for each point"),
        ({"points": [[0, 0], [0, 3]], "closed": 1}, "true or false"),
        ({"points": [[0, 0], [0, 3]], "end": [1, 2]}, "place"),
        ({"points": [[0, 0], [0, 3]], "obstacles": [[1, 2]]}, "lists of 3 numbers"),
        ({"points": [[0, 0], [0, 3]], "obstacles": [[1, 2, -1]]}, "no circle"),
        ({"path": []}, "points"),
        (3, "points"),
    ],
)
def test_bad_json(tmp_path: Path, document: object, word: str) -> None:
    file = tmp_path / "bad.json"
    file.write_text(json.dumps(document))
    with pytest.raises(FileFormatError, match=word):
        load_sketch(file)
    file.write_text('{"points": [[0, 0], [0, NaN]]}')
    with pytest.raises(FileFormatError, match="NaN"):
        load_sketch(file)


def test_what_is_no_jump() -> None:
    make_sketch([[0, 0], [0, 30], [1, 30], [1, 0]], closed=True)
    make_sketch([[0, 0], [0, 100]])
    make_sketch([*STROKE, [2.9, 0]])  # 0.95 m
    with pytest.raises(PathError, match="numbers"):
        make_sketch([[0, 0], ["a", 1]])


def test_polyline_by_hand() -> None:
    curve = make_curve(make_sketch([[0, 0], [0, 3], [4, 3]], speed=[1, 2, 3]))
    assert curve.length == 7
    np.testing.assert_allclose(
        curve.at(np.array([-1.0, 2.0, 5.0, 9.0])), [[0, 0], [0, 2], [2, 3], [4, 3]]
    )
    np.testing.assert_allclose(curve.start(), [0, 0, 0])
    places = np.array([[1.0, 1.0], [2.0, 2.5]])
    away, along = curve.nearest(places, np.array([1.0, 5.0]))
    np.testing.assert_allclose(away, [1.0, 0.5], atol=1e-6)
    np.testing.assert_allclose(along, [1.0, 5.0], atol=1e-6)
    # Only the part of the path around the arc length counts.
    assert curve.nearest(np.array([[4.0, 3.0]]), np.array([0.0]))[0] > 3.5


def test_closed_polyline() -> None:
    curve = make_curve(make_sketch([[0, 0], [0, 2], [2, 2], [2, 0], [0, 0]]))
    assert (curve.length, curve.closed) == (8, True)
    np.testing.assert_allclose(curve.at(np.array(7.0)), [1, 0])


def test_spline_of_a_circle() -> None:
    angle = np.linspace(0, 2 * np.pi, 17)[:-1]
    points = np.stack([2 * np.sin(angle), 2 * np.cos(angle)], axis=-1)
    curve = make_curve(make_sketch(points, spline=True, closed=True))
    assert curve.length == pytest.approx(4 * np.pi, rel=1e-3)
    np.testing.assert_allclose(np.linalg.norm(curve.points, axis=1), 2, atol=2e-3)
    for point in points:
        assert np.linalg.norm(curve.points - point, axis=1).min() < 1e-6
    steps = np.linalg.norm(np.diff(curve.at(np.linspace(0, curve.length, 200)), axis=0), axis=1)
    np.testing.assert_allclose(steps, curve.length / 199, rtol=1e-3)
    assert curve.start()[0] == pytest.approx(np.pi / 2, abs=0.06)
