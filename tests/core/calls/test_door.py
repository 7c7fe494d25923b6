"""Wrong calls of public functions: one sentence with what was got and what is expected."""

from __future__ import annotations

import importlib
import inspect
import pickle
import typing
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Bool, Float, Int

import mgjax
from mgjax import ballsport, hybrid
from mgjax.core.arrays import Array
from mgjax.core.calls.door import door
from mgjax.core.errors import ArgumentError, MotionError
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton

PACKAGES = (
    "mgjax",
    "mgjax.avoidance",
    "mgjax.ballsport",
    "mgjax.clips",
    "mgjax.graph",
    "mgjax.hybrid",
    "mgjax.pictures",
    "mgjax.quality",
)


ANYTHING = {"thing", "points", "speed", "obstacles", "place", "track", "when", "hold_s"}
"""Arguments that functions look at themselves: what is drawn by hand, and what can be shown."""


class Stranger:
    """What no function takes."""


def arguments() -> Iterator[tuple[str, str, Any]]:
    """Package and function, argument and annotation of all public functions."""
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in dir(module):
            found = getattr(module, name)
            if isinstance(found, type) or not callable(found):
                continue
            function = inspect.unwrap(found)
            if inspect.isfunction(function):
                for argument, hint in typing.get_type_hints(function, include_extras=True).items():
                    if argument != "return":
                        yield f"{package}.{name}", argument, hint


ARGUMENTS = list(arguments())
CHECKED = [each[:2] for each in ARGUMENTS if each[2] is not Any]


def test_all_rooms_are_there():
    assert len({name for name, _, _ in ARGUMENTS}) > 60
    assert {argument for _, argument, hint in ARGUMENTS if hint is Any} == ANYTHING


@pytest.mark.parametrize(("name", "argument"), CHECKED)
def test_no_public_function_takes_a_stranger(name: str, argument: str):
    package, _, short = name.rpartition(".")
    function = getattr(importlib.import_module(package), short)
    with pytest.raises(ArgumentError) as caught:
        function(**{argument: Stranger()})
    assert str(caught.value).startswith(f"{short}({argument}): got a Stranger, expected ")
    assert caught.value.got == "a Stranger"
    assert "\n" not in str(caught.value)


Frames = Float[np.ndarray, "F 3"]


def mean_place(
    places: Float[Array, "F 3"],
    mask: Bool[Array, " F"] | None = None,
    *,
    joint: int = 0,
    rate: float = 30.0,
    edges: Sequence[int] | Int[np.ndarray, " E"] = (),
    ends: tuple[int, ...] = (),
    span: tuple[float, float] = (0.0, 1.0),
    kind: Literal["a", "b"] = "a",
    exact: bool = False,
    then: Callable[[float], float] | None = None,
) -> Any:
    """For the tests."""
    return locals()


LOOKED_AT = door(mean_place, __name__, "mean_place")


def test_lists_and_whole_numbers_become_arrays():
    got = LOOKED_AT([[0, 0, 0], [1, 2, 3]], [True, False], ends=[1, 2], edges=[3])
    assert got["places"].dtype == np.float32
    assert got["places"].tolist() == [[0, 0, 0], [1, 2, 3]]
    assert got["mask"].dtype == np.bool_
    assert got["ends"] == (1, 2)
    assert got["edges"] == [3]


def test_what_is_right_is_handed_on_as_it_is():
    places, count = jnp.zeros((4, 3)), np.int64(2)
    got = LOOKED_AT(places, joint=count, rate=2, span=[0, 1], kind="b", exact=True, then=abs)
    assert got["places"] is places
    assert (got["joint"], got["rate"], got["span"]) == (2, 2, (0, 1))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"places": [[0, 0]]}, "places): got an array of float32[1, 2], expected numbers"),
        ({"places": [[0, 0, np.nan]]}, "got a value that is not finite, expected nothing but"),
        ({"places": [[0], [0, 1]]}, "places): got rows that differ in length, expected"),
        ({"places": "abc"}, "places): got 'abc', expected numbers of shape [F, 3]"),
        ({"places": np.zeros((2, 3), bool)}, "places): got an array of bool[2, 3], expected numb"),
        ({"places": np.zeros((2, 3)), "mask": [True]}, "expected booleans of shape [F] with F = 2"),
        ({"places": np.array([["a"] * 3])}, "places): got an array of <U1[1, 3], expected numb"),
        ({"places": np.zeros((1, 3), complex)}, "got an array of complex128[1, 3], expected num"),
        ({"kind": np.zeros(2)}, "kind): got an array of float64[2], expected 'a' or 'b'"),
        ({"mask": np.ones(3)}, "mask): got an array of float64[3], expected booleans of shape [F]"),
        ({"joint": 1.5}, "joint): got 1.5, expected a whole number"),
        ({"joint": True}, "joint): got True, expected a whole number"),
        ({"joint": np.arange(2)}, "joint): got an array of int64[2], expected a whole number"),
        ({"rate": "30"}, "rate): got '30', expected a number"),
        ({"rate": np.nan}, "rate): got nan, expected nothing but finite numbers"),
        ({"rate": [1, 2]}, "rate): got a list, expected a number"),
        ({"edges": 3}, "edges): got 3, expected a sequence of whole numbers or"),
        ({"edges": [1, 2.5]}, "edges): got 2.5 at 1, expected a whole number or"),
        ({"ends": ["left"]}, "ends): got 'left' at 0, expected a whole number"),
        ({"span": [1, 2, 3]}, "span): got a list, expected (float, float)"),
        ({"kind": "c"}, "kind): got 'c', expected 'a' or 'b'"),
        ({"exact": 1}, "exact): got 1, expected True or False"),
        ({"then": 3}, "then): got 3, expected a function or None"),
    ],
)
def test_the_sentence(given: dict[str, Any], words: str):
    with pytest.raises(ArgumentError) as caught:
        LOOKED_AT(**given)
    assert words in str(caught.value)
    assert str(caught.value).startswith("mean_place(")


def test_tracers_pass_and_their_shapes_are_looked_at():
    physics = ballsport.BallPhysics()
    start, velocity = jnp.array([0.0, 1.0, 0.0]), jnp.array([3.0, 4.0, 0.0])
    times = jnp.linspace(0.0, 1.0, 8)

    def flown(velocity: Any) -> Any:
        return ballsport.fly(start, velocity, times, physics=physics)

    plain = ballsport.fly([0, 1, 0], [3, 4, 0], times.tolist(), physics=physics)
    np.testing.assert_array_equal(jax.jit(flown)(velocity), plain)
    assert np.isfinite(jax.jacfwd(flown)(velocity)).all()
    parts = jax.grad(
        lambda x: ballsport.fly([x, 1, 0], [3, 4, 0], [0.5], physics=physics).sum()  # pyright: ignore
    )
    assert np.isfinite(parts(1.0))  # a list of numbers, some of them traced
    many = jax.vmap(flown)(jnp.stack([velocity, velocity]))
    np.testing.assert_allclose(many[0], plain, atol=1e-6)
    with pytest.raises(ArgumentError, match=r"fly\(velocity\): got an array of float32\[2\]"):
        jax.jit(flown)(velocity[:2])


def test_public_functions_are_pickled_lowered_and_described_as_before():
    assert pickle.loads(pickle.dumps(hybrid.fabrik)) is hybrid.fabrik
    assert hybrid.fabrik is hybrid.fabrik
    assert "Moves the joints of chains" in (hybrid.fabrik.__doc__ or "")
    assert list(inspect.signature(hybrid.fabrik).parameters)[:2] == ["joints", "target"]
    lower: Any = getattr(hybrid.fabrik, "lower", None)
    assert "func" in lower(jnp.zeros((4, 3)), jnp.ones(3)).as_text()


def test_a_missing_argument_remains_pythons_error():
    with pytest.raises(TypeError, match="target"):
        hybrid.fabrik(np.zeros((4, 3)))  # pyright: ignore[reportCallIssue]
    with pytest.raises(ArgumentError, match="at least two"):
        hybrid.fabrik(np.zeros((1, 3)), np.zeros(3))


def test_a_motion_belongs_to_its_skeleton(body: Skeleton, random_motion: Callable[..., Motion]):
    skeleton, motion = body, random_motion(body)
    rotations = np.asarray(motion.local_rotations)
    fewer = replace(motion, local_rotations=rotations[:, :-1])
    with pytest.raises(MotionError, match="global_positions: rotations have shape"):
        mgjax.global_positions(skeleton, fewer)
    with pytest.raises(MotionError, match="length 3 at joint 0 in frame 0, expected unit"):
        mgjax.global_positions(skeleton, replace(motion, local_rotations=3 * rotations))
    as_list: Any = rotations.tolist()
    with pytest.raises(MotionError, match="local_rotations as a list, expected an array"):
        mgjax.global_positions(skeleton, _unchecked(motion, as_list))


def _unchecked(motion: Motion, rotations: Any) -> Motion:
    made = object.__new__(Motion)
    for name in ("root_translation", "frame_rate", "joint_offsets"):
        object.__setattr__(made, name, getattr(motion, name))
    object.__setattr__(made, "local_rotations", rotations)
    return made
