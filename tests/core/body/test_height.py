"""How large a body is, and what of settings is scaled with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core.body.height import ADULT_M, body_height, body_scale
from mgjax.core.body.sized import sized
from mgjax.core.skeleton import Skeleton
from tests.sized import body_of_size


def test_the_scale_of_a_body():
    embedded = synthetic_skeleton()
    assert body_height(embedded) == pytest.approx(ADULT_M, abs=1e-3)
    assert body_scale(embedded) == pytest.approx(1, abs=1e-3)
    for size in (0.1, 0.6, 1.3, 3.0):
        assert body_scale(body_of_size(embedded, size)) == pytest.approx(
            size * body_scale(embedded), rel=1e-5
        )


def test_what_is_no_body_has_the_scale_1():
    offsets = np.array([[0, 0, 0], [0, 5, 0]], np.float32)
    stick = Skeleton(names=("root", "tip"), parents=(-1, 0), offsets=offsets, end_joints=(1,))
    assert body_height(stick) is None
    assert body_scale(stick) == 1


@dataclass(frozen=True, kw_only=True)
class _Settings:
    height_m: float = 0.5
    speeds: tuple[float, ...] = (1.0, 2.0)
    limit_m: float | None = None
    seconds: float = 3.0


def test_only_what_is_named_is_scaled():
    got = sized(_Settings(), ("height_m", "speeds", "limit_m"), 2.0)
    assert got == _Settings(height_m=1.0, speeds=(2.0, 4.0))
    assert sized(_Settings(), ("height_m",), 1.0) == _Settings()
