"""Traced programs kept on disk: found by another process, told apart, never wrong."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.core.xla.exported import _KEPT, _folder, exported
from mgjax.core.xla.pytree import register


@register()
@dataclass(frozen=True, kw_only=True)
class Pair:
    total: jax.Array
    parts: tuple[jax.Array, jax.Array]


TRACED: list[str] = []


@exported("power")
def sums(x: jax.Array, by: dict[str, jax.Array], *, power: int) -> Pair:
    TRACED.append(f"{power} {x.shape}")
    scaled = x**power * by["factor"]
    return Pair(total=scaled.sum(), parts=(scaled, jnp.sin(scaled)))


def fresh(x: np.ndarray, factor: float | np.float32, power: int) -> Pair:
    """As a new process has it: jax has not traced anything yet."""
    call = jax.jit(lambda *args, **named: sums(*args, **named), static_argnames="power")
    return call(x, {"factor": factor}, power=power)


@pytest.fixture(autouse=True)
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("MGJAX_CACHE", str(tmp_path))
    monkeypatch.setattr("mgjax.core.xla.exported._source", lambda: "this")
    before = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    jax.config.update("jax_compilation_cache_dir", str(tmp_path / "jax"))
    TRACED.clear()
    yield tmp_path
    jax.config.update("jax_compilation_cache_dir", before)


def test_the_second_does_not_trace() -> None:
    x = np.array([0.5, 1.0, -2.0], np.float32)
    first, second = fresh(x, 3.0, 2), fresh(x, 3.0, 2)
    assert TRACED == ["2 (3,)"]
    for found in (first, second):
        np.testing.assert_allclose(found.parts[0], [0.75, 3.0, 12.0])
        np.testing.assert_allclose(found.total, 15.75)
        np.testing.assert_allclose(found.parts[1], np.sin([0.75, 3.0, 12.0]), rtol=1e-6)
    other = fresh(x + 1, -1.0, 2)  # numbers are no part of a program
    assert len(TRACED) == 1
    np.testing.assert_allclose(other.parts[0], [-2.25, -4.0, -1.0])


def test_shapes_types_and_static_arguments_tell_programs_apart() -> None:
    x = np.array([1.0, 2.0], np.float32)
    np.testing.assert_allclose(fresh(x, 1.0, 2).total, 5.0)
    np.testing.assert_allclose(fresh(x, 1.0, 3).total, 9.0)
    np.testing.assert_allclose(fresh(np.append(x, 3), 1.0, 2).total, 14.0)
    # A Python number is weakly typed: an array of the same type is another program.
    np.testing.assert_allclose(fresh(x, np.float32(2.0), 2).total, 10.0)
    assert len(TRACED) == 4


def test_a_spoiled_file_is_made_anew(empty: Path) -> None:
    x = np.ones(2, np.float32)
    fresh(x, 1.0, 2)
    (path,) = (empty / "programs" / "this").iterdir()
    good = path.read_bytes()
    for content in (good[: len(good) // 2], b"", good[:-1] + bytes([good[-1] ^ 1])):
        path.write_bytes(content)
        np.testing.assert_allclose(fresh(x, 4.0, 2).total, 8.0)
        np.testing.assert_allclose(fresh(x, 5.0, 2).total, 10.0)
    assert len(TRACED) == 4
    assert list(path.parent.iterdir()) == [path]


def test_nothing_is_kept_without_a_cache(empty: Path) -> None:
    jax.config.update("jax_compilation_cache_dir", None)
    x = np.ones(2, np.float32)
    fresh(x, 1.0, 2)
    fresh(x, 1.0, 2)
    assert len(TRACED) == 2
    assert not (empty / "programs").exists()


def test_without_jit_it_is_the_function_itself(empty: Path) -> None:
    with jax.disable_jit():
        np.testing.assert_allclose(fresh(np.ones(2, np.float32), 3.0, 2).total, 6.0)
    assert TRACED == ["2 (2,)"]
    assert not (empty / "programs").exists()


def test_a_cache_that_cannot_be_written_is_left_alone(
    empty: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (empty / "file").write_text("no folder")
    monkeypatch.setenv("MGJAX_CACHE", str(empty / "file"))
    np.testing.assert_allclose(fresh(np.ones(2, np.float32), 3.0, 2).total, 6.0)


def test_old_versions_are_removed(empty: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    x = np.ones(2, np.float32)
    for number in range(_KEPT + 2):
        monkeypatch.setattr("mgjax.core.xla.exported._source", lambda n=number: f"version{n}")
        _folder.cache_clear()
        fresh(x, 1.0, 2)
    assert len(list((empty / "programs").iterdir())) == _KEPT
    assert (empty / "programs" / f"version{_KEPT + 1}").is_dir()
