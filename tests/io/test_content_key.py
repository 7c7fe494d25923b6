from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.io.content_key import content_key


@dataclass
class Pair:
    a: object
    b: object


def test_equal_content_has_one_key():
    array = np.arange(6.0).reshape(2, 3)
    assert content_key(array) == content_key(array.copy())
    assert content_key(array.T) == content_key(np.ascontiguousarray(array.T))
    assert content_key({"a": 1, "b": 2}) == content_key({"b": 2, "a": 1})
    assert content_key(np.float32([1, 2])) == content_key(jnp.array([1, 2], jnp.float32))
    assert len(content_key()) == 32


def test_other_content_has_other_keys():
    array = np.arange(6.0)
    parts = [
        (array,),
        (array.reshape(2, 3),),
        (array.reshape(3, 2),),
        (array.astype(np.float32),),
        (array + 1e-12,),
        (np.zeros(0),),
        (np.zeros((0, 3)),),
        (1,),
        (1.0,),
        (True,),
        ("1",),
        (b"1",),
        (None,),
        (),
        ([],),
        ({},),
        ("ab", "c"),
        ("a", "bc"),
        (["a", "b"], "c"),
        (["a"], ["b"], "c"),
        (Pair(1, 2),),
        (Pair(2, 1),),
        ([1, 2],),
    ]
    assert len({content_key(*each) for each in parts}) == len(parts)


def test_what_has_no_content_has_no_key():
    with pytest.raises(TypeError, match="got set"):
        content_key({1, 2})
